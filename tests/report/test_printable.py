"""Words that cannot be printed are refused, and those that can be are printed whole and within the page."""

import io
import re
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pypdf
import pytest
import typst
from helpers.results import result_file

from breastrig.core.errors import BadInput
from breastrig.core.identity import Identity, one_line
from breastrig.files.result import patient_of
from breastrig.report.document import PlannedItem, Reported
from breastrig.report.measures import measures
from breastrig.report.pages import printable
from breastrig.report.pages.pdf import report_pdf
from breastrig.report.stance import Stance
from breastrig.rig.model import Rig

SHIPPED = ["Ωμέγα", "Иванова", "ישראל", "العربية", "Հայ", "ქართული", "Läsion ß ø ł ő ı", "≤ 5 mm ± 2 → ½"]
NOT_SHIPPED = ["山田", "不要切除左侧", "환자", "ห้าม", "తెలుగు", "🙂"]


@pytest.fixture
def reported(toy_rig: Rig) -> Reported:
    stance = Stance(toy_rig, np.array(toy_rig.template), np.array(toy_rig.template), toy_rig.faces, "standing")
    return Reported("standing", stance, result_file(), measures(stance))


@pytest.fixture
def no_packs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(printable, "font_folders", lambda: [])
    printable._without_glyph.cache_clear()


@pytest.mark.usefixtures("no_packs")
@pytest.mark.parametrize("text", SHIPPED)
def test_scripts_of_the_fonts_that_are_there_are_printed(text: str) -> None:
    assert printable.unprintable(text) == ""


@pytest.mark.usefixtures("no_packs")
@pytest.mark.parametrize("text", NOT_SHIPPED)
def test_a_code_a_note_or_a_name_that_would_be_boxes_is_refused_by_its_characters(
    reported: Reported, text: str
) -> None:
    named = re.escape(text[0])
    with pytest.raises(BadInput, match=f"code has characters that the report cannot print: {named}"):
        report_pdf([reported], Identity(text))
    note = replace(reported, plan=(PlannedItem("n", "Note", text=text),))
    with pytest.raises(BadInput, match="cannot print"):
        report_pdf([note], Identity("K7"))


@pytest.mark.skipif(find_spec("justmytype_intl_cjk") is None, reason="breastrig[fonts] is not installed")
@pytest.mark.parametrize("text", ["山田", "不要切除左侧", "환자"])
def test_with_the_fonts_they_are_printed(reported: Reported, text: str) -> None:
    content = report_pdf([reported], Identity(text))
    assert text in pypdf.PdfReader(io.BytesIO(content)).pages[0].extract_text()


@pytest.mark.parametrize("hidden", ["\u202e", "\u200b", "\u2066", "\ufeff", "\u00ad", "\u3164", "\u2028", "\U000e0041"])
def test_what_nobody_sees_is_in_no_code(hidden: str) -> None:
    with pytest.raises(BadInput, match=rf"nobody sees \(U\+{ord(hidden):04X}\)"):
        one_line(f"A{hidden}1")
    with pytest.raises(BadInput, match="nobody sees"):
        patient_of(f"A{hidden}1", None)


def test_one_code_is_one_however_its_letters_are_composed() -> None:
    assert one_line("Mu\u0308ller  7") == one_line("M\u00fcller 7") == "M\u00fcller 7"


def test_a_predicted_body_is_marked_and_has_nothing_to_sign(reported: Reported) -> None:
    def words(one: Reported) -> str:
        pages = pypdf.PdfReader(io.BytesIO(report_pdf([one]))).pages
        return " ".join(" ".join(page.extract_text() for page in pages).split())

    predicted = replace(reported, result=result_file(predicted=True), stance=replace(reported.stance, predicted=True))
    assert "Checked on the patient by" in words(reported)
    assert "NOT SCANNED" not in words(reported)
    text = words(predicted)
    assert "Checked on the patient by" not in text
    assert "signature" not in text
    assert text.count("PREDICTED, NOT SCANNED") >= 2  # on each picture


def test_long_words_stay_within_the_margins() -> None:
    """As the template's rule breaks them."""
    template = (Path(printable.__file__).parent / "report.typ").read_text()
    rule = next(line for line in template.splitlines() if line.startswith("#show regex"))
    page = (
        f"{rule}\n#set page(width: 60mm, height: auto, margin: 5mm)\n#table(columns: (20mm, 1fr), [a], sys.inputs.word)"
    )
    drawn = typst.compile(page.encode(), sys_inputs={"word": "W" * 200}, ignore_system_fonts=True)
    sizes = [page.mediabox.height for page in pypdf.PdfReader(io.BytesIO(drawn)).pages]
    assert max(sizes) > 100.0  # several lines

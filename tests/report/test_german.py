"""The pages in German: no English word is left, numbers and days are German; what people wrote is as it was."""

import io
import re
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pypdf
from helpers.results import TO_LANDMARKS, result_file

from breastrig.core.identity import Identity
from breastrig.geometry.polyline import Polyline
from breastrig.languages.translation import Typed
from breastrig.report.document import PlannedItem, Reported
from breastrig.report.measures import measures
from breastrig.report.pages.pdf import report_pdf
from breastrig.report.pages.protocol import protocol_pdf
from breastrig.report.stance import Stance
from breastrig.rig.model import Rig

WORDS = "the is of and not this with from to or no it are by left right nipple skin see line mean page made"
ENGLISH = rf".{{0,40}}\b(?:{WORDS.replace(' ', '|')})\b.{{0,40}}"
NOTE = "Keep the scar, left 4.5 mm of it."


def words(content: bytes) -> str:
    return " ".join(" ".join(page.extract_text() for page in pypdf.PdfReader(io.BytesIO(content)).pages).split())


def test_a_report_has_no_english_word_and_keeps_what_people_wrote(toy_rig: Rig) -> None:
    vertices = np.array(toy_rig.template)
    line = Polyline("wise_fold_L", False, "#c00000", vertices[:4], np.zeros(4, bool))
    stance = Stance(toy_rig, vertices, vertices, toy_rig.faces, "standing", lines=(line,), banded=(line,))
    items = (
        PlannedItem("t", "Tumour, left breast", (("Hour", "10:30"), ("From the nipple", "45.5 mm"))),
        PlannedItem("n", "Note", text=NOTE),
        PlannedItem("l", Typed("the line of 3.5 mm"), said="Not drawn: The scan shows no skin where it is expected."),
    )
    result = result_file(
        landmark_uncertainty_mm={"nipple_L": 12.5},
        landmark_distance_mm=TO_LANDMARKS | {"each": {"nipple_R": 0.7}},
        verdict={"level": "check", "reasons": ["Lines may be far off; place more landmarks by hand."]},
        notes=["There is no table in the scan."],
    )
    both = [
        Reported(name, replace(stance, name=name), result, measures(stance), plan=items)
        for name in ("standing", "supine")
    ]
    made = datetime(2026, 11, 25, 14, 30, 5, tzinfo=UTC)
    identity = Identity("P-12.5", made, ("2026-11-20", ""), True, "2026-11-24", 3)
    text = words(report_pdf(both, identity, "de"))
    assert text.count(NOTE) == 1
    assert "the line of 3.5 mm Nicht gezeichnet: Der Scan zeigt an der erwarteten Stelle keine Haut." in text
    for said in (
        "Patient P-12.5",
        "erstellt am 25.11.2026",
        "stehend, Scan eingegangen 20.11.2026",
        "Plan, Version 3 24.11.2026",
        "Tumor, linke Brust Uhrzeit 10:30 Von der Mamille 45,5 mm",
        "DIESE ANPASSUNG PRÜFEN: siehe Zweifel und Hinweise (stehend)",
        "Stehend: Linien können weit danebenliegen; setzen Sie weitere Landmarken von Hand.",
        "Mamille, rechts Modell 0,7 -",
        "Mamille, links Modell - ±12,5",
    ):
        assert said in text, said
    own = text.replace(NOTE, "").replace("the line of 3.5 mm", "")
    assert re.findall(ENGLISH, own) == []
    assert (
        re.findall(r"\d\.\d", re.sub(r"P-12\.5|\d\d\.\d\d\.\d{4}|BreastRig [\d.]+|Versionen .*?(?= \w{4,})", "", own))
        == []
    )


def test_the_page_for_taking_scans_is_german_on_one_sheet() -> None:
    content = protocol_pdf("de")
    assert len(pypdf.PdfReader(io.BytesIO(content)).pages) == 1
    assert re.findall(ENGLISH, words(content)) == []

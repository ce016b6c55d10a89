"""The pages for rigs and results that are not the usual ones, and what stands on each of them."""

import io
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pypdf
import pytest
from helpers.results import TO_LANDMARKS, result_file

from breastrig.core.identity import Identity
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.geometry.polyline import Polyline
from breastrig.report.document import PlannedItem, Reported, report_document, stance_names
from breastrig.report.measures import measures
from breastrig.report.pages.names import spoken, spoken_together
from breastrig.report.pages.pdf import report_pdf
from breastrig.report.stance import Stance
from breastrig.report.table import Row, Value
from breastrig.rig.model import Rig


@pytest.fixture
def toy_stance(toy_rig: Rig) -> Stance:
    return Stance(toy_rig, np.array(toy_rig.template), np.array(toy_rig.template), toy_rig.faces, "standing")


def pages(content: bytes) -> list[str]:
    return [page.extract_text() for page in pypdf.PdfReader(io.BytesIO(content)).pages]


def words(content: bytes) -> str:
    return " ".join(" ".join(pages(content)).split())


def shown(stance: Stance, name: str = "standing", **changes: object) -> Reported:
    return Reported(name, stance, result_file(**changes), measures(stance))


def test_every_page_says_whose_it_is_of_when_and_has_room_for_a_signature(toy_stance: Stance) -> None:
    made = datetime(2026, 11, 25, 14, 30, 5, tzinfo=UTC)
    identity = Identity("K7M-4QX", made, ("2026-11-20", "2026-11-21"), True, "2026-11-24", 3)
    content = report_pdf(
        [shown(toy_stance, notes=[f"Remark {k}." for k in range(99)]), shown(toy_stance, "supine")], identity
    )
    assert content == report_pdf(
        [shown(toy_stance, notes=[f"Remark {k}." for k in range(99)]), shown(toy_stance, "supine")], identity
    )
    texts = [" ".join(page.split()) for page in pages(content)]
    assert len(texts) > 2
    for number, text in enumerate(texts, 1):
        for said in (
            "Patient K7M-4QX",
            "made 2026-11-25",
            "standing, scan received 2026-11-20",
            "supine, scan received 2026-11-21",
            "plan, version 3 2026-11-24",
            "signature",
            LIMITS_OF_USE,
            f"page {number} of {len(texts)}",
        ):
            assert text.count(said) == 1, said
    assert all(f"Remark {k}." in " ".join(texts) for k in range(99))
    reader = pypdf.PdfReader(io.BytesIO(content))
    assert reader.metadata.creation_date == made


def test_a_fit_to_be_checked_is_marked_as_such_on_every_page_in_whatever_letters(toy_stance: Stance) -> None:
    doubts = [{"names": ["nipple_L"], "reason": f"Place № {k} lies “far” – 12 mm − #[off] *it*."} for k in range(80)]
    verdict = {"level": "unusable", "reasons": ["It lies elsewhere."]}
    bad = shown(toy_stance, landmarks_not_followed=doubts, verdict=verdict)
    content = report_pdf([bad, shown(toy_stance, "supine")])
    text = words(content)
    assert all(f"Place № {k} lies “far” – 12 mm − #[off] *it*." in text for k in range(80))
    warned = "NOT USABLE: see doubts and notes (standing)"  # each page may be printed alone
    assert [text.count(warned) for text in pages(content)] == [1] * len(pages(content))
    assert "(supine)" not in text


def test_the_plan_stands_on_the_first_page_in_words_and_numbers_each_item_once(toy_stance: Stance) -> None:
    tumour = PlannedItem("t", "Tumour, left breast", (("Hour", "10:30"), ("From the nipple", "45 mm")))
    note = PlannedItem("n", "Note", text="Keep the scar.")
    lesion = [
        PlannedItem("m", "Lesion", (("Radius", "8 mm"), ("Depth", deep), ("As drawn", "a"), ("As drawn", "b")))
        for deep in ("30 mm", "9 mm")
    ]
    both = [replace(shown(toy_stance, name), plan=(tumour, note)) for name in ("standing", "supine")]
    text = " ".join(pages(report_pdf(both))[0].split())
    assert text.count("Tumour, left breast Hour 10:30 From the nipple 45 mm") == 1
    assert text.count("Keep the scar.") == 1
    both = [replace(one, plan=(*one.plan, item)) for one, item in zip(both, lesion, strict=True)]
    text = " ".join(pages(report_pdf(both))[0].split())
    assert "Lesion Radius 8 mm Depth 30 mm standing, 9 mm supine As drawn a As drawn b" in text
    both[1] = replace(both[1], plan=(replace(tumour, text="It could not be carried."), note))
    assert "45 mm It could not be carried." in " ".join(pages(report_pdf(both))[0].split())


def test_each_lesion_has_its_numbers_and_slices_for_each_stance(toy_stance: Stance) -> None:
    ways = [
        ("skin", "skin", 12.2, 8.0, 17.4),
        ("nipple", "nipple_L", 40.0, None, None),
        ("line", "cut", 9.0, 5.0, 13.0),
    ]
    slices = [{"plane": "axial", "outlines_mm": [[[-90.0, 10.0], [0.0, 20.0], [90.0, 10.0]]], "wall_mm": []}]
    given = {
        "id": "m", "name": "MRI 1", "radius_mm": 6.5, "error_mm": 0.0, "carried": False, "seen": True, "slices": slices,
        "distances": [dict(zip(("kind", "to", "mm", "low_mm", "high_mm"), way, strict=True)) for way in ways],
    }  # fmt: skip
    carried = given | {"carried": True, "error_mm": 8.6, "seen": False, "distances": given["distances"][:1]}
    both = [
        replace(shown(toy_stance, name), lesions=(lesion,))
        for name, lesion in (("standing", given), ("supine", carried))
    ]
    text = " ".join(" ".join(pages(report_pdf(both))).split())
    assert (
        "Lesion: MRI 1 standing radius 6.5 mm to the skin 12 mm, 8 to 17 to the nipple, left 40 mm "
        "to Cut 9 mm, 5 to 13 its place as given axial supine radius 6.5 mm to the skin 12 mm, 8 to 17 "
        "its place ± 9 mm The scan shows no skin next to it: its depth is the model's guess. axial" in text
    )


def test_each_landmark_has_its_source_its_distance_and_the_radius_that_holds_its_true_place(toy_stance: Stance) -> None:
    radii = {"suprasternal_notch": 4.25, "nipple_L": 12.5}
    distances = TO_LANDMARKS | {"each": {"suprasternal_notch": 3.1, "nipple_R": 0.7}}
    one = shown(toy_stance, landmark_uncertainty_mm=radii, landmark_distance_mm=distances)
    text = words(report_pdf([one]))
    for row in ("Suprasternal notch model 3.1 ±4.2", "Nipple, left model - ±12.5", "Nipple, right model 0.7 -"):
        assert row in text
    assert report_document([one])["stances"][0]["landmark_uncertainty_mm"] == radii


def test_names_as_people_say_them() -> None:
    assert [spoken(name) for name in ("tumour_L", "tumour_R 2", "wise_L", "my_scar", "cut (standing)")] == [
        "Tumour, left", "Tumour 2, right", "Wise pattern, left", "My scar", "Cut (standing)",
    ]  # fmt: skip
    assert spoken_together(["nipple_L", "xiphoid", "nipple_R", "acromion_L"]) == [
        "nipple on both sides", "xiphoid", "acromion left",
    ]  # fmt: skip


def test_the_document_keeps_no_times_and_no_landmark_of_the_patient(toy_stance: Stance) -> None:
    document = report_document([Reported("standing", toy_stance, result_file(), measures(toy_stance))])
    assert document["schema"] == "breastrig/report@1"
    assert "timing_s" not in str(document)


def test_stances_are_distinguished() -> None:
    assert stance_names(["standing"]) == ["standing"]
    assert stance_names(["standing", "supine"]) == ["standing", "supine"]
    assert stance_names(["supine", "supine"]) == ["supine A", "supine B"]


def test_the_pictures_look_is_said_in_one_line_with_the_least_sure_line(toy_stance: Stance) -> None:
    points = np.array(toy_stance.vertices[:3])
    seen = np.zeros(3, dtype=np.bool_)
    sure, unsure = (Polyline(name, False, "#101010", points, seen, error=np.full(3, mm)) for name, mm in LINES_M)
    one = replace(toy_stance, lines=(sure, unsure), banded=(sure, unsure))
    text = words(report_pdf([shown(one)]))
    grey = "Grey: holds the true line nine times in ten"
    assert f"{grey}; the least sure line: New fold, left, ± 14 mm." in text
    assert "hatched" not in text
    part = replace(unsure, error=np.array([0.02, np.nan, 0.02]), bridged=~seen)
    text = words(report_pdf([shown(replace(one, lines=(sure, part), banded=(sure, part)))]))
    assert f"{grey}; hatched: not known; dashed: no scan shows the skin there; the least sure line" in text


LINES_M = (("wise_L", 0.01), ("wise_fold_L", 0.02))


def test_a_number_less_sure_than_a_tenth_of_itself_is_not_said_on_paper(toy_stance: Stance) -> None:
    vague, sure = Value(50.0, 44.0, 56.0), Value(151.0, 148.0, 154.0)
    rows = [
        Row("a", "Both vague", "straight", "mm", vague, vague, None, (), "", vague=("left", "right", "difference")),
        Row("b", "Left vague", "straight", "mm", vague, sure, None, (), "", vague=("left", "difference")),
    ]
    text = words(report_pdf([replace(shown(toy_stance), rows=tuple(rows))]))
    assert "Both vague not known well enough Left vague not known well enough 151 ±3 not known well enough" in text

"""The two pages for rigs and results that are not the usual ones."""

import dataclasses
import io

import numpy as np
import pypdf
import pytest

from breastrig.geometry.polyline import Polyline
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.document import Reported, report_document, stance_names
from breastrig.report.measures import measures
from breastrig.report.pages.page import latin
from breastrig.report.pages.sentences import methods
from breastrig.report.pdf import report_pdf
from breastrig.report.stance import Stance
from breastrig.rig.model import Rig

NONE = {"mean": None, "std": None, "max": None, "p95": None}


def result(**changes: object) -> dict[str, object]:
    """A result.json of a fit that found nothing."""
    plain = {
        "scan": {"vertices": 204, "triangles": 384, "unit": "mm", "sha256": "ab" * 32},
        "model": {"name": "toy", "bones": 4, "blendshapes": 4, "sha256": "cd" * 32},
        "stance": "standing",
        "preset": "default",
        "stop_reason": "Stalled.",
        "iterations": 3,
        "surface_distance_mm": NONE | {"coverage": 0.0},
        "scan_to_model_mm": NONE,
        "landmark_distance_mm": NONE | {"each": {}},
        "landmarks_not_followed": [],
        "notes": [],
        "versions": {"breastrig": "0"},
        "timing_s": {"total": 1.0},
    }
    return plain | changes


@pytest.fixture
def toy_stance(toy_rig: Rig) -> Stance:
    return Stance(toy_rig, np.array(toy_rig.template), np.array(toy_rig.template), toy_rig.faces, "standing")


def pages(content: bytes) -> list[str]:
    return [page.extract_text() for page in pypdf.PdfReader(io.BytesIO(content)).pages]


def test_a_rig_without_breasts_and_a_fit_without_landmarks(toy_stance: Stance) -> None:
    texts = pages(report_pdf([Reported("standing", toy_stance, result(), measures(toy_stance))]))
    assert len(texts) == 2
    assert "the scan shows no skin near the model" in texts[0]
    assert "Volume" not in texts[1]
    assert "Base width" not in texts[1]
    assert "no landmarks were picked" in texts[1]
    assert "the model's own place was taken for" in texts[1]
    assert "taken for suprasternal notch, nipple on both sides" in texts[1]


def test_no_doubt_of_a_long_list_is_left_out_and_all_is_in_letters_that_can_be_printed(toy_stance: Stance) -> None:
    doubts = [
        {"names": ["nipple_L"], "reason": f"nipple_L № {k} lies “far” – 12 mm − from the rest."} for k in range(99)
    ]
    verdict = {"level": "unusable", "reasons": ["It lies elsewhere."]}
    shown = Reported(
        "standing", toy_stance, result(landmarks_not_followed=doubts, verdict=verdict), measures(toy_stance)
    )
    texts = pages(report_pdf([shown, dataclasses.replace(shown, name="supine", result=result())]))
    words = " ".join(" ".join(texts).split())
    assert all(words.count(f'nipple_L ? {k} lies "far" - 12 mm - from the rest.') >= 1 for k in range(99))
    assert methods([shown]) in words
    assert "..." not in words
    assert [f"page {k + 1} of {len(texts)}" in text for k, text in enumerate(texts)] == [True] * len(texts)
    warned = "NOT USABLE: see doubts and notes (standing)"  # on every page: each may be printed alone
    assert [text.count(warned) for text in texts] == [1] * len(texts)
    assert "(supine)" not in " ".join(text.partition(warned)[2] for text in texts)


def test_a_short_report_has_its_words_below_the_numbers(toy_stance: Stance) -> None:
    shown = Reported("standing", toy_stance, result(), measures(toy_stance))
    texts = pages(report_pdf([shown]))
    assert len(texts) == 2
    assert methods([shown]) in " ".join(texts[1].split())


def test_words_that_the_numbers_leave_no_room_for_stand_below_the_tape_sheet_and_take_no_page_of_their_own() -> None:
    rig = read_rig(default_rig_path())
    marks = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))
    line = Polyline("cut", False, "#000000", marks["mid_sternum"][None], np.zeros(1, np.bool_))
    notes = [f"Remark {k} of a scan that has much to be said of." for k in range(55)]
    plain = Stance(rig, rig.template, rig.template, rig.faces, "standing")
    without = Reported("standing", plain, result(notes=notes), measures(plain))
    assert methods([without]) in " ".join(pages(report_pdf([without]))[2].split()), "here it needs a page of its own"
    tape = Reported("standing", dataclasses.replace(plain, lines=(line,)), result(notes=notes), measures(plain))
    texts = pages(report_pdf([tape]))
    assert len(texts) == 3
    assert "Tape sheet" in texts[2]
    assert methods([tape]) in " ".join(texts[2].split())
    assert [f"page {k + 1} of 3" in text for k, text in enumerate(texts)] == [True] * 3
    more = Reported("standing", tape.stance, result(notes=3 * notes), tape.rows)
    texts = pages(report_pdf([more]))
    assert "Tape sheet" in texts[-1]
    assert "Remark 54" not in texts[-1], "doubts stand before it"


def test_what_the_plan_says_stands_there_also_where_nothing_is_measured_by_the_tape(toy_stance: Stance) -> None:
    remarks = ("Note: keep the scar.", "tumour lies 12 mm below the skin.", "wise_L could not be carried.")
    planned = dataclasses.replace(toy_stance, remarks=remarks)
    texts = pages(report_pdf([Reported("standing", planned, result(), measures(planned))]))
    assert all(remark in " ".join(texts[1].split()) for remark in remarks)


def test_unusual_picks_stand_among_the_doubts(toy_stance: Stance) -> None:
    unusual = [{"names": ["nipple_L"], "reason": "nipple_L is unusual: 30 mm from where others have it."}]
    shown = Reported("standing", toy_stance, result(landmarks_unusual=unusual), measures(toy_stance))
    assert unusual[0]["reason"] in pages(report_pdf([shown]))[1].replace("\n", " ")
    assert report_document([shown])["stances"][0]["landmarks_unusual"] == unusual


def test_each_landmark_has_its_distance_and_the_radius_that_holds_its_true_place(toy_stance: Stance) -> None:
    radii = {"suprasternal_notch": 4.25, "nipple_L": 12.5}
    distances = NONE | {"each": {"suprasternal_notch": 3.1, "nipple_R": 0.7}}
    known = result(landmark_uncertainty_mm=radii, landmark_distance_mm=distances)
    shown = Reported("standing", toy_stance, known, measures(toy_stance))
    _, text = pages(report_pdf([shown]))
    assert "holds the true place with 90 %" in text
    assert "standing 3.1 ± 4.2 ± 12.5 0.7" in text
    assert report_document([shown])["stances"][0]["landmark_uncertainty_mm"] == radii
    plain = Reported("standing", toy_stance, result(landmark_distance_mm=distances), measures(toy_stance))
    assert "90 %" not in pages(report_pdf([plain]))[1]


def test_the_document_keeps_no_times_and_no_landmark_of_the_patient(toy_stance: Stance) -> None:
    document = report_document([Reported("standing", toy_stance, result(), measures(toy_stance))])
    assert document["schema"] == "breastrig/report@1"
    assert "timing_s" not in str(document)


def test_stances_are_told_apart() -> None:
    assert stance_names(["standing"]) == ["standing"]
    assert stance_names(["standing", "supine"]) == ["standing", "supine"]
    assert stance_names(["supine", "supine"]) == ["supine A", "supine B"]


def test_letters_that_the_fonts_lack_are_replaced() -> None:
    assert latin("a − b – “c”\n d … 漢 ±") == 'a - b - "c" d ... ? ±'

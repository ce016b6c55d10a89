"""Drawings, lesions and pictures of finished fits, and the body's frame, as programs have them."""

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.blank_pictures import blank_pictures
from helpers.example_fits import write_example_fits

import breastrig


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> tuple[breastrig.Fit, breastrig.Fit]:
    folder = tmp_path_factory.mktemp("fits")
    write_example_fits(folder)
    return breastrig.Fit.load(folder / "standing"), breastrig.Fit.load(folder / "supine")


Fits = tuple[breastrig.Fit, breastrig.Fit]


def test_the_frame_is_right_handed_and_mirrors_the_body_onto_itself(fits: Fits) -> None:
    frame, marks = fits[0].frame, fits[0].landmarks
    np.testing.assert_allclose(np.cross(frame.left, frame.up), frame.front, atol=1e-12)
    to_left, above, before = (frame.to_body(marks["nipple_L"]) - frame.to_body(marks["umbilicus"])).tolist()
    assert min(to_left, above, before + 0.1 / fits[0].metres_per_unit) > 0.0
    mirrored = frame.mirrored(fits[0].vertices)
    np.testing.assert_allclose(frame.mirrored(mirrored), fits[0].vertices, atol=1e-9)
    np.testing.assert_allclose(frame.to_body(mirrored), frame.to_body(fits[0].vertices) * [-1, 1, 1], atol=1e-9)


def test_a_pattern_is_drawn_as_the_fit_itself_draws_it() -> None:
    example = breastrig.example()
    asked = breastrig.fit(*example, drawing="reduction:areola_mm=42", tumours=["L:10,45,12"])
    later = breastrig.draw(breastrig.fit(*example), "reduction:areola_mm=42", tumours=["L:10,45,12"])
    assert [line.name for line in later.lines] == [line.name for line in asked.drawing.lines]
    for mine, its in zip(later.lines, asked.drawing.lines, strict=True):
        np.testing.assert_allclose(mine.points, its.points, atol=2e-6)
        assert mine.error_mm is not None
        assert its.error_mm is not None
        np.testing.assert_allclose(mine.error_mm, its.error_mm, atol=0.01)


def test_rough_places_become_a_line_on_the_skin(fits: Fits) -> None:
    fit = fits[0]
    rough = np.array([fit.landmarks[name] for name in ("suprasternal_notch", "nipple_L", "umbilicus")])
    rough = rough + 0.02 / fit.metres_per_unit * fit.frame.front  # 20 mm before the skin
    line = breastrig.project(fit, rough, "mine", color="#2040c0")
    apart = 1e3 * fit.metres_per_unit * np.linalg.norm(np.diff(line.points, axis=0), axis=1)
    assert apart.max() < 8.0
    assert line.bridged is not None
    surface = fit.in_metres.fitted_scan.target.search
    off = surface.query(fit.metres_per_unit * line.points[~line.bridged]).distances
    assert off.max() < 1e-5
    assert line.error_mm is not None
    assert np.isfinite(line.error_mm).all()
    assert breastrig.transfer(fit, fits[1], line).lines[0].color == "#2040c0"
    with pytest.raises(breastrig.BadDrawing, match="away from the scan"):
        breastrig.project(fit, rough + 1.0 / fit.metres_per_unit)
    for nothing in (np.zeros((0, 3)), [[np.nan, 0.0, 0.0]], [1.0, 2.0]):
        with pytest.raises(breastrig.BadDrawing):
            breastrig.project(fit, nothing)


def test_what_cannot_be_drawn_is_said_in_a_sentence(fits: Fits) -> None:
    for wrong, said in (
        ("reduction:areola_mm=420", "areola_mm of reduction cannot be 420"),
        ("nothing", "is not a drawing of this model"),
        (breastrig.Lesion("Far", np.full(3, 1e3), 7.0), "outside the skin"),
        (breastrig.Lesion("No place", np.zeros(2), 7.0), "three finite numbers"),
        (breastrig.Line("elsewhere", np.full((2, 3), 1e3)), "away from the scan"),
        (Path("none.json"), "There is no drawing"),
    ):
        with pytest.raises(breastrig.BadDrawing, match=said):
            breastrig.draw(fits[0], wrong)


def test_another_patients_drawing_is_asked_about(fits: Fits) -> None:
    theirs = fits[1].drawing
    with pytest.raises(breastrig.BadInput, match="was made for patient"):
        breastrig.draw(fits[0], theirs)
    own = fits[0].drawing
    again = breastrig.draw(fits[0], own)
    for mine, its in zip(again.lines, own.lines, strict=True):
        np.testing.assert_allclose(mine.points, its.points, atol=2e-6)
    with pytest.raises(breastrig.BadDrawing, match="away from the scan"):  # a person's word does not bring it here
        breastrig.draw(fits[0], theirs, same_patient=True)


def test_a_drawing_without_a_unit_has_that_of_its_scan(fits: Fits) -> None:
    document = {"shapes": [{"name": "mine", "points": fits[0].drawing.lines[0].points.tolist()}]}
    [line] = breastrig.draw(fits[0], document).lines
    np.testing.assert_allclose(line.points, fits[0].drawing.lines[0].points, atol=2e-6)


def test_the_radii_are_those_of_the_result_in_the_scans_unit(fits: Fits) -> None:
    fit = fits[0]
    assert fit.line_error_mm == fit.result["line_error_mm"]
    mm = {name: 1e3 * fit.metres_per_unit * radius for name, radius in fit.landmark_radii.items()}
    assert mm == pytest.approx(fit.result["landmark_uncertainty_mm"])


def test_pictures_show_the_body_and_its_lines(fits: Fits) -> None:
    fit = fits[0]
    bare, drawn = (
        np.asarray(fit.picture("left", show="model", drawing=each, size=(120, 140)))
        for each in (None, breastrig.draw(fit, "mastectomy"))
    )
    assert bare.shape == drawn.shape == (140, 120, 3)
    assert 20 < np.any(bare != drawn, axis=2).sum() < 2000
    body = fit.model.picture(fit.vertices, unit=fit.unit, view="left", size=(120, 140))
    np.testing.assert_array_equal(np.asarray(body), bare)
    different = {
        np.asarray(fit.picture(show=show, size=(60, 60))).tobytes()
        for show in ("distances", "uncertainty", "model", "scan")
    }
    assert len(different) == 4
    with pytest.raises(breastrig.BadSettings, match="view"):
        fit.picture("inside")


def test_a_report_of_fits_in_memory_is_that_of_their_folders(
    fits: Fits, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blank_pictures(monkeypatch)
    pattern = breastrig.draw(fits[0], "tumour:side=L,clock=10,distance_mm=45,radius_mm=12")
    assert breastrig.write_report(fits[0], tmp_path / "memory", fits[1], plan=pattern, code="P-1") == ()
    for fit, name in zip(fits, ("standing", "supine"), strict=True):
        fit.save(tmp_path / name)
    pattern.save(tmp_path / "plan.json")
    breastrig.write_report(
        tmp_path / "standing", tmp_path / "folders", tmp_path / "supine", plan=tmp_path / "plan.json", code="P-1"
    )
    for name in ("report.json", "measures.csv"):
        assert (tmp_path / "memory" / name).read_bytes() == (tmp_path / "folders" / name).read_bytes()
    [pdf] = (tmp_path / "memory").glob("*.pdf")
    assert pdf.name.startswith("P-1_standing-supine")
    with pytest.raises(breastrig.BadInput):
        breastrig.write_report(tmp_path / "standing", tmp_path / "standing" / "result.json")
    [ring] = json.loads((tmp_path / "plan.json").read_text())["shapes"]
    points = [[1e3 * value for value in point] for point in ring["points"]]  # mm
    cut = {"kind": "line", "id": "1", "name": "cut", "points": points, "closed": True, "depth_mm": 25.0}
    (tmp_path / "cut.json").write_text(json.dumps({"schema": "breastrig/plan@1", "unit": "mm", "items": [cut]}))
    breastrig.write_report(tmp_path / "standing", tmp_path / "cut", tmp_path / "supine", plan=tmp_path / "cut.json")
    for stance in json.loads((tmp_path / "cut" / "report.json").read_text())["stances"]:
        [found] = [each for each in stance["resections"] if each["line"] == "cut"]
        assert [row["depth_mm"] for row in found["rows"] if row["planned"]] == [25.0], "where it is carried, too"

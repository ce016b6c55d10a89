"""A prediction is off by what its fit and gravity are off together, and says it alike whatever the scan's unit."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from helpers.written_fit import write_fit

import breastrig
from breastrig.core.glb import split_glb
from breastrig.core.private_files import write_files
from breastrig.core.stances import STANDING, SUPINE
from breastrig.core.units import METRES_PER_UNIT
from breastrig.drawings.line_error import across, carried_errors
from breastrig.drawings.plan_on_scan import PlanOnScan
from breastrig.drawings.plan_schema import PLAN_SCHEMA, checked_plan
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.fitting.uncertainty.radii import line_error
from breastrig.report.body_frame import body_frame
from breastrig.report.files.geometry_files import surface_ply
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import FitFolder, read_fit_folder
from breastrig.use.lines.plan_on_fit import plan_document, plan_on_folders
from breastrig.use.predict import prediction
from breastrig.use.reports.report import stance_of
from breastrig.volume.predicted import predicted

PICKED = ("suprasternal_notch", "nipple_L", "nipple_R", "xiphoid")


def body(rig: Rig) -> np.ndarray:
    """(V, 3) m: she stands elsewhere, turned."""
    turn = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    return np.asarray(rig.template @ turn.T + [0.4, -0.3, 0.7])


def radii_of(rig: Rig) -> np.ndarray:
    """(V,) m: from 4 mm on her right to 24 mm on her left."""
    share = (rig.template[:, 0] - rig.template[:, 0].min()) / np.ptp(rig.template[:, 0])
    return np.asarray(0.004 + 0.02 * share)


Made = Callable[[str], tuple[FitFolder, FitFolder, Path]]


@pytest.fixture(scope="module")
def made(rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> Made:
    """The fit, what is predicted of it lying, and its folder; of a scan in this unit."""
    known: dict[str, tuple[FitFolder, FitFolder, Path]] = {}

    def of_unit(unit: str) -> tuple[FitFolder, FitFolder, Path]:
        if unit not in known:
            folder = tmp_path_factory.mktemp(unit)
            fit = write_fit(folder / "fit", rig, body(rig), radii_of(rig), unit)
            document = json.loads((fit / "result.json").read_text())
            document["landmarks_picked"] = {name: document["landmarks"][name] for name in PICKED}
            document["arm_angles_deg"] = {"L": 20, "R": 22}
            (fit / "result.json").write_text(json.dumps(document))
            (folder / "lying").mkdir()
            write_files(prediction(rig, fit, SUPINE), folder / "lying")
            known[unit] = (read_fit_folder(fit), read_fit_folder(folder / "lying"), folder / "lying")
        return known[unit]

    return of_unit


def test_its_radii_are_the_fits_and_gravitys_errors_together(made: Made, rig: Rig) -> None:
    fit, lying, _ = made("mm")
    alone = predicted(rig, fit.vertices, STANDING, SUPINE)
    assert lying.radii == pytest.approx(np.sqrt(alone.radii**2 + radii_of(rig) ** 2), rel=1e-5)
    points = rig.landmark_points()
    within = dict(zip(rig.landmark_names, points.positions(lying.radii[:, None], rig.faces)[:, 0], strict=True))
    said = lying.result.landmark_uncertainty_mm
    assert said == pytest.approx({name: 1e3 * radius for name, radius in within.items()}, abs=0.006)
    everything = np.ones(len(rig.template), dtype=np.bool_)
    assert lying.result.line_error_mm == pytest.approx(1e3 * line_error(rig, lying.radii, everything), abs=0.06)


@pytest.mark.parametrize("unit", ["mm", "m"])
def test_its_drawing_has_the_predictions_radii_and_not_those_of_the_fit(unit: str, rig: Rig, tmp_path: Path) -> None:
    """Also where the fit's own drawing says of each point what the fit knew there."""
    some = rig.regions["chest"][:5]
    fit = write_fit(tmp_path / "fit", rig, body(rig), radii_of(rig), unit)
    given = json.loads((fit / "drawing.json").read_text())
    (line,) = given["shapes"]
    line["error_mm"] = (1e3 * radii_of(rig)[some]).tolist()
    given["shapes"].append(line | {"name": "bridged", "bridged": [False, True, False, True, False]})
    (fit / "drawing.json").write_text(json.dumps(given))
    made = prediction(rig, fit, SUPINE)
    radii_mm = np.frombuffer(made["uncertainty.bin"], "<f4").astype(float)[some]
    assert (radii_mm > 1e3 * radii_of(rig)[some] + 1.0).all()  # so that one is not the other
    for shape in json.loads(made["drawing.json"])["shapes"]:
        assert shape["error_mm"] == pytest.approx(radii_mm, abs=0.02)
        assert shape["line_error_mm"] == pytest.approx(1e3 * across(1e-3 * radii_mm), abs=0.06)
    result = json.loads(made["result.json"])
    assert result["drawn_line_error_mm"] == pytest.approx(1e3 * across(1e-3 * radii_mm), abs=0.06)


def test_a_fit_that_is_less_sure_predicts_less_surely(rig: Rig, tmp_path: Path) -> None:
    found = []
    for times in (0.0, 1.0, 2.0):
        fit = write_fit(tmp_path / str(times), rig, body(rig), times * radii_of(rig))
        made = prediction(rig, fit, SUPINE)
        found.append(1e-3 * np.frombuffer(made["uncertainty.bin"], "<f4").astype(float))
    sure, usual, unsure = found
    assert (sure > 0.0).all()  # gravity is never known exactly
    assert usual**2 - sure**2 == pytest.approx(radii_of(rig) ** 2, rel=1e-3)
    assert unsure**2 - sure**2 == pytest.approx(4.0 * radii_of(rig) ** 2, rel=1e-3)


@pytest.mark.parametrize("unit", ["m", "cm", "in"])
def test_a_scan_in_another_unit_gives_the_same_prediction(unit: str, made: Made, rig: Rig) -> None:
    times = 0.001 / METRES_PER_UNIT[unit]
    (_, wanted, folder), (_, found, there) = made("mm"), made(unit)
    assert found.vertices == pytest.approx(wanted.vertices, abs=2e-6)
    assert found.surface.vertices == pytest.approx(wanted.surface.vertices, abs=2e-6)
    assert found.radii is not None
    assert found.radii == pytest.approx(wanted.radii, rel=1e-5)
    ours, theirs = found.result, wanted.result
    assert ours.line_error_mm == pytest.approx(theirs.line_error_mm, abs=0.11)
    assert ours.landmark_uncertainty_mm == pytest.approx(theirs.landmark_uncertainty_mm, abs=0.011)
    for one, other in ((ours.landmarks, theirs.landmarks), (ours.landmarks_picked, theirs.landmarks_picked)):
        for name, place in other.items():
            assert one[name] == pytest.approx(times * np.array(place), abs=2e-3 * times)
    lines = [json.loads((each / "drawing.json").read_text())["shapes"][0]["points"] for each in (there, folder)]
    assert np.array(lines[0]) == pytest.approx(times * np.array(lines[1]), abs=2e-3 * times)
    assert ours.median_plane.normal == pytest.approx(theirs.median_plane.normal, abs=1e-6)
    assert ours.median_plane.offset == pytest.approx(times * theirs.median_plane.offset, abs=2e-3 * times)


@pytest.mark.parametrize("unit", ["m", "mm"])
def test_its_plane_is_where_its_middle_is_and_what_was_seen_follows_its_skin(unit: str, made: Made, rig: Rig) -> None:
    fit, lying, folder = made(unit)
    result, frame = lying.result, body_frame(rig, lying.vertices)
    assert fit.result.arm_angles_deg
    assert result.arm_angles_deg == {}  # how the arm will lie is not predicted
    assert result.median_plane.normal == pytest.approx(frame.axes[:, 0], abs=1e-6)
    middle = float(np.array(result.median_plane.normal) @ frame.middle)
    assert fit.metres_per_unit * result.median_plane.offset == pytest.approx(middle, abs=1e-6)
    skin = rig.landmark_points().positions(lying.vertices, rig.faces)
    places = dict(zip(rig.landmark_names, skin / fit.metres_per_unit, strict=True))
    assert {*result.landmarks_picked} == {*PICKED}
    for given in (result.landmarks, result.landmarks_picked):
        for name, place in given.items():
            assert fit.metres_per_unit * np.array(place) == pytest.approx(fit.metres_per_unit * places[name], abs=1e-5)
    (shape,) = json.loads((folder / "drawing.json").read_text())["shapes"]
    assert fit.metres_per_unit * np.array(shape["points"]) == pytest.approx(
        lying.vertices[rig.regions["chest"][:5]], abs=1e-5
    )


def test_what_is_carried_into_a_prediction_has_its_radius_in_full(made: Made, rig: Rig) -> None:
    """It shares nothing with the truth, so nothing of it cancels; between two scans most does."""
    fit, lying, _ = made("mm")
    settings = skin_map_settings(rig)
    assert settings.error_skin is not None
    assert settings.error_share < 1.0
    some = rig.regions["chest"][:20]
    assert fit.fitted_scan.predicted is False
    assert lying.fitted_scan.predicted is True
    found = carried_errors(rig, fit.fitted_scan, lying.fitted_scan, fit.vertices[some], lying.vertices[some])
    shared = settings.error_skin**2 + (settings.error_share * fit.radii[some]) ** 2
    assert found == pytest.approx(np.sqrt(shared + lying.radii[some] ** 2), rel=1e-3)


def test_the_file_of_a_plan_says_what_is_known_of_a_carried_lesion_in_millimetres(made: Made, rig: Rig) -> None:
    fit, lying, _ = made("m")
    nipple = rig.landmark_points(("nipple_L",)).positions(fit.vertices, rig.faces)[0]
    center = 1e3 * (nipple + 0.3 * (fit.vertices[rig.regions["breast_L"]].mean(axis=0) - nipple))
    lesion = {"kind": "lesion", "id": "a", "name": "a", "center": center.tolist(), "radius_mm": 5.0}
    plan = checked_plan({"schema": PLAN_SCHEMA, "unit": "mm", "items": [lesion]})
    found = plan_on_folders(rig, plan, [(lying, ""), (fit, "")], home=1)
    (placed,) = found.lesions
    (said,) = plan_document(plan, lying, found)["lesions"]
    assert said["error_mm"] == pytest.approx(1e3 * placed.error, abs=0.01)
    axes = np.array(said["ellipsoid_mm"])
    assert (axes**2).sum() == pytest.approx(3.0 * said["error_mm"] ** 2, rel=1e-3)  # the ball's, flatter
    assert axes @ axes.T == pytest.approx(np.diag((axes**2).sum(axis=1)), abs=0.1)
    for each, one in zip(said["distances"], placed.distances, strict=True):
        assert each["high_mm"] == pytest.approx(1e3 * (one.length + one.margin), abs=0.01)
        assert each["low_mm"] == pytest.approx(max(1e3 * (one.length - one.margin), 0.0), abs=0.01)


def test_programs_have_the_radii_in_the_scans_unit(made: Made) -> None:
    for unit in ("m", "in", "mm"):
        fit, lying, folder = made(unit)
        loaded = breastrig.Fit.load(folder)
        assert lying.radii is not None
        assert loaded.uncertainty * fit.metres_per_unit == pytest.approx(lying.radii, rel=1e-6)


def test_each_file_that_may_travel_alone_says_that_no_scan_shows_this_body(made: Made) -> None:
    fit, lying, folder = made("mm")
    for name in ("fitted.ply", "scan.ply"):
        assert b"\ncomment predicted: no scan shows this body\n" in (folder / name).read_bytes()[:400]
    document, _ = split_glb((folder / "fitted.glb").read_bytes())
    drawn = [node for node in document["nodes"] if "mesh" in node]
    assert drawn
    assert all(node["extras"]["predicted"] is True for node in drawn)
    plan = checked_plan({"schema": "breastrig/plan@1", "items": []})
    nothing = PlanOnScan((), (), ())
    assert plan_document(plan, lying, nothing)["predicted"] is True
    assert "predicted" not in plan_document(plan, fit, nothing)
    assert stance_of(lying).predicted
    assert not stance_of(fit).predicted


def test_its_number_for_lines_is_of_the_skin_that_was_scanned_as_a_fits_is(rig: Rig, tmp_path: Path) -> None:
    """A breast that the scan does not show counts neither for the fit nor for what is predicted of it."""
    unsure = radii_of(rig)
    unsure[rig.regions["breast_L"]] = 0.080
    fit = write_fit(tmp_path / "fit", rig, body(rig), unsure)
    right = rig.faces[(rig.template[rig.faces][:, :, 0] < -0.005).all(axis=1)]
    (fit / "scan.ply").write_bytes(surface_ply(body(rig), right, METRES_PER_UNIT["mm"]))
    made = json.loads(prediction(rig, fit, SUPINE)["result.json"])
    radii = np.hypot(predicted(rig, body(rig), STANDING, SUPINE).radii, unsure)
    shown = np.isin(np.arange(len(radii)), right)
    assert made["line_error_mm"] == pytest.approx(1e3 * line_error(rig, radii, shown), rel=0.03)
    assert made["line_error_mm"] < 0.6 * 1e3 * line_error(rig, radii, np.ones_like(shown))

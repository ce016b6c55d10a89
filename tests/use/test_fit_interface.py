"""A fit from a program: in the scan's unit and frame, and in every digit what `breastrig fit` writes."""

import json
import pickle
import re
import shutil
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.results import without_hashes
from helpers.same_files import assert_same_files
from threadpoolctl import threadpool_info, threadpool_limits

import breastrig
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.core.one_thread import one_thread
from breastrig.files.result import FIT_FILES
from breastrig.gltf.read_rig import default_rig_path
from breastrig.rig.skinning import pose
from breastrig.scan.landmarks.landmark_files import landmark_file, read_landmarks

pytestmark = pytest.mark.long

EXAMPLE = asset_folder("example")
STANDING, PICKS = EXAMPLE / "standing" / "scan.ply", EXAMPLE / "standing" / "landmarks.json"
TUMOUR = "L:10,45,12"
OFFSET = np.array([1000.0, -2000.0, 500.0])  # mm


@pytest.fixture(scope="module")
def by_command(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("command") / "out"
    wish = ["--tumour", TUMOUR]
    assert main(["fit", str(STANDING), "--landmarks", str(PICKS), *wish, "-o", str(out)]) == 0
    return out


@pytest.fixture(scope="module")
def fit() -> breastrig.Fit:
    return breastrig.fit(STANDING, PICKS, tumours=[TUMOUR])


@pytest.fixture(scope="module")
def measures(fit: breastrig.Fit) -> tuple[breastrig.Measure, ...]:
    return breastrig.measure(fit)


@pytest.mark.slow
def test_what_a_program_saves_is_what_the_command_writes(fit: breastrig.Fit, by_command: Path, tmp_path: Path) -> None:
    fit.save(tmp_path / "out")
    assert_same_files(tmp_path / "out", by_command)
    assert sorted(file.name for file in by_command.iterdir()) == sorted(FIT_FILES)
    assert {file.stat().st_mode & 0o777 for file in (tmp_path / "out").iterdir()} == {0o600}


def test_landmarks_by_name_in_the_scans_unit_and_a_scan_that_was_read_give_the_same_fit(fit: breastrig.Fit) -> None:
    scan = breastrig.read_scan(STANDING)
    places, unit = read_landmarks(PICKS)
    to_scan = {"mm": 1e-3, "m": 1.0}[unit or scan.unit] / scan.metres_per_unit
    named = {name: to_scan * place for name, place in places.items()}
    again = breastrig.fit(scan, named, tumours=[TUMOUR], model=breastrig.load_model())
    np.testing.assert_allclose(again.vertices, fit.vertices, atol=1e-6 / scan.metres_per_unit)
    assert again.result["scan"] == fit.result["scan"]


@pytest.mark.slow
def test_what_is_certain_may_be_named_by_the_program_or_by_its_file(tmp_path: Path) -> None:
    wrong, unit = read_landmarks(PICKS)
    wrong["xiphoid"] = wrong["xiphoid"] + np.array([50.0, 0.0, 0.0])
    (tmp_path / "plain.json").write_bytes(landmark_file(wrong, unit=unit))
    (tmp_path / "certain.json").write_bytes(landmark_file(wrong, unit=unit, certain=("xiphoid",)))
    by_program = breastrig.fit(STANDING, tmp_path / "plain.json", certain=("xiphoid",), drawing=None)
    by_file = breastrig.fit(STANDING, tmp_path / "certain.json", drawing=None)
    np.testing.assert_array_equal(by_file.vertices, by_program.vertices)
    assert "xiphoid" not in by_program.not_followed | by_program.unusual


def test_what_cannot_be_certain_is_refused() -> None:
    proposal = breastrig.Proposal(np.array([0.0, 0.1, 0.1]), 0.4, True)
    for picks, certain, sentence in (
        (PICKS, ("nose",), "names nose, which is not among these landmarks"),
        (None, ("xiphoid",), "names xiphoid, which is not among these landmarks"),
        ({"xiphoid": proposal}, ("xiphoid",), "xiphoid is proposed and cannot be certain"),
        (PICKS, "xiphoid", "certain must be a list"),
    ):
        with pytest.raises(breastrig.BadLandmarks, match=sentence):
            breastrig.fit(STANDING, picks, certain=certain)


def test_between_two_iterates_blas_has_the_threads_that_it_had() -> None:
    def threads() -> list[int]:
        return [each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"]

    with threadpool_limits(2, user_api="blas"):
        before = threads()
        run = breastrig.iterates(STANDING, PICKS, drawing=None)
        next(run)
        assert threads() == before
        with one_thread():
            assert set(threads()) == {1}
        assert set(before) == {2}
        run.close()


@pytest.fixture(scope="module")
def in_millimetres(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same patient in another unit and frame."""
    folder = tmp_path_factory.mktemp("millimetres")
    mesh = trimesh.load(STANDING, process=False)
    moved = trimesh.Trimesh(1e3 * np.asarray(mesh.vertices) + OFFSET, mesh.faces, process=False)
    moved.export(folder / "scan.ply")
    return folder / "scan.ply"


@pytest.mark.slow
def test_everything_is_in_the_scans_own_unit_and_frame(in_millimetres: Path) -> None:
    scan = breastrig.read_scan(in_millimetres, "mm")
    mesh = trimesh.load(in_millimetres, process=False)
    np.testing.assert_allclose(scan.vertices, mesh.vertices, rtol=1e-12)
    assert scan.unit == "mm"
    picks, _ = read_landmarks(PICKS)
    assert breastrig.read_scan(STANDING).unit == "m"
    picked = {name: place + OFFSET for name, place in picks.items()}  # the file has mm
    fit = breastrig.fit(scan, picked)
    low, high = mesh.bounds
    for name, place in fit.landmarks.items():
        assert np.linalg.norm(place - fit.picked[name]) < 5.0, name
        np.testing.assert_allclose(fit.picked[name], picked[name], atol=1e-5)
    for line in fit.drawing.lines:
        assert np.all((line.points > low - 1.0) & (line.points < high + 1.0))
        assert line.bridged is not None
        _, away, _ = trimesh.proximity.closest_point_naive(mesh, line.points[~line.bridged][::40])
        assert away.max() < 0.01
    for pose_of in fit.parameters.bones.values():
        assert np.linalg.norm(pose_of.translation - mesh.centroid) < 1000.0
        np.testing.assert_allclose(pose_of.rotation @ pose_of.rotation.T, np.eye(3), atol=1e-6)
    seen = np.isfinite(fit.distances)
    assert abs(np.abs(fit.distances[seen]).mean() - fit.result["surface_distance_mm"]["mean"]) < 1e-3
    assert seen.mean() == pytest.approx(fit.result["surface_distance_mm"]["coverage"], abs=1e-4)
    np.testing.assert_array_equal(fit.to_trimesh().vertices, fit.vertices)
    assert {measure.unit for measure in breastrig.measure(fit)} == {"mm", "ml", "1", "grade"}


def test_a_saved_fit_is_loaded_with_every_digit_of_its_files_and_saved_again(
    fit: breastrig.Fit, measures: tuple[breastrig.Measure, ...], tmp_path: Path
) -> None:
    fit.save(tmp_path / "a")
    found = breastrig.Fit.load(tmp_path / "a")
    for name in ("faces", "scan_faces", "distances"):
        np.testing.assert_array_equal(getattr(found, name), getattr(fit, name), err_msg=name)
    for name in ("vertices", "scan_vertices"):  # of single precision in the files
        np.testing.assert_array_equal(getattr(found, name), getattr(fit, name).astype("<f4"), err_msg=name)
    hashes = {"files", "fields"}  # of what is written
    assert hashes <= found.result.keys()
    assert {name: said for name, said in found.result.items() if name not in hashes} == fit.result
    same = ("stance", "verdict", "unit", "notes", "iterations", "converged", "stop_reason", "not_followed", "unusual")
    for name in same:
        assert getattr(found, name) == getattr(fit, name), name
    for name in ("landmarks", "picked"):
        for landmark, place in getattr(fit, name).items():
            np.testing.assert_array_equal(getattr(found, name)[landmark], place)
    for ours, theirs in zip(fit.drawing.lines, found.drawing.lines, strict=True):
        np.testing.assert_array_equal(ours.points, theirs.points)
    for ours, theirs in zip(measures, breastrig.measure(tmp_path / "a"), strict=True):
        numbers = dict.fromkeys(("left", "right", "value", "difference_margin"))  # of vertices in single precision
        assert replace(ours, **numbers) == replace(theirs, **numbers)
        assert (ours.difference_margin is None) == (theirs.difference_margin is None)
        if ours.difference_margin is not None:
            assert ours.difference_margin == pytest.approx(theirs.difference_margin, rel=1e-5)
        for side in ("left", "right", "value"):
            one, other = getattr(ours, side), getattr(theirs, side)
            assert (one is None) == (other is None)
            assert one is None or astuple(one) == pytest.approx(astuple(other), rel=1e-5, abs=1e-3)
    found.save(tmp_path / "b")
    for name in FIT_FILES:
        assert (tmp_path / "b" / name).read_bytes() == (tmp_path / "a" / name).read_bytes(), name


def test_a_fit_can_be_sent_to_another_process(fit: breastrig.Fit, tmp_path: Path) -> None:
    sent = pickle.loads(pickle.dumps(fit))
    np.testing.assert_array_equal(sent.vertices, fit.vertices)
    sent.save(tmp_path / "sent")
    fit.save(tmp_path / "kept")
    for name in FIT_FILES:
        assert (tmp_path / "sent" / name).read_bytes() == (tmp_path / "kept" / name).read_bytes(), name


def test_arrays_of_a_fit_cannot_be_written_to(fit: breastrig.Fit) -> None:
    for array in (
        fit.vertices,
        fit.scan_vertices,
        fit.distances,
        fit.landmarks["xiphoid"],
        fit.drawing.lines[0].points,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_values_of_a_fit_come_from_what_is_measured_and_from_nothing_else(fit: breastrig.Fit) -> None:
    """Else measures, transfers and files would say another thing than the values beside them."""
    for name in ("vertices", "landmarks", "picked", "stance", "unit", "verdict"):
        with pytest.raises(ValueError, match="init=False"):
            replace(fit, **{name: getattr(fit, name)})
    vertices = fit.in_metres.vertices
    middle = vertices.mean(axis=0)  # so little larger that the scan still shows the breasts
    larger = replace(fit, in_metres=replace(fit.in_metres, vertices=middle + 1.02 * (vertices - middle)))
    measured = [breastrig.measure(each) for each in (fit, larger)]
    widths = [next(row.left for row in rows if row.name == "base_width" and row.left) for rows in measured]
    assert widths[1].value == pytest.approx(1.02 * widths[0].value, rel=0.002)


def test_what_was_read_is_never_replaced_and_what_is_anothers_only_by_force(tmp_path: Path) -> None:
    shutil.copy(STANDING, tmp_path / "scan.ply")
    fit = breastrig.fit(tmp_path / "scan.ply", PICKS, drawing=None)
    before = (tmp_path / "scan.ply").read_bytes()
    for force in (False, True):
        with pytest.raises(breastrig.BadInput, match="which this command reads"):
            fit.save(tmp_path, force=force)
    assert [file.name for file in tmp_path.iterdir()] == ["scan.ply"]
    assert (tmp_path / "scan.ply").read_bytes() == before
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "fitted.ply").write_text("mine")
    with pytest.raises(breastrig.BadInput, match=r"holds fitted\.ply"):
        fit.save(tmp_path / "out")
    assert (tmp_path / "out" / "fitted.ply").read_text() == "mine"
    fit.save(tmp_path / "out", force=True)
    fit.save(tmp_path / "out")
    assert fit.drawing.lines == ()


def test_iterates_show_the_model_on_its_way_and_end_with_the_fit(fit: breastrig.Fit) -> None:
    run = breastrig.iterates(STANDING, PICKS, drawing=None, refine=False)
    steps = list(run)
    last = run.result()
    assert [each.iteration for each in steps] == list(range(last.iterations + 1))
    assert last.iterations <= run.iterations_limit
    rig = breastrig.load_model()
    for each in (steps[0], steps[-1]):
        np.testing.assert_array_equal(each.vertices, pose(rig, each.in_metres) / last.metres_per_unit)
    assert np.abs(steps[-1].vertices - last.vertices).max() < 1e-6
    assert np.abs(steps[0].vertices - last.vertices).max() > 1e-3
    assert steps[-1].parameters.blendshapes == pytest.approx(last.parameters.blendshapes, abs=1e-8)
    assert steps[-1].mean_distance_mm < steps[0].mean_distance_mm
    assert run.result() is last


def test_leaving_the_loop_cancels_the_fit() -> None:
    run = breastrig.iterates(STANDING, PICKS, drawing=None)
    next(run)
    run.close()
    with pytest.raises(breastrig.FitFailed, match="stopped before its end"):
        run.result()


@pytest.fixture(scope="module")
def scan() -> breastrig.Scan:
    return breastrig.read_scan(STANDING)


@pytest.fixture(scope="module")
def proposed(scan: breastrig.Scan) -> dict[str, breastrig.Proposal]:
    return breastrig.propose_landmarks(scan)


@pytest.mark.slow
def test_proposals_are_landmarks_with_a_confidence(
    scan: breastrig.Scan, proposed: dict[str, breastrig.Proposal], tmp_path: Path
) -> None:
    assert list(proposed) == list(breastrig.load_model().landmark_names)
    picks, _ = read_landmarks(PICKS)
    for name, each in proposed.items():
        assert 0.0 < each.confidence < 1.0
        assert np.linalg.norm(each.point * scan.metres_per_unit - 1e-3 * picks[name]) < 0.05, name
    assert main(["landmarks", str(STANDING), "-o", str(tmp_path / "proposed.json")]) == 0
    by_name, by_file = breastrig.fit(scan, proposed), breastrig.fit(scan, tmp_path / "proposed.json")
    np.testing.assert_array_equal(by_name.vertices, by_file.vertices)
    assert by_name.result["landmarks"] == by_file.result["landmarks"]


@pytest.mark.slow
def test_beside_picks_only_those_proposals_count_that_colour_shows(scan: breastrig.Scan) -> None:
    places, _ = read_landmarks(PICKS)
    picks = {
        name: 1e-3 / scan.metres_per_unit * places[name] for name in ("suprasternal_notch", "xiphoid", "umbilicus")
    }
    sure, unsure = breastrig.Proposal(picks["xiphoid"], 0.9, True), breastrig.Proposal(picks["xiphoid"], 0.7, True)
    del picks["xiphoid"]
    fits = [breastrig.fit(scan, picks | {"xiphoid": each}, drawing=None) for each in (unsure, sure)]
    assert [set(fit.picked) for fit in fits] == [set(picks), {*picks, "xiphoid"}]
    assert fits[0].notes[-1] == "The landmark xiphoid is as proposed from this scan, and did not pull at the fit."
    assert fits[1].notes == fits[0].notes[:-1]


def test_units_belong_to_the_one_who_reads_the_scan(tmp_path: Path) -> None:
    with pytest.raises(breastrig.BadSettings, match="give its units to read_scan"):
        breastrig.fit(breastrig.read_scan(STANDING), units="m")
    with pytest.raises(breastrig.BadInput, match="unit"):
        breastrig.fit(STANDING, units="mm")
    by_bytes = breastrig.read_scan(STANDING.read_bytes())
    assert by_bytes.sha256 == breastrig.read_scan(str(STANDING)).sha256
    np.testing.assert_array_equal(by_bytes.to_trimesh().vertices, by_bytes.vertices)


@pytest.fixture
def cuts(tmp_path: Path) -> Path:
    """All that lies beyond the middle of an arm, as the service would answer."""
    x = breastrig.read_scan(STANDING).in_metres.vertices[:, 0]
    at = float(np.quantile(x, 0.97))
    document = {"to_picture": np.eye(4).ravel().tolist(), "lasso": [[at, -9.0], [9.0, -9.0], [9.0, 9.0], [at, 9.0]]}
    (tmp_path / "cuts.json").write_text(json.dumps({"cuts": [document], "digest": "0123456789abcdef"}), "utf-8")
    return tmp_path / "cuts.json"


def test_what_was_cut_away_in_the_page_is_cut_by_program_and_command(cuts: Path, tmp_path: Path) -> None:
    scan = breastrig.read_scan(STANDING)
    left = scan.without(cuts)
    gone = len(scan.faces) - len(left.faces)
    assert 0 < gone < 0.2 * len(scan.faces)
    assert (scan.unit, scan.sha256) == (left.unit, left.sha256)
    assert main(["fit", str(STANDING), "--landmarks", str(PICKS), "--cuts", str(cuts), "-o", str(tmp_path / "a")]) == 0
    breastrig.fit(left, PICKS).save(tmp_path / "b")
    assert_same_files(tmp_path / "b", tmp_path / "a")
    said = json.loads((tmp_path / "a" / "result.json").read_text("utf-8"))
    assert said["scan"]["cut_by_hand_triangles"] == gone
    assert said["scan"]["triangles"] == len(scan.faces)


def test_a_file_that_holds_no_cuts_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", str(STANDING), "--cuts", str(PICKS), "-o", str(tmp_path / "out")]) == 2
    assert "a file of cuts is what GET /api/scans/ID/cuts answers" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ["result.json", "scan.ply", "fitted.ply"])
def test_a_folder_without_what_a_fit_needs_is_refused_in_one_sentence(
    name: str, by_command: Path, tmp_path: Path
) -> None:
    shutil.copytree(by_command, tmp_path / "out")
    (tmp_path / "out" / name).unlink()
    with pytest.raises(
        breastrig.BadInput, match="There is no fit in out" if name == "result.json" else f"out/{name} is"
    ):
        breastrig.Fit.load(tmp_path / "out")


def test_what_else_is_missing_or_damaged_is_said_when_it_is_asked_for(by_command: Path, tmp_path: Path) -> None:
    without_hashes(shutil.copytree(by_command, tmp_path / "out"))
    (tmp_path / "out" / "fitted.glb").unlink()
    (tmp_path / "out" / "drawing.json").write_text("{")
    (tmp_path / "out" / "distances.bin").write_bytes(b"1234")
    found = breastrig.Fit.load(tmp_path / "out")
    with pytest.raises(breastrig.BadDrawing, match="damaged"):
        _ = found.drawing
    with pytest.raises(breastrig.BadInput, match=r"distances\.bin"):
        _ = found.distances
    with pytest.raises(breastrig.BadInput, match=r"fitted\.glb was not in the folder"):
        found.save(tmp_path / "again")
    assert not (tmp_path / "again").exists()
    document = json.loads((tmp_path / "out" / "result.json").read_text())
    document["verdict"] = {"level": "excellent", "reasons": []}
    (tmp_path / "out" / "result.json").write_text(json.dumps(document))
    with pytest.raises(breastrig.BadInput, match=r"out/result\.json is damaged .* \(verdict\.level\)"):
        breastrig.Fit.load(tmp_path / "out")


def test_a_fit_says_in_a_line_what_it_is(fit: breastrig.Fit) -> None:
    assert re.fullmatch(
        r"<Fit: standing, good: drawn lines ± \d mm; 0\.\d\d mm to the scan, \d+ iterations, in m>", repr(fit)
    )
    assert fit.model.sha256 == breastrig.load_model(default_rig_path()).sha256

"""`breastrig fit` as a user calls it: the files it leaves, and one clear line for everything it refuses."""

import io
import json
import re
from contextlib import redirect_stderr
from dataclasses import replace
from pathlib import Path

import numpy as np
import pygltflib
import pytest
import trimesh
from helpers.results import TO_LANDMARKS, without_hashes

import breastrig
from breastrig.cli.fit_command import summary
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.core.units import METRES_PER_UNIT
from breastrig.files.result import ResultFile
from breastrig.fitting.task import PickIssue
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.bands import margin_text
from breastrig.use import fit as run_fit

pytestmark = pytest.mark.long

EXAMPLE = asset_folder("example") / "standing"


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nothing is said of an ordinary scan, not even of its dust and of triangles that face inwards."""
    out = tmp_path_factory.mktemp("fit")
    with redirect_stderr(io.StringIO()) as said:
        code = main(["fit", str(EXAMPLE / "scan.ply"), "--landmarks", str(EXAMPLE / "landmarks.json"), "-o", str(out)])
    assert (code, said.getvalue()) == (0, "")
    return out


def document(folder: Path, name: str) -> dict:
    return json.loads((folder / name).read_text())


def test_its_files_are_there_and_nothing_else(fitted: Path) -> None:
    names = {file.name for file in fitted.iterdir()}
    assert names == {
        "result.json",
        "scan.ply",
        "fitted.ply",
        "fitted.glb",
        "drawing.json",
        "distances.bin",
        "uncertainty.bin",
        "body.bin",
        "checks.bin",
        "fit.log.jsonl",
    }


def test_the_result_keeps_its_contract_and_its_accuracy(fitted: Path) -> None:
    result = document(fitted, "result.json")
    assert result["schema"] == "breastrig/result@1"
    words = "scan model stance preset converged stop_reason iterations timing_s surface_distance_mm scan_to_model_mm"
    assert set(result) >= {*words.split(), "landmark_distance_mm", "landmarks", "parameters", "versions"}
    assert set(result["timing_s"]) == {"read", "prepare", "align", "solve", "refine", "total"}
    assert set(result["surface_distance_mm"]) == {"mean", "std", "max", "p95", "coverage"}
    assert result["surface_distance_mm"]["mean"] < 0.2
    assert result["surface_distance_mm"]["p95"] < 0.7
    # the triangles lie on the skin in the mean, not the vertices: those 0.02 mm farther off, the whole surface nearer
    assert result["model_alone"]["surface_distance_mm"]["mean"] < 0.57
    assert result["model_alone"]["scan_to_model_mm"]["mean"] < 0.82
    assert result["model_alone"]["surface_distance_mm"]["p95"] < 1.65
    assert result["surface_distance_mm"]["coverage"] > 0.75
    assert result["landmark_distance_mm"]["mean"] < 1.7
    assert result["landmark_distance_mm"]["max"] < 4.0
    assert len(result["landmark_distance_mm"]["each"]) == 12
    assert len(result["parameters"]["bones"]) == 9
    assert len(result["parameters"]["blendshapes"]) == 55
    assert result["stance"] == "standing"


def test_a_stance_that_the_scan_does_not_show_is_said(fitted: Path, tmp_path: Path, monkeypatch, capsys) -> None:
    reason = document(fitted, "result.json")["stance_reason"]
    monkeypatch.setattr("breastrig.use.folder.fit_files.UNCLEAR", (reason,))
    options = ["--landmarks", str(EXAMPLE / "landmarks.json"), "--drawing", "none", "-o", str(tmp_path / "out")]
    assert main(["fit", str(EXAMPLE / "scan.ply"), *options]) == 0
    assert document(tmp_path / "out", "result.json")["verdict"]["level"] == "good"
    assert capsys.readouterr().err == f"breastrig: {reason}\n"


def test_on_a_terminal_the_verdict_and_how_sure_it_is_come_before_any_distance(fitted: Path) -> None:
    result = json.loads((fitted / "result.json").read_text())
    sure = r"a good fit: drawn lines ± [5-9] mm, landmarks ± \d+ to \d+ mm"
    near = r"0\.\d\d mm to the scan \(the model alone 0\.\d\d mm\), \d\.\d\d mm to the landmarks"
    assert re.fullmatch(f"{sure}; {near}", summary(ResultFile.model_validate(result)))
    unknown = result["surface_distance_mm"] | {"mean": None}
    worse = {"verdict": {"level": "unusable", "reasons": []}, "refined": False, "surface_distance_mm": unknown}
    nothing = {"landmark_uncertainty_mm": {}, "landmark_distance_mm": TO_LANDMARKS}
    assert summary(ResultFile.model_validate(result | worse | nothing)) == "not usable; no distance to the scan"
    guess = {"landmark_uncertainty_mm": {"xiphoid": 177.2, "umbilicus": 12.4}}
    unsure = result | guess | {"verdict": {"level": "check", "reasons": []}, "drawn_line_error_mm": 14.6}
    start = "a fit to check: drawn lines ± 15 mm, landmarks ± 12 mm, 1 not known; "
    assert summary(ResultFile.model_validate(unsure)).startswith(start)


def test_landmarks_that_would_make_lines_surer_by_a_finger_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scan, out = breastrig.example("supine").scan, tmp_path / "out"
    assert main(["fit", str(scan), "-o", str(out)]) == 0
    [said] = [line for line in capsys.readouterr().err.splitlines() if "placed by hand" in line]
    found = breastrig.Fit.load(out).checks()
    assert found.worth_it
    for each in found.checks:
        assert f"the {each.label}" in said
    assert f"{margin_text(found.expected_line_error_mm)} instead of {margin_text(found.line_error_mm)}" in said


def test_a_fit_that_is_not_usable_is_written_and_has_an_exit_code_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Squeezed sideways, as no adult is, but not so much that it is refused."""
    scan = trimesh.load(EXAMPLE / "scan.ply", process=False)
    trimesh.Trimesh(scan.vertices * np.array([0.7, 1.0, 1.3]), scan.faces, process=False).export(
        tmp_path / "squeezed.ply"
    )
    asked = ["fit", str(tmp_path / "squeezed.ply"), "--units", "m", "--drawing", "none"]
    assert main([*asked, "-o", str(tmp_path / "out")]) == 3
    assert document(tmp_path / "out", "result.json")["verdict"]["level"] == "unusable"
    assert "this fit is not usable: " in capsys.readouterr().err


def test_the_fitted_surface_is_the_whole_model_in_the_scans_frame_and_unit(fitted: Path) -> None:
    rig = read_rig(default_rig_path())
    mesh = trimesh.load(fitted / "fitted.ply", process=False)
    np.testing.assert_array_equal(mesh.faces, rig.faces)
    result = document(fitted, "result.json")
    scan = trimesh.load(EXAMPLE / "scan.ply", process=False)
    assert np.linalg.norm(mesh.centroid - scan.centroid) < 0.3 * scan.scale
    at = rig.landmark_points().positions(np.asarray(mesh.vertices, dtype=np.float64), rig.faces)
    np.testing.assert_allclose(at, list(result["landmarks"].values()), atol=2e-6 * scan.scale)


def test_the_drawing_lies_on_the_scan_or_says_that_it_does_not(fitted: Path) -> None:
    drawing = document(fitted, "drawing.json")
    assert drawing["schema"] == "breastrig/drawing@1"
    assert drawing["unit"] == document(fitted, "result.json")["scan"]["unit"]
    assert {shape["name"] for shape in drawing["shapes"]} == {"sternum_upper", "sternum_lower", "breast_L", "breast_R"}
    scan = trimesh.load(EXAMPLE / "scan.ply", process=False)
    for shape in drawing["shapes"]:
        free = np.array(shape["points"])[~np.array(shape["bridged"])]
        assert len(free) > 0.8 * len(shape["points"])
        _, distance, _ = trimesh.proximity.closest_point_naive(scan, free[::40])
        assert distance.max() < 1e-5


def test_the_glb_holds_rig_drawing_and_one_key_per_iteration(fitted: Path) -> None:
    gltf = pygltflib.GLTF2().load(str(fitted / "fitted.glb"))
    (animation,) = gltf.animations
    assert animation.name == "registration"
    keys = {gltf.accessors[sampler.input].count for sampler in animation.samplers}
    assert keys == {document(fitted, "result.json")["iterations"] + 1}
    assert any(node.name.startswith("drawing_") for node in gltf.nodes)


def test_the_log_has_one_line_per_iteration(fitted: Path) -> None:
    lines = [json.loads(line) for line in (fitted / "fit.log.jsonl").read_text().splitlines()]
    assert [line["iteration"] for line in lines] == list(range(document(fitted, "result.json")["iterations"] + 1))


def test_a_bad_scan_gets_one_clear_line_and_exit_code_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "text.ply").write_bytes(b"Dear surgeon, please find attached the scan.\n" * 20)
    scan = trimesh.load(EXAMPLE / "scan.ply", process=False)
    trimesh.PointCloud(scan.vertices[::500]).export(tmp_path / "points far apart.ply")
    for name in ("text.ply", "points far apart.ply", "nothing.ply"):
        assert main(["fit", str(tmp_path / name), "-o", str(tmp_path / "out")]) == 2
        said = capsys.readouterr()
        assert said.out == ""
        assert said.err.startswith("breastrig: ")
        assert said.err.count("\n") == 1
        assert "Traceback" not in said.err
        assert not (tmp_path / "out").exists()


def test_a_wrong_option_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for options, word in (
        (["--units", "mm"], "unit"),
        (["--preset", "fast"], "preset"),
        (["--model", "none.glb"], "none.glb"),
        (["--drawing", "reduction:limbs=4"], '"limbs" is not a parameter of reduction'),
        (["--drawing", "wise"], '"wise" is not a drawing of this model; known are:'),
        (["--tumour", "L:13,45,12"], "clock of tumour cannot be 13"),
        (["--tumour", "L:10"], '"L:10" is not a tumour; write SIDE:HOUR,DISTANCE_MM,RADIUS_MM'),
    ):
        assert main(["fit", str(EXAMPLE / "scan.ply"), *options, "-o", str(tmp_path / "out")]) == 2
        said = capsys.readouterr().err
        assert word in said
        assert said.count("\n") == 1
        assert not (tmp_path / "out").exists()


def test_usage_errors_exit_with_2_and_version_says_the_limits_of_use(capsys: pytest.CaptureFixture[str]) -> None:
    for words, code in ((["fit"], 2), (["--version"], 0)):
        with pytest.raises(SystemExit) as left:
            main(words)
        assert left.value.code == code
    assert "Research use only" in capsys.readouterr().out


def test_a_fit_follows_the_skin_unless_the_model_alone_is_wanted(fitted: Path, tmp_path: Path) -> None:
    landmarks = ["--landmarks", str(EXAMPLE / "landmarks.json")]
    for name, options in (("asked", ["--refine"]), ("alone", ["--no-refine"])):
        assert main(["fit", str(EXAMPLE / "scan.ply"), *landmarks, *options, "-o", str(tmp_path / name)]) == 0
    assert (tmp_path / "asked" / "fitted.ply").read_bytes() == (fitted / "fitted.ply").read_bytes()
    plain, fine = document(tmp_path / "alone", "result.json"), document(fitted, "result.json")
    assert fine["refined"]
    assert not plain["refined"]
    assert fine["surface_distance_mm"]["mean"] < 0.5 * plain["surface_distance_mm"]["mean"]
    assert fine["landmark_distance_mm"]["mean"] < plain["landmark_distance_mm"]["mean"] + 0.3
    assert fine["parameters"] == plain["parameters"]
    assert fine["model_alone"] == plain["model_alone"]
    assert fine["model_alone"]["surface_distance_mm"] == plain["surface_distance_mm"]


def test_the_farthest_of_the_wrong_landmarks_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    landmarks = document(EXAMPLE, "landmarks.json")
    for name, shift in (("xiphoid", 400.0), ("umbilicus", 4000.0)):
        landmarks["landmarks"][name][2] += shift
    (tmp_path / "far.json").write_text(json.dumps(landmarks))
    arguments = ["fit", str(EXAMPLE / "scan.ply"), "--landmarks", str(tmp_path / "far.json"), "-o", str(tmp_path / "o")]
    assert main(arguments) == 2
    assert "umbilicus is 39" in capsys.readouterr().err


def test_picks_that_were_not_followed_are_named_on_stderr(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    landmarks = document(EXAMPLE, "landmarks.json")
    points = landmarks["landmarks"]
    points["nipple_L"], points["nipple_R"] = points["nipple_R"], points["nipple_L"]
    (tmp_path / "picks.json").write_text(json.dumps(landmarks))
    arguments = ["fit", str(EXAMPLE / "scan.ply"), "--landmarks", str(tmp_path / "picks.json"), "-o", str(tmp_path)]
    assert main(arguments) == 0
    told = capsys.readouterr().err.splitlines()
    assert told == [
        "breastrig: check this fit: 2 landmarks look exchanged between left and right; look at what is asked about "
        "them.",
        "breastrig: nipple_L and nipple_R look exchanged; they were not followed.",
    ]


def test_a_certain_pick_is_followed_and_not_asked_about(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    landmarks = document(EXAMPLE, "landmarks.json")
    landmarks["landmarks"]["xiphoid"][0] += 50.0
    for name, certain in (("doubted", []), ("certain", ["xiphoid"])):
        (tmp_path / f"{name}.json").write_text(json.dumps(landmarks | {"certain": certain}))
        wish = ["--landmarks", str(tmp_path / f"{name}.json"), "-o", str(tmp_path / name)]
        assert main(["fit", str(EXAMPLE / "scan.ply"), *wish]) == 0
        said = capsys.readouterr().err.splitlines()
        result = document(tmp_path / name, "result.json")
        asked = [pick["names"] for pick in (*result["landmarks_not_followed"], *result["landmarks_unusual"])]
        assert asked == ([["xiphoid"]] if name == "doubted" else [])
        assert any("xiphoid is" in line for line in said) is (name == "doubted"), said
    (tmp_path / "wrong.json").write_text(json.dumps(landmarks | {"certain": "xiphoid"}))
    wish = ["--landmarks", str(tmp_path / "wrong.json"), "-o", str(tmp_path / "wrong")]
    assert main(["fit", str(EXAMPLE / "scan.ply"), *wish]) == 2
    assert '"certain" in this landmark file must be a list' in capsys.readouterr().err
    assert not (tmp_path / "wrong").exists()


def test_unusual_picks_are_named_on_stderr_to_be_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    reason, question = "umbilicus is 42 mm from where the model expects it.", "xiphoid is unusual. Is it right?"
    found = (
        PickIssue(("umbilicus",), reason, followed=True),
        PickIssue(("nipple_L",), "nipple_L was let go."),
        PickIssue(("xiphoid",), question, followed=True),
    )
    finish = run_fit.outcome_of
    monkeypatch.setattr(run_fit, "outcome_of", lambda *given: replace(finish(*given), doubts=found))
    arguments = ["fit", str(EXAMPLE / "scan.ply"), "--landmarks", str(EXAMPLE / "landmarks.json"), "-o", str(tmp_path)]
    assert main(arguments) == 0
    assert capsys.readouterr().err.splitlines() == [
        "breastrig: nipple_L was let go.",
        "breastrig: umbilicus is 42 mm from where the model expects it; check it.",
        f"breastrig: {question}",
    ]
    assert document(tmp_path, "result.json")["landmarks_unusual"] == [
        {"names": ["umbilicus"], "reason": reason},
        {"names": ["xiphoid"], "reason": question},
    ]
    fit = breastrig.Fit.load(tmp_path)
    assert (fit.not_followed, fit.unusual) == (
        {"nipple_L": "nipple_L was let go."},
        {"umbilicus": reason, "xiphoid": question},
    )
    result = json.loads((without_hashes(tmp_path) / "result.json").read_text())
    del result["landmarks_unusual"]  # as a version before left it
    (tmp_path / "result.json").write_text(json.dumps(result))
    assert breastrig.Fit.load(tmp_path).unusual == {}


@pytest.fixture(scope="module")
def patterned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("patterns")
    wish = ["--drawing", "mastectomy+reduction:areola_mm=40", "--tumour", "L:10,45,12", "--tumour", "R:3,30,8"]
    scan, landmarks = str(EXAMPLE / "scan.ply"), str(EXAMPLE / "landmarks.json")
    assert main(["fit", scan, "--landmarks", landmarks, *wish, "-o", str(out)]) == 0
    return out


def test_patterns_and_tumours_are_drawn_together(patterned: Path) -> None:
    drawing = document(patterned, "drawing.json")
    names = [
        f"{line}_{side}" for line in ("stewart", "wise", "wise_fold", "areola", "new_nipple", "tumour") for side in "LR"
    ]
    assert sorted(shape["name"] for shape in drawing["shapes"]) == sorted(names)
    assert drawing["name"] == "mastectomy_and_reduction_and_tumour"


def test_every_point_of_every_pattern_is_on_the_scan_or_marked(patterned: Path) -> None:
    """By an exact search of its own: SPEC asks for 0.3 mm."""
    result, drawing = document(patterned, "result.json"), document(patterned, "drawing.json")
    metres = METRES_PER_UNIT[result["scan"]["unit"]]
    assert drawing["unit"] == result["scan"]["unit"]
    scan = trimesh.load(patterned / "scan.ply", process=False)
    search = ClosestPointSearch(np.array(scan.vertices) * metres, np.array(scan.faces))
    for shape in drawing["shapes"]:
        points, bridged = np.array(shape["points"]) * metres, np.array(shape["bridged"])
        assert search.query(points[~bridged]).distances.max() < 3e-4, shape["name"]
        line = np.concatenate([points, points[:1]]) if shape["closed"] else points
        assert np.linalg.norm(np.diff(line, axis=0), axis=1).max() < 0.005, shape["name"]


def test_a_tumour_at_ten_oclock_of_the_left_breast_is_its_upper_inner_quadrant(patterned: Path) -> None:
    result, drawing = document(patterned, "result.json"), document(patterned, "drawing.json")
    marks = {name: np.array(place) for name, place in result["landmarks"].items()}
    middle = {s["name"]: np.array(s["points"]).mean(axis=0) for s in drawing["shapes"]}
    left = marks["acromion_L"] - marks["acromion_R"]
    up = marks["suprasternal_notch"] - marks["umbilicus"]
    arm = middle["tumour_L"] - marks["nipple_L"]
    assert arm @ left < 0.0
    assert arm @ up > 0.0
    assert (middle["tumour_R"] - marks["nipple_R"]) @ left > 0.0  # 3 o'clock is medial on the right breast

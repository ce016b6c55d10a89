"""Scans scaled to a length that was measured on the patient: the result is that of a scan of the true size."""

import io
import json
import shutil
from pathlib import Path

import numpy as np
import pypdf
import pytest
import trimesh
from helpers.plain_report import white

import breastrig
from breastrig.batch.table import numbers_of
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.core.errors import BadLandmarks
from breastrig.core.identity import Identity
from breastrig.core.picks import Length
from breastrig.drawings.plan_schema import empty_plan_on_scan
from breastrig.files.result import ResultMark, read_result
from breastrig.rendering.picture import Scene
from breastrig.rig.model import Rig
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.true_size import length_of, true_size
from breastrig.scan.unscaled import UNKNOWN_SIZE
from breastrig.use.folder.cohort import cohort_in
from breastrig.use.reports.report import ReportJob, measures_csv_of
from breastrig.use.reports.share_snapshot import SnapshotJob, snapshot_files

EXAMPLE = asset_folder("example")
SMALL = 0.95
ENDS = ("nipple_L", "suprasternal_notch")


def places(stance: str) -> dict[str, np.ndarray]:
    return read_landmarks(EXAMPLE / stance / "landmarks.json")[0]


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The standing example as an app has it that is 5 % too small, with its landmarks, mm."""
    folder = tmp_path_factory.mktemp("small")
    scan = trimesh.load(EXAMPLE / "standing" / "scan.ply", process=False)
    scan.apply_scale(SMALL)
    (folder / "scan.ply").write_bytes(scan.export(file_type="ply"))
    picks = {name: (SMALL * place).tolist() for name, place in places("standing").items()}
    (folder / "landmarks.json").write_text(json.dumps({"landmarks": picks, "unit": "mm"}))
    return folder


@pytest.fixture(scope="module")
def length() -> float:
    """Of her, mm."""
    return float(np.linalg.norm(places("standing")[ENDS[0]] - places("standing")[ENDS[1]]))


@pytest.fixture(scope="module")
def case(small: Path, length: float) -> breastrig.Case:
    """With the small scan, to which her length was given, and its fit."""
    case = breastrig.Case.create(small / "her", "K7M-4QX")
    scan = case.add_scan(small / "scan.ply")
    case.put_landmarks(scan, small / "landmarks.json")
    case.put_length(scan, *ENDS, length)
    case.fit(scan)
    return case


@pytest.fixture(scope="module")
def fits(case: breastrig.Case) -> tuple[breastrig.Fit, breastrig.Fit]:
    """Of the scan of the true size, and of the small one with her length."""
    true = breastrig.fit(EXAMPLE / "standing" / "scan.ply", EXAMPLE / "standing" / "landmarks.json")
    return true, case.load_fit(case.fits(case.scans[0].id)[0].id)


@pytest.mark.slow
def test_a_scaled_scan_is_fitted_as_one_of_the_true_size(fits: tuple[breastrig.Fit, breastrig.Fit]) -> None:
    true, scaled = fits
    mm = 1e3 * true.metres_per_unit
    assert mm * np.linalg.norm(scaled.vertices - true.vertices, axis=1).max() < 0.5
    assert mm * np.linalg.norm(scaled.scan_vertices - true.scan_vertices, axis=1).max() < 0.01
    for name, place in true.picked.items():
        np.testing.assert_allclose(scaled.picked[name], place, atol=0.01 / mm)
    assert scaled.line_error_mm == pytest.approx(true.line_error_mm, abs=0.1)
    assert "scale" not in true.result


@pytest.mark.slow
def test_the_result_says_by_how_much(fits: tuple[breastrig.Fit, breastrig.Fit], length: float) -> None:
    found = fits[1].result["scale"]
    assert found["factor"] == pytest.approx(1.0 / SMALL, abs=1e-4)
    assert (found["between"], found["mm"]) == (list(ENDS), length)
    assert found["measured_mm"] == pytest.approx(SMALL * length, abs=0.01)
    [note] = [each for each in fits[1].notes if each.startswith("Scaled by 1.053: ")]
    assert note.endswith("All results are in this size.")


@pytest.mark.slow
def test_lines_are_right_where_only_one_of_two_scans_is_scaled(
    fits: tuple[breastrig.Fit, breastrig.Fit],
) -> None:
    supine = breastrig.fit(EXAMPLE / "supine" / "scan.ply", EXAMPLE / "supine" / "landmarks.json")
    drawn = [breastrig.transfer(fit, supine).lines for fit in fits]
    for of_true, of_scaled in zip(*drawn, strict=True):
        gaps = gaps_to(of_true.points, of_scaled.points)
        assert 1e3 * supine.metres_per_unit * gaps.max() < 0.1
    back = breastrig.transfer(supine, fits[1], supine.drawing.lines)
    assert back.unit == fits[1].unit
    on_skin = [line.points[~np.asarray(line.bridged)] for line in back.lines]
    nearest = [gaps_to(points, fits[1].scan_vertices).max() for points in on_skin]
    assert 1e3 * fits[1].metres_per_unit * max(nearest) < 12.0  # on the scaled scan's skin, between its vertices


def gaps_to(points: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(M,) from each point to the nearest of the others."""
    return np.asarray(np.linalg.norm(points[:, None] - others, axis=2).min(axis=1))


@pytest.mark.slow
def test_a_case_has_the_scan_in_its_true_size_until_the_length_is_taken_out(
    case: breastrig.Case, small: Path, length: float, torso: Rig, capsys
) -> None:
    [scan], words = case.scans, ["case", "length", str(case.path)]
    true, kept = breastrig.read_scan(EXAMPLE / "standing" / "scan.ply"), case.read_scan(scan.id)
    assert scan.scale == pytest.approx(1.0 / SMALL, abs=1e-4)
    np.testing.assert_allclose(kept.vertices, true.vertices, rtol=1e-4)
    assert main([*words, "--remove"]) == 0
    [fit] = case.fits(scan.id)
    assert (fit.state, case.scans[0].scale) == ("cancelled", 1.0)
    with pytest.raises(breastrig.BadInput, match="got another size"):
        case.load_fit(fit.id)
    assert cohort_in([case.path], torso).others == ("1 left out: the scan has another size by now.",)
    small_scan = breastrig.read_scan(small / "scan.ply")
    assert np.array_equal(case.read_scan(scan.id).vertices, small_scan.vertices)
    assert main([*words, "--put", *ENDS, str(length)]) == 0
    assert "Scaled by 1.053" in capsys.readouterr().out
    assert [each.state for each in case.fits(scan.id)] == ["done"]
    assert main(["case", "show", str(case.path)]) == 0
    assert ", scaled by 1.053 " in capsys.readouterr().out
    nose = main([*words, "--put", "nose", ENDS[1], "180"])
    assert (nose, 'ends at "nose"' in capsys.readouterr().err) == (2, True)


@pytest.mark.slow
def test_a_link_shows_all_in_the_true_size_and_no_name_of_a_mark(
    case: breastrig.Case,
    fits: tuple[breastrig.Fit, breastrig.Fit],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    true, scaled = fits
    [scan], [fit] = case.scans, case.fits(case.scans[0].id)
    folder = tmp_path / "fit"
    shutil.copytree(fit.folder, folder)
    result = read_result(folder)
    assert result.scale is not None
    of_mark = {
        "scale": result.scale.model_copy(update={"between": [ENDS[0], "scar of M"]}),
        "notes": [each.replace(ENDS[1], "scar of M") for each in result.notes],
        "marks": {"scar of M": ResultMark(point=[0.0] * 3, off_scan_mm=0.0, face=0, barycentric=[1.0, 0.0, 0.0])},
    }
    (folder / "result.json").write_bytes(result.model_copy(update=of_mark).content())
    monkeypatch.setattr(Scene, "render", white)
    lines = [{"name": "L", "closed": False, "points": (1e3 * scaled.metres_per_unit * scaled.vertices[:2]).tolist()}]
    plan = empty_plan_on_scan("mm") | {"version": 0, "whole": True, "shapes": lines}
    stored = case.path / "scans" / scan.id / "scan.stored"
    assert stored.is_file()
    for scan_file, shows_scan in ((stored, True), (None, True), (None, False)):
        job = SnapshotJob(folder, plan, (), Identity(), tmp_path, scan_file, "stored", shows_scan)
        files = snapshot_files(job)
        pages = pypdf.PdfReader(io.BytesIO(files["report.pdf"])).pages if shows_scan else []
        printed = " ".join(" ".join(page.extract_text() for page in pages).split())
        assert ("Scaled by 1.053" in printed) == shows_scan
        shown = json.loads(files["result.json"])
        assert [each for each in shown["notes"] if "mm from nipple_L to another" in each]
        assert not any(b"scar of M" in content for content in files.values())
        assert "scar of M" not in printed
        assert "marks" not in shown
        for name, place in true.landmarks.items():
            assert np.linalg.norm(shown["landmarks"][name] - place) * true.metres_per_unit < (
                0.5e-3 if shows_scan else 5e-3
            )
        [line] = json.loads(files["plan.json"])["shapes"]
        np.testing.assert_allclose(line["points"], lines[0]["points"], atol=0.01 if shows_scan else 15.0)
        body = trimesh.load(io.BytesIO(files["fitted.ply"]), file_type="ply", process=False).vertices
        assert np.abs(body - true.vertices).max() * true.metres_per_unit < (0.5e-3 if shows_scan else 20e-3)
        if shows_scan:
            mesh = trimesh.load(io.BytesIO(files["mesh.glb"]), file_type="glb", force="mesh")
            places = true.metres_per_unit * true.scan_vertices
            np.testing.assert_allclose(mesh.bounds, [places.min(axis=0), places.max(axis=0)], atol=1e-4)


@pytest.mark.slow
def test_a_size_that_the_file_does_not_say_is_asked_for_and_in_all_errors(
    fits: tuple[breastrig.Fit, breastrig.Fit], length: float, tmp_path: Path, capsys
) -> None:
    before, begins, rest = (EXAMPLE / "standing" / "scan.ply").read_bytes().partition(b"element vertex")
    (tmp_path / "scan.ply").write_bytes(before + b"comment Created with AliceVision\n" + begins + rest)
    picks = str(EXAMPLE / "standing" / "landmarks.json")
    assert main(["fit", str(tmp_path / "scan.ply"), "--landmarks", picks, "-o", str(tmp_path / "out")]) == 0
    asked = "The size of this scan is not known, and all errors allow for 4 % of it; measure on the patient "
    assert asked in capsys.readouterr().err
    unknown, known = breastrig.Fit.load(tmp_path / "out").result, fits[0].result
    assert (unknown["size_known"], "size_known" in known) == (False, False)
    assert unknown["line_error_mm"] > known["line_error_mm"] + 1.0
    assert all(unknown["landmark_uncertainty_mm"][name] > mm for name, mm in known["landmark_uncertainty_mm"].items())
    assert unknown["landmarks"] == known["landmarks"]
    [reason] = unknown["verdict"]["reasons"]
    assert reason.startswith(asked)
    row = numbers_of((tmp_path / "out" / "result.json").read_bytes(), measures_csv_of(ReportJob(tmp_path / "out")))
    assert list(row.items())[-1] == ("size", UNKNOWN_SIZE)
    scaled = breastrig.fit(tmp_path / "scan.ply", picks, refine=False, length=(*ENDS, length)).result
    assert ("size_known" in scaled, scaled["verdict"]["reasons"]) == (False, [])


@pytest.mark.slow
def test_the_command_line_takes_the_length(small: Path, length: float, tmp_path: Path, capsys) -> None:
    command = ["fit", str(small / "scan.ply"), "--landmarks", str(small / "landmarks.json"), "--no-refine"]
    assert main([*command, "--length", *ENDS, f"{length}", "-o", str(tmp_path / "out")]) == 0
    assert "Scaled by 1.053" in capsys.readouterr().err
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assert result["scale"]["factor"] == pytest.approx(1.0 / SMALL, abs=1e-4)
    transferred = ["transfer", *(word for end in ("--from", "--to") for word in (end, str(tmp_path / "out")))]
    drawing = str(tmp_path / "out" / "drawing.json")
    assert main([*transferred, "-o", str(tmp_path / "own.json")]) == 0
    assert "scaled" not in capsys.readouterr().err  # its own lines are in its size
    assert main([*transferred, "--drawing", drawing, "-o", str(tmp_path / "given.json")]) == 0
    assert "The scan of --from was scaled by 1.053" in capsys.readouterr().err
    assert main([*command, "--length", "nose", ENDS[1], "180", "-o", str(tmp_path / "no")]) == 2
    assert 'The length ends at "nose", no landmark or mark of this scan' in capsys.readouterr().err
    assert not (tmp_path / "no").exists()


@pytest.mark.slow
def test_the_size_is_no_doubt_any_more(tmp_path: Path) -> None:
    """A body a quarter too large is asked about, but not where a length gave it its size."""
    large = trimesh.load(EXAMPLE / "standing" / "scan.ply", process=False)
    large.apply_scale(1.2)
    (tmp_path / "scan.ply").write_bytes(large.export(file_type="ply"))
    picks = {name: 1.2e-3 * place for name, place in places("standing").items()}
    plain = breastrig.fit(tmp_path / "scan.ply", picks, units="m", refine=False)
    mm = 1e3 * float(np.linalg.norm(picks[ENDS[0]] - picks[ENDS[1]]))
    known = breastrig.fit(tmp_path / "scan.ply", picks, units="m", refine=False, length=(*ENDS, mm))
    assert any(reason.startswith("The trunk is ") for reason in plain.verdict.reasons)
    assert not any(reason.startswith("The trunk is ") for reason in known.verdict.reasons)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (("a", "b"), "A length is two names and millimetres"),
        ("a b 187", "A length is two names and millimetres"),
        (("a", 2.0, 187.0), "A length is two names and millimetres"),
        (("a", "b", "long"), 'must be a number of millimetres above 0, not "long"'),
        (("a", "b", True), 'must be a number of millimetres above 0, not "True"'),
        (("a", "b", -187.0), "must be a number of millimetres above 0"),
        (("a", "b", float("nan")), "must be a number of millimetres above 0"),
        (("a", "b", "1e9"), "must be a number of millimetres above 0"),
        (("a", "a", 187.0), "A length has two ends, and both are a"),
        (("a", "c", 187.0), r'The length ends at "c", no landmark or mark of this scan; there are: a, b\.'),
        (
            ("a", "b", 18.7),
            "it is 100 mm in the scan, but 18.7 mm were given; check the scan's unit and the millimetres",
        ),
        (("a", "b", 126.0), "it is 100 mm in the scan, but 126 mm were given"),
    ],
)
def test_a_length_that_cannot_be_meant_is_refused_in_one_sentence(given, says: str) -> None:
    with pytest.raises(BadLandmarks, match=says):
        true_size(length_of(given) or Length("", "", 0.0), {"a": np.zeros(3), "b": np.array([0.1, 0.0, 0.0])})


def test_a_size_that_is_given_back_by_its_ends_is_the_same_to_the_last_bit() -> None:
    """So that fits of it count again; a sixth of them would not."""
    random = np.random.default_rng(7)
    for _ in range(50):
        ends, times = random.uniform(-0.2, 0.4, (2, 3)).round(5), random.uniform(0.85, 1.2)
        length = Length("a", "b", round(1e3 * times * float(np.linalg.norm(ends[0] - ends[1])), 1))
        first = true_size(length, dict(zip("ab", ends, strict=True)))
        back = 1e-3 * (first.factor * np.array(first.ends_mm) / first.factor)
        assert true_size(length, dict(zip("ab", back, strict=True))).factor == first.factor

"""A chest wall that a label map names: from the file to the lesion on another scan, through each door."""

import json
import shutil
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from helpers.label_maps import in_lps
from helpers.results import without_hashes
from helpers.walled_patient import LESION, WALL, contours, image, lesion_of, marks, uid, walled_patient

import breastrig
from breastrig.cli.main import main
from breastrig.core.errors import BadInput
from breastrig.core.identity import Identity
from breastrig.drawings.plan_schema import empty_plan_on_scan
from breastrig.files.result import ResultFile, read_result
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.use.reports import share_snapshot
from breastrig.use.reports.share_snapshot import SnapshotJob, snapshot_files
from breastrig.use.steps.prepare import scan_of_job
from breastrig.use.steps.settings import FitJob

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def rig() -> Rig:
    return read_rig(default_rig_path())


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of the command line: prone, standing; and prone as a version that kept no wall left it."""
    folder = tmp_path_factory.mktemp("walled")
    walled_patient(folder)
    for stance, scan in (("prone", "mri.nrrd"), ("standing", "standing.ply")):
        words = ["fit", str(folder / scan), "--landmarks", str(folder / f"{stance}.json"), "--stance", stance]
        assert main([*words, "-o", str(folder / stance), "--no-progress"]) == 0
    shutil.copytree(folder / "prone", folder / "unseen")
    result = read_result(folder / "prone").model_copy(update={"wall": None})
    (folder / "unseen" / "result.json").write_bytes(result.content())
    return folder


@cache
def carried(fits: Path, start: str) -> dict:
    """The lesion standing."""
    out = fits / f"from_{start}.json"
    words = ["transfer", "--from", str(fits / start), "--to", str(fits / "standing"), "-o", str(out), "--force"]
    assert main(words) == 0
    (lesion,) = json.loads(out.read_text())["lesions"]
    return lesion


def test_a_lesion_near_the_wall_stays_by_the_breastbone(fits: Path, rig: Rig) -> None:
    true = 1e3 * lesion_of(rig)
    held, free = carried(fits, "prone"), carried(fits, "unseen")
    off, off_free = (float(np.linalg.norm(each["center"] - true)) for each in (held, free))
    assert off < 0.6 * off_free
    assert off < 5.0
    assert held["error_mm"] == pytest.approx(free["error_mm"], abs=0.5)  # that of where it comes to lie
    prone, standing = (breastrig.Fit.load(fits / each) for each in ("prone", "standing"))
    (same,) = breastrig.transfer(prone, standing).lesions
    assert same.center == pytest.approx(held["center"], abs=1e-6)
    (line,) = (each for each in prone.notes if "chest wall" in each)
    assert line.startswith("The chest wall is the front of the muscle or wall that this file names")


def test_the_distance_to_a_wall_that_is_seen_has_a_small_band_and_its_slices_show_it(fits: Path, rig: Rig) -> None:
    plan = {"schema": "breastrig/plan@1", "items": [lesion_item(fits)]}
    drawing = breastrig.draw(breastrig.Fit.load(fits / "prone"), plan)
    (lesion,) = drawing.document["lesions"]
    (chest,) = (each for each in lesion["distances"] if each["kind"] == "chest_wall")
    assert chest["seen"] is True
    assert chest["mm"] == pytest.approx(1e3 * LESION, abs=1.5)
    assert chest["high_mm"] - chest["mm"] == pytest.approx(4.0, abs=0.01)
    plane = in_lps(marks(rig, rig.template)["nipple_L"])[1] + 1e3 * WALL
    for cut in lesion["slices"]:
        if cut["plane"] == "coronal":
            continue
        points = lesion["center"] + np.concatenate(cut["wall_mm"]) @ np.array([cut["right"], cut["up"]])
        assert np.median(points[:, 1]) == pytest.approx(plane, abs=1.5)
    (standing,) = breastrig.transfer(fits / "prone", fits / "standing").document["lesions"]
    (chest,) = (each for each in standing["distances"] if each["kind"] == "chest_wall")
    assert "seen" not in chest  # which no scan of the surface shows


def lesion_item(fits: Path) -> dict:
    (lesion,) = read_result(fits / "prone").lesions
    return {"kind": "lesion", "id": "a", "name": "A", "center": list(lesion.center), "radius_mm": lesion.radius_mm}


def test_a_body_that_is_predicted_has_no_wall_and_takes_lesions_from_one(fits: Path) -> None:
    predicted = breastrig.predict(fits / "standing", "supine")
    (held,), (free,) = (breastrig.transfer(fits / each, predicted).lesions for each in ("prone", "unseen"))
    assert np.linalg.norm(held.center - free.center) > 2.0
    assert breastrig.predict(fits / "prone", "supine").in_metres.wall is None
    assert breastrig.Fit.load(fits / "prone").in_metres.wall is not None


@pytest.mark.usefixtures("batch_here")
def test_a_case_and_a_batch_have_it(fits: Path, tmp_path: Path) -> None:
    wanted = read_result(fits / "prone").wall
    assert wanted is not None
    case = breastrig.Case.create(tmp_path / "hers")
    scan = case.add_scan(fits / "mri.nrrd")
    case.put_landmarks(scan, fits / "prone.json")
    assert case.fit(scan, stance="prone").in_metres.result.wall == wanted
    (tmp_path / "table.csv").write_text(f"scan,landmarks,stance\n{fits}/mri.nrrd,{fits}/prone.json,prone\n")
    assert main(["batch", str(tmp_path / "table.csv"), "-o", str(tmp_path / "batch"), "--jobs", "1"]) == 0
    assert read_result(tmp_path / "batch" / "0001-mri").wall == wanted
    case.delete_scan(scan)
    assert not any(b'"wall"' in file.read_bytes() for file in (tmp_path / "hers").rglob("*") if file.is_file())


def test_a_link_has_no_surface_of_it(fits: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(share_snapshot, "report_pdf_of", lambda _job: b"")
    plan = empty_plan_on_scan("mm") | {"version": 0, "whole": False}
    for shows_scan in (True, False):
        job = SnapshotJob(fits / "prone", plan, (), Identity(), tmp_path, shows_scan=shows_scan)
        assert "wall" not in json.loads(snapshot_files(job)["result.json"])


@pytest.fixture(scope="module")
def drawn(fits: Path, rig: Rig) -> Path:
    """mri.zip, and drawn.dcm: wall and lesion as contours on it."""
    (fits / "mri.zip").write_bytes(image(rig))
    (fits / "drawn.dcm").write_bytes(contours(rig))
    return fits


def lies_on_the_plate(found: ResultFile | None, rig: Rig) -> bool:
    assert found is not None
    assert found.wall is not None
    plane = in_lps(marks(rig, rig.template)["nipple_L"])[1] + 1e3 * WALL
    away = np.abs(np.array(found.wall.points)[:, 1] - plane)
    return bool(np.median(away) < 1.0 and np.percentile(away, 90) < 4.0)  # its rim is rounded


def test_contours_on_an_image_have_it_by_option_argument_column_and_beside_it(
    drawn: Path, rig: Rig, tmp_path: Path
) -> None:
    words = ["fit", str(drawn / "mri.zip"), "--landmarks", str(drawn / "prone.json"), "-o", str(drawn / "by_option")]
    assert main([*words, "--lesions", str(drawn / "drawn.dcm"), "--no-progress"]) == 0
    result = read_result(drawn / "by_option")
    assert lies_on_the_plate(result, rig)
    assert [each.name for each in result.lesions] == ["Lesion 1"]
    off = np.linalg.norm(carried(drawn, "by_option")["center"] - 1e3 * lesion_of(rig))
    assert off < 0.7 * np.linalg.norm(carried(drawn, "unseen")["center"] - 1e3 * lesion_of(rig))
    scan = breastrig.read_scan(drawn / "mri.zip")
    assert scan.in_metres.wall is None
    known = scan.with_lesions(drawn / "drawn.dcm").in_metres.wall
    beside = breastrig.read_scan(image(rig, contours(rig))).in_metres.wall
    assert known is not None
    assert beside is not None
    np.testing.assert_allclose(1e3 * known[0], result.wall.points, atol=0.06)
    np.testing.assert_array_equal(beside[0], known[0])
    job = FitJob(drawn / "mri.zip", tmp_path, {}, lesions=(contours(rig),))  # as a row of a batch has it
    assert scan_of_job(job).wall is not None


def test_a_wall_alone_is_taken_in_the_images_own_frame_only(drawn: Path, rig: Rig) -> None:
    scan = breastrig.read_scan(drawn / "mri.zip")
    alone = scan.with_lesions(contours(rig, lesion=""))
    assert (alone.in_metres.wall is not None, alone.in_metres.lesions) == (True, ())
    assert any("No segment of this file was taken for a lesion" in note for note in alone.notes)
    assert scan.with_lesions(contours(rig, "Ribs")).in_metres.wall is None
    elsewhere = contours(rig, lesion="").replace(uid("frame").encode(), uid("another")[: len(uid("frame"))].encode())
    assert scan.with_lesions(elsewhere).in_metres.wall is None


def test_a_case_keeps_it_with_the_scan_for_the_fits_that_come(drawn: Path, rig: Rig, tmp_path: Path) -> None:
    case = breastrig.Case.create(tmp_path / "hers")
    scan = case.add_scan(drawn / "mri.zip")
    case.put_landmarks(scan, drawn / "prone.json")
    assert case.fit(scan).in_metres.wall is None
    taken = case.add_lesions(scan, drawn / "drawn.dcm")
    assert any(note.endswith("do not know its chest wall; fit it again.") for note in taken.notes)
    given, kept = breastrig.read_scan(drawn / "mri.zip").with_lesions(drawn / "drawn.dcm"), case.read_scan(scan)
    assert np.array_equal(kept.vertices, given.vertices)
    assert given.in_metres.wall is not None
    assert kept.in_metres.wall is not None  # which the next fit reads
    assert np.array_equal(kept.in_metres.wall[0], given.in_metres.wall[0])
    (drawn / "ribs.dcm").write_bytes(contours(rig, "Ribs"))
    assert not any("do not know" in note for note in case.add_lesions(scan, drawn / "ribs.dcm").notes)
    assert case.read_scan(scan).in_metres.wall is not None


@pytest.mark.parametrize(
    ("wall", "where"),
    [
        ({"points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 1, 3]]}, "wall"),
        ({"points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 1, -1]]}, "wall"),
        ({"points": [[0, 0, 0], [1, 0, 0], [0, 1, "nan"]], "triangles": [[0, 1, 2]]}, "wall.points.2.2"),
        ({"points": [[0, 0, 0]] * 11_001, "triangles": [[0, 1, 2]]}, "wall.points"),
        ({"points": [], "triangles": []}, "wall.triangles"),
    ],
)
def test_a_damaged_wall_is_said(wall: dict, where: str, fits: Path, tmp_path: Path) -> None:
    folder = without_hashes(Path(shutil.copytree(fits / "prone", tmp_path / "prone")))
    document = json.loads((folder / "result.json").read_text())
    (folder / "result.json").write_text(json.dumps(document | {"wall": wall}))
    with pytest.raises(BadInput, match=rf"prone/result.json is damaged or of another version \({where}\)"):
        breastrig.transfer(folder, fits / "standing")

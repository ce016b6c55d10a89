"""Two stances from files to files: two stories, one body, nothing of one in the other's result."""

import json
from pathlib import Path

import pytest

from breastrig.core.assets import asset_folder
from breastrig.core.errors import BadScan, BadSettings
from breastrig.core.units import METRES_PER_UNIT
from breastrig.fitting.two_stances import ONE_BODY
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.workflow.events import Done, Event, Iterated, Started
from breastrig.workflow.jobs import FitJob
from breastrig.workflow.run_pair import pair_document, run_pair

EXAMPLE = asset_folder("example")


def job(stance: str, out: Path) -> FitJob:
    places, unit = read_landmarks(EXAMPLE / stance / "landmarks.json")
    assert unit is not None
    factor = 1e3 * METRES_PER_UNIT[unit]
    landmarks = {name: [factor * float(value) for value in place] for name, place in places.items()}
    return FitJob(EXAMPLE / stance / "scan.ply", out, landmarks)


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[tuple[int, Event]]]:
    folder = tmp_path_factory.mktemp("pair")
    jobs = job("standing", folder / "a"), job("supine", folder / "b")
    events = list(run_pair(*jobs, ONE_BODY))
    return folder, events


@pytest.mark.slow
def test_both_stories_are_whole_and_end_together(told: tuple[Path, list[tuple[int, Event]]]) -> None:
    stories = [[event for which, event in told[1] if which == side] for side in (0, 1)]
    for story, stance in zip(stories, ("standing", "supine"), strict=True):
        assert isinstance(story[0], Started)
        assert story[0].stance == stance
        assert [event.iteration for event in story[1:-1] if isinstance(event, Iterated)] == list(range(len(story) - 2))
        assert isinstance(story[-1], Done)
        assert story[-1].result.document()["converged"]
    assert len(stories[0]) == len(stories[1])
    assert [type(event) for _, event in told[1][-2:]] == [Done, Done]


def test_the_body_is_one_and_the_soft_tissue_is_not(told: tuple[Path, list[tuple[int, Event]]]) -> None:
    ends = [event.result for _, event in told[1] if isinstance(event, Done)]
    pair = pair_document(read_rig(default_rig_path()), ends, ("a/result.json", "b/result.json"), ONE_BODY)
    results = [json.loads((told[0] / place).read_text()) for place in pair["results"].values()]
    scales = [{bone["name"]: bone["scale"] for bone in result["parameters"]["bones"]} for result in results]
    assert scales[0] == scales[1] == pair["shared"]["bone_scales"]
    shapes = [result["parameters"]["blendshapes"] for result in results]
    body = pair["shared"]["blendshapes"]
    assert all(shapes[0][name] == shapes[1][name] == body[name] for name in body)
    assert any(shapes[0][name] != shapes[1][name] for name in shapes[0].keys() - body.keys())
    assert pair["schema"] == "breastrig/pair@1"
    assert pair["stances"] == ["standing", "supine"]


def test_each_folder_is_that_of_a_fit_and_names_nothing_of_the_other(
    told: tuple[Path, list[tuple[int, Event]]],
) -> None:
    folder = told[0]
    for name, other in (("a", "b"), ("b", "a")):
        files = {file.name for file in (folder / name).iterdir()}
        assert files == {
            "result.json",
            "scan.ply",
            "fitted.ply",
            "fitted.glb",
            "drawing.json",
            "distances.bin",
            "uncertainty.bin",
            "body.bin",
            "fit.log.jsonl",
        }
        sha = json.loads((folder / other / "result.json").read_text())["scan"]["sha256"]
        assert sha not in (folder / name / "result.json").read_text()


def test_the_same_scan_twice_is_refused_also_as_a_copy(tmp_path: Path) -> None:
    first = job("standing", tmp_path / "a")
    copy = tmp_path / "copy.ply"
    copy.write_bytes(first.scan.read_bytes())
    with pytest.raises(BadScan, match="the same file"):
        list(run_pair(first, FitJob(copy, tmp_path / "b", {})))
    assert not (tmp_path / "a").exists()


def test_two_models_are_refused(tmp_path: Path) -> None:
    first = job("standing", tmp_path / "a")
    with pytest.raises(BadSettings, match="one model"):
        list(run_pair(first, FitJob(first.scan, tmp_path / "b", {}, model=tmp_path / "other.glb")))


@pytest.mark.slow
def test_who_stops_listening_stops_both(tmp_path: Path) -> None:
    steps = run_pair(job("standing", tmp_path / "a"), job("supine", tmp_path / "b"))
    assert isinstance(next(steps)[1], Started)
    steps.close()
    assert not (tmp_path / "a").exists()
    assert not (tmp_path / "b").exists()


def test_a_wrong_pick_on_one_scan_is_named_there_and_followed_nowhere(tmp_path: Path) -> None:
    right, wrong = job("standing", tmp_path / "a"), job("supine", tmp_path / "b")
    wrong.landmarks_mm["suprasternal_notch"] = wrong.landmarks_mm["nipple_L"]
    first, second = [event.result.document() for _, event in run_pair(right, wrong) if isinstance(event, Done)]
    assert first["landmarks_not_followed"] == []
    assert [doubt["names"] for doubt in second["landmarks_not_followed"]] == [["suprasternal_notch"]]
    assert first["surface_distance_mm"]["mean"] < 0.78
    assert second["surface_distance_mm"]["mean"] < 1.05
    others = {name: gap for name, gap in second["landmark_distance_mm"]["each"].items() if name != "suprasternal_notch"}
    assert max(others.values()) < 6.5
    assert second["landmark_distance_mm"]["each"]["suprasternal_notch"] > 40.0  # 50 mm off, and left there

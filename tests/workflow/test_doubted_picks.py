"""Picks that cannot be right are named in the events, as soon as the fit knows."""

from pathlib import Path

import pytest

from breastrig.core.assets import asset_folder
from breastrig.scan.landmark_files import read_landmarks
from breastrig.workflow.events import Done, Started
from breastrig.workflow.run_fit import FitJob, run_fit

EXAMPLE = asset_folder("example") / "standing"
OTHER_SIDE = {"_L": "_R", "_R": "_L"}


def events(landmarks: dict[str, list[float]], out: Path) -> tuple[Started, Done]:
    first, *_, last = run_fit(FitJob(scan=EXAMPLE / "scan.ply", out=out, landmarks_mm=landmarks))
    assert isinstance(first, Started)
    assert isinstance(last, Done)
    return first, last


@pytest.fixture
def picks() -> dict[str, list[float]]:
    places, unit = read_landmarks(EXAMPLE / "landmarks.json")
    assert unit == "mm"
    return {name: [float(value) for value in place] for name, place in places.items()}


def test_all_sides_exchanged_are_named_before_the_first_step_and_at_the_end(picks, tmp_path: Path) -> None:
    exchanged = {name[:-2] + OTHER_SIDE.get(name[-2:], name[-2:]): place for name, place in picks.items()}
    started, done = events(exchanged, tmp_path)
    [doubt] = started.landmarks_not_followed
    assert doubt.names == list(exchanged)
    assert "exchanged" in doubt.reason
    assert done.result["landmarks_not_followed"] == [doubt.model_dump()]


def test_one_pick_far_off_is_named_at_the_end(picks, tmp_path: Path) -> None:
    wrong = picks | {"xiphoid": [picks["xiphoid"][0] + 50.0, *picks["xiphoid"][1:]]}
    started, done = events(wrong, tmp_path)
    assert started.landmarks_not_followed == []
    result = done.model_dump(mode="json")["result"]
    assert result["landmarks_not_followed"] == []
    assert [doubt["names"] for doubt in result["landmarks_unusual"]] == [["xiphoid"]]

"""A fit that goes on from an earlier one of the same scan ends where a fresh fit with the same picks ends."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.example_patient import EXAMPLE
from helpers.random_pose import random_parameters

from breastrig.core.errors import BadSettings
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting import hypotheses
from breastrig.fitting.hypotheses import FoundStance, ScanOrientation, with_stance
from breastrig.fitting.prepare_scan import PreparedScan
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.task import FitTask
from breastrig.gltf.pose_nodes import node_poses, posed_by_nodes
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.similarity import Similarity
from breastrig.scan.clean import Surface
from breastrig.scan.orient import LABEL_MAP_FRAME
from breastrig.use.fit import run_fit
from breastrig.use.steps.events import Event
from breastrig.use.steps.settings import EarlierFit, FitJob

PICKS = json.loads((EXAMPLE / "landmarks.json").read_text())["landmarks"]


def events_of(out: Path, picks: dict[str, list[float]], **more: object) -> list[Event]:
    return list(run_fit(FitJob(EXAMPLE / "scan.ply", out, picks, **more)))


def nodes(event: Event) -> list[dict[str, object]]:
    return event.model_dump()["nodes"]


def test_nodes_and_parameters_are_two_words_for_one_pose(rig: Rig, rng: np.random.Generator) -> None:
    x = random_parameters(rig, rng)
    back = posed_by_nodes(rig, node_poses(rig, x))
    for field in ("rotations", "translations", "scales", "weights"):
        assert np.allclose(getattr(back, field), getattr(x, field), atol=2e-6)


def test_the_pose_of_another_model_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadSettings, match="another model"):
        events_of(tmp_path, PICKS, earlier=EarlierFit("standing", [], "0" * 64))


@pytest.mark.parametrize(("apart", "stance"), [(0.0, "supine"), (0.03, "supine"), (0.2, "standing")])
def test_landmarks_change_no_stance_unless_the_scan_alone_was_fitted_elsewhere(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, apart: float, stance: str
) -> None:
    monkeypatch.setattr(hypotheses, "found_stance", lambda task, frame: FoundStance("standing", "Found anew."))
    x = rest_parameters(rig)
    start = Similarity(1.0, np.eye(3), np.zeros(3))
    orientation = ScanOrientation(rig.sha256, LABEL_MAP_FRAME, start, 1.0, "supine", "As found before.", x)
    places = rig.landmark_points().positions(rig.template, rig.faces) + apart * np.eye(3)[0]
    target = ScanTarget(rig.template, rig.faces)
    task = FitTask(rig, target, x, load_recipe("default"), {}).with_picks(
        dict(zip(rig.landmark_names, places, strict=True))
    )
    scan = PreparedScan(Surface(rig.template, rig.faces, ()), target, 0, LABEL_MAP_FRAME)
    assert with_stance(task, "auto", scan, orientation)[0].stance == stance
    assert with_stance(replace(task, given={}), "auto", scan, orientation)[0].stance == "supine"

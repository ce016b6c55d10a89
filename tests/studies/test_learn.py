"""What is estimated of a rig makes its radii hold nine of ten true places, and is read as it was written."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.forearm import write_bodies, write_forearm

from breastrig.core.errors import BadInput
from breastrig.fitting.uncertainty.calibration import calibration
from breastrig.fitting.uncertainty.radii import HOLDS_90
from breastrig.fitting.verdicts.fit_signals import FitSignals
from breastrig.fitting.verdicts.verdict import verdict_limits
from breastrig.gltf.read_rig import read_rig
from breastrig_studies import learn

SIGNALS = FitSignals(0.6, 0.9, 0.0024, 0.004, 0.17, 0.99, 1.0, 0.11, 0.07)
MISFITS = {"shown": 0.003, "hidden": 0.008}  # m, in truth
VARIANCE = 0.002**2  # m²


def test_radii_hold_nine_of_ten_places_and_limits_are_those_that_people_chose(tmp_path: Path) -> None:
    glb, _, _ = write_forearm(tmp_path)
    rig, rng, found = read_rig(glb), np.random.default_rng(0), learn.Found()
    count = len(rig.template)

    def errors(misfit: float, number: int) -> np.ndarray:  # on the skin: two directions
        return np.sqrt(VARIANCE + misfit**2) * np.linalg.norm(rng.normal(size=(number, 2)), axis=1) / np.sqrt(2.0)

    seen = np.arange(count) % 2 == 0
    for k in range(40):
        off = np.where(seen, errors(MISFITS["shown"], count), errors(MISFITS["hidden"], count))
        landmarks = {name: (float(errors(0.003, 1)[0]), VARIANCE) for name in rig.landmark_names}
        worst = replace(SIGNALS, distance_p95=0.0033, beyond=0.014, explained=0.975) if k == 7 else SIGNALS
        picks = frozenset(rig.landmark_names) if k % 2 else frozenset()
        kind = "exact" if picks else "none"
        trial = learn.Trial(
            kind, picks, landmarks, (off, np.full(count, VARIANCE)), seen, 1.0, worst, None if picks else 0.4
        )
        learn.add(found, rig, trial, usual=1.0)
    astray = replace(trial, landmarks=dict.fromkeys(landmarks, (0.2, VARIANCE)), margin=0.25)
    learn.add(found, rig, astray, usual=1.0)

    learn.write(glb, rig, found, usual=1.0, stances={"standing"}, scans=40)
    known, limits = calibration(read_rig(glb)), verdict_limits(read_rig(glb))
    assert known is not None
    assert limits is not None
    for name in MISFITS:
        misfit = getattr(known.region("wrist"), name)
        radius = HOLDS_90 * np.sqrt(VARIANCE + misfit**2)
        assert np.mean(errors(MISFITS[name], 20000) <= radius) == pytest.approx(0.9, abs=0.02)
    assert known.without_picks.clear == pytest.approx(0.325)  # wrong fits were as clear as 0.25
    chosen = {"distance_p95": (0.00375, 0.006), "beyond": (0.019, 0.044), "explained": (0.9675, 0.93)}
    for name, pair in chosen.items():  # by hand the torso has 4 and 6 mm, 0.02 and 0.05, 0.96 and 0.85
        assert (limits.signals[name].check, limits.signals[name].no_torso) == pytest.approx(pair, rel=2e-3)
    assert "stretch" not in limits.signals  # all fits were alike


def test_too_few_bodies_are_one_sentence(tmp_path: Path) -> None:
    glb, _, _ = write_forearm(tmp_path)
    write_bodies(tmp_path / "bodies", 2)
    with pytest.raises(BadInput, match="bodies has fewer than 6 bodies to learn from; more are needed"):
        learn.learn(glb, tmp_path / "bodies")

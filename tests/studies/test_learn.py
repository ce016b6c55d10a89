"""What is estimated of a rig makes its radii hold nine of ten true places, and is read as it was written."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.forearm import posed_forearm, write_bodies, write_forearm

import breastrig
from breastrig.cli.main import main
from breastrig.core.errors import BadInput
from breastrig.fitting.uncertainty.radii import calibration
from breastrig.fitting.verdicts.fit_signals import FitSignals
from breastrig.fitting.verdicts.verdict import verdict_limits
from breastrig.gltf.read_rig import read_rig
from breastrig.rig.model import Rig
from breastrig_studies import learn
from breastrig_studies.radii_factors import Score

SIGNALS = FitSignals(0.6, 0.9, 0.0024, 0.004, 0.17, 0.99, 1.0, 0.11, 0.07)
SPREAD = {"seen": 1.5, "hidden": 4.0}  # of errors, in deviations of the posterior


def test_radii_hold_nine_of_ten_places_and_limits_are_those_that_people_chose(tmp_path: Path) -> None:
    glb, _, _ = write_forearm(tmp_path)
    rig, rng, found = read_rig(glb), np.random.default_rng(0), learn.LearnedFits()
    for k in range(40):
        scores = [
            Score(state, "wrist", float(spread * each), deviation=0.002, strain=1.0, part=False, scatter=1.0)
            for state, spread in SPREAD.items()
            for each in np.linalg.norm(rng.normal(size=(50, 2)), axis=1)
        ]
        worst = replace(SIGNALS, distance_p95=0.0033, beyond=0.014, explained=0.975) if k == 7 else SIGNALS
        found.add(rig, learn.Trial(f"arm {k}", "standing", scores, 0.003, worst, None if k % 2 else 0.4))
    found.add(rig, learn.Trial("arm 41", "standing", [replace(scores[0], score=99.0)], 0.2, SIGNALS, 0.25))

    learn.write(glb, rig, found, stances={"standing"}, scans=40)
    known, limits = calibration(read_rig(glb)), verdict_limits(read_rig(glb))
    assert limits is not None
    for state, spread in SPREAD.items():
        factor = getattr(known.of_stance("standing"), state)["wrist"]
        new = spread * np.linalg.norm(rng.normal(size=(20000, 2)), axis=1)
        assert 0.9 <= np.mean(new <= factor) < 0.94  # a little more, for 40 arms are few
    assert known.without_picks.clear == pytest.approx(0.325)  # wrong fits were as clear as 0.25
    lost = [known.without_picks.lost(margin) for margin in (0.4, 0.325, 0.25, 0.08, 0.0)]
    assert lost[:2] == [0.0, 0.0]  # right ones were clearer
    assert 0.0 < lost[2] < lost[3] == lost[4] == pytest.approx(0.5 * np.ptp(rig.template[:, 1]), abs=0.001)
    for name, limit in {"distance_p95": 0.006, "beyond": 0.044, "explained": 0.93}.items():
        assert limits.signals[name].limit == pytest.approx(limit, rel=2e-3)  # by hand the torso has 6 mm, 0.05, 0.85
    assert "stretch" not in limits.signals  # all fits were alike


def test_too_few_bodies_and_unknown_ones_are_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    glb, _, _ = write_forearm(tmp_path)
    write_bodies(tmp_path / "bodies", 2)
    with pytest.raises(BadInput, match="bodies has fewer than 6 bodies to learn from; more are needed"):
        learn.learn(glb, tmp_path / "bodies")
    monkeypatch.setattr(learn, "FEWEST", 2)
    monkeypatch.setattr(learn, "reference_fit", None)  # it is said before any fit
    (tmp_path / "bodies" / "forearm_01" / "standing" / "truth.ply").unlink()
    with pytest.raises(BadInput, match=r"without truth\.ply \(forearm_01/standing\); nothing can be learned"):
        learn.learn(glb, tmp_path / "bodies")


def test_a_learning_that_is_interrupted_leaves_what_was_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """New bodies stood beside old radii, bound as one."""
    glb, _, _ = write_forearm(tmp_path)
    write_bodies(tmp_path / "bodies", 2)
    monkeypatch.setattr(learn, "FEWEST", 2)

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(learn, "residuals_of", interrupted)
    with pytest.raises(KeyboardInterrupt):
        learn.learn(glb, tmp_path / "bodies")
    assert not glb.with_suffix(".known").exists()


def test_what_the_command_learns_of_a_rig_is_what_its_fits_go_by(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    glb, scan, places = write_forearm(tmp_path)
    write_bodies(tmp_path / "bodies", 2)
    before = breastrig.fit(breastrig.read_scan(scan, "mm"), places, model=glb)
    assert (before.verdict.level, before.result["landmark_uncertainty_mm"]) == ("uncalibrated", {})
    monkeypatch.setattr(learn, "FEWEST", 2)
    assert main(["model", "learn", str(glb), str(tmp_path / "bodies")]) == 0
    assert "what is known of forearm.glb" in capsys.readouterr().out
    fit = breastrig.fit(breastrig.read_scan(scan, "mm"), places, model=glb)
    assert fit.result.get("not_calibrated") is None
    assert fit.verdict.level in ("good", "check")  # two arms are few: limits are where these two were
    radii = fit.result["landmark_uncertainty_mm"]
    truth = dict(zip(fit.model.landmark_names, _marks(fit.model, posed_forearm(fit.model)[0]), strict=True))
    assert set(radii) == set(truth)
    for name, place in truth.items():
        assert np.linalg.norm(np.array(fit.result["landmarks"][name]) - 1e3 * place) < radii[name] < 40.0


def _marks(rig: Rig, vertices: np.ndarray) -> np.ndarray:
    return rig.landmark_points().positions(vertices, rig.faces)

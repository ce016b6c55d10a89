"""A patient's own breasts by finite elements: where they go, and the stiffness that a second scan shows."""

from collections.abc import Generator
from typing import Any

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.volume.breast_skin import BreastSkin, breast_skins
from breastrig.volume.gravity.simulated import Patient, simulated
from breastrig.volume.gravity.soft_breast import published
from breastrig.volume.gravity.statics import NoEquilibrium
from breastrig.volume.predicted import gravity_prior, posture
from breastrig.volume.tetrahedra import volume_mesh


@pytest.fixture(scope="module")
def rig() -> Rig:
    return read_rig(default_rig_path())


def ended(steps: Generator[Any, None, Any]) -> tuple[list[Any], Any]:
    said = []
    while True:
        try:
            said.append(next(steps))
        except StopIteration as end:
            return said, end.value


def test_a_stiff_breast_falls_back_when_she_lies_and_its_rim_stays(rig: Rig) -> None:
    patient = Patient(rig, volume_mesh(rig, rest_parameters(rig), rig.template), rig.template, "standing")
    left = breast_skins(rig)[0]
    move = patient.moved(left, "supine", 8.0)
    areola = np.isin(left.skin, rig.regions["areola_L"])
    assert (move[areola].mean(axis=0) * [1.0, 1.0, -1.0] > 0.0005).all()  # outwards, up, back
    rim = np.isin(left.skin, rig.faces[~np.isin(rig.faces, left.skin).all(axis=1)])
    assert np.abs(move[rim]).max() < 1e-9


class Spring(Patient):
    """Its breasts move all the farther the softer they are; the softest do not come to rest."""

    def moved(self, side: BreastSkin, goal: str, factor: float) -> Array:
        if factor < 0.6:
            raise NoEquilibrium("too soft")
        return np.where(side.breast, 0.03 / factor, 0.0)[:, None] * [0.0, 0.0, 1.0 if goal == "prone" else -1.0]


def test_the_stiffness_is_the_one_that_a_second_scan_shows(rig: Rig) -> None:
    patient = Spring(rig, None, rig.template, "standing")  # type: ignore[arg-type]
    lying = rig.template + posture(rig, "supine")
    for side in breast_skins(rig):
        lying[side.skin] += patient.moved(side, "supine", 2.0)
    said, found = ended(simulated(patient, "prone", ("supine", lying)))
    nipple = rig.regions["areola_L"]
    forwards = (found.vertices - rig.template)[nipple, 2]
    _, guessed = ended(simulated(patient, "prone"))
    assert forwards == pytest.approx(0.015, rel=0.2)
    assert (guessed.vertices - rig.template)[nipple, 2] == pytest.approx(0.03)
    assert (found.radii[nipple] < guessed.radii[nipple]).all()
    shares = [step.share for step in said]
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert shares[-1] < 1.0


class Soft(Patient):
    """Its breasts move all the farther the softer they are."""

    def moved(self, side: BreastSkin, goal: str, factor: float) -> Array:
        return np.where(side.breast, 0.01 / factor, 0.0)[:, None] * [0.0, 0.0, 1.0]


def test_nine_of_ten_stiffnesses_keep_a_breast_within_its_radius(rig: Rig) -> None:
    """Drawn as it is published; a place moves as far as the softest of those lets it."""
    patient = Soft(rig, None, rig.template, "standing")  # type: ignore[arg-type]
    _, found = ended(simulated(patient, "prone"))
    prior = gravity_prior(rig)
    assert prior is not None
    nipple = rig.regions["areola_L"]
    within = np.sqrt(found.radii[nipple] ** 2 - prior.posture**2)
    spread = published()["fat"]["log_sd"]
    factors = np.exp(spread * np.random.default_rng(1).normal(size=100_000))
    off = np.abs(0.01 / factors - 0.01)
    assert within == pytest.approx(0.01 * (np.exp(1.645 * spread) - 1.0), rel=1e-3)
    assert 0.9 <= (off <= within.min()).mean() < 0.96  # stiffer ones are nearer than the softest
    rest = np.setdiff1d(np.arange(len(rig.template)), np.concatenate([side.skin for side in breast_skins(rig)]))
    assert found.radii[rest] == pytest.approx(prior.posture)

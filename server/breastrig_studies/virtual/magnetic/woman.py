"""Women lying prone, breasts hanging, as the rig's statistics of bodies have them: closed skins with nipples."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.stances import PRONE, SIDES, split_side
from breastrig.fitting.posterior import built_in
from breastrig.geometry.caps import closed
from breastrig.geometry.rotations import exp_so3
from breastrig.geometry.self_intersections import crossing_faces
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.rig.skinning import pose
from breastrig.rig.stance_priors import in_stance

SPREAD, APART = 0.6, 0.25  # of the prior's standard deviations; of them what the two sides do not share
RAISED, LOWERED = 1.0, -0.55  # rad, arms
TRIES = 40


@dataclass(frozen=True, eq=False)
class Woman:
    """A closed skin with its landmarks; mm, the DICOM patient frame (LPS)."""

    vertices: Array  # (V, 3)
    faces: Integers  # (F, 3), outwards
    landmarks: dict[str, Array]  # (3,) by name

    @property
    def nipples(self) -> dict[str, Array]:
        """(3,) by side."""
        return {side: self.landmarks[f"nipple_{side}"] for side in SIDES}


def in_lps(points: Array) -> Array:
    """(..., 3) mm of (..., 3) m of body coordinates (left, up, front)."""
    return np.asarray(1e3 * points[..., [0, 2, 1]] * [1.0, -1.0, 1.0])


def prone_woman(seed: int, arms: Literal["raised", "beside"] = "raised") -> Woman:
    """The woman of this seed; `beside` presses the arms to the trunk."""
    rig, random = read_rig(default_rig_path()), np.random.default_rng([53, seed])
    for _ in range(TRIES):
        skin = pose(rig, _drawn(rig, random, RAISED if arms == "raised" else LOWERED))
        regions = np.concatenate([rig.regions[name] for name in ("breast_L", "breast_R", "chest")])
        near = rig.faces[np.isin(rig.faces, regions).all(axis=1)]
        if not len(crossing_faces(skin, near)):
            break
    else:
        raise RuntimeError(f"No skin of seed {seed} is sound in {TRIES} tries.")
    shut = closed(skin, rig.faces)
    places = in_lps(rig.landmark_points().positions(skin, rig.faces))
    return Woman(in_lps(shut.vertices), shut.faces, dict(zip(rig.landmark_names, places, strict=True)))


def _drawn(rig: Rig, random: np.random.Generator, turn: float) -> RigParameters:
    prior, rest = built_in(rig, PRONE), rest_parameters(rig)
    if prior is None:
        raise RuntimeError("The rig has no statistics of bodies.")
    drawn = np.linalg.cholesky(prior.covariance) @ random.normal(size=len(prior.mean))
    bones = len(rig.bones)
    drawn, mean = drawn[3 * bones :], prior.mean[3 * bones :]
    names = list(rig.shape_names)
    for k, name in enumerate(names):
        stem, side = split_side(name)
        if side == "L":
            other = names.index(f"{stem}_R")
            drawn[k], drawn[other] = drawn[k], (1.0 - APART) * drawn[k] + APART * drawn[other]
    shapes = in_stance(rig, PRONE).shapes
    low, high = np.array([shape.min for shape in shapes]), np.array([shape.max for shape in shapes])
    rotations = rest.rotations.copy()
    for side, sign in (("L", 1.0), ("R", -1.0)):
        bone = rig.bone_names.index(f"upper_arm_{side}")
        rotations[bone] = exp_so3(np.array([[0.0, 0.0, sign * turn]]))[0] @ rotations[bone]
    return RigParameters(rotations, rest.translations, rest.scales, np.clip(mean + SPREAD * drawn, low, high))

"""Lengths of a trunk that no stance changes: at rest, from scales and from shapes of kind "body"."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.rig.cohort_posterior import Gaussian
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.rig.skinning import pose

TRUNK = ("pelvis", "lumbar", "lower_thorax", "upper_thorax")  # bones
NOTCH, XIPHOID, NAVEL = "suprasternal_notch", "xiphoid", "umbilicus"
STEP = 1e-4  # of a scale or weight, for slopes
LAYER = 0.012  # m up and down of a level, among whose vertices the outermost are looked for
MIDDLE = 0.02  # m from the midline, for front and back
BELOW_XIPHOID = 0.02  # m, where ribs are, free of the breasts
ABOVE_NAVEL = 0.05  # m, where the waist is


SAID = {  # each length: what it is where it is greater, and where it is less
    "ribs_breadth": ("broader at the ribs", "narrower at the ribs"),
    "waist_breadth": ("broader at the waist", "narrower at the waist"),
    "ribs_depth": ("deeper at the ribs", "flatter at the ribs"),
    "navel_depth": ("deeper at the navel", "flatter at the navel"),
    "notch_navel": ("longer from the notch to the navel", "shorter from the notch to the navel"),
}


@dataclass(frozen=True, eq=False)
class TrunkLengths:
    """Natural logarithms of K lengths, in the order of `SAID`, and their standard deviations."""

    logs: Array  # (K,)
    sigmas: Array  # (K,) standard deviations


def trunk_lengths(rig: Rig, body: Gaussian) -> TrunkLengths | None:
    """The lengths of a body from a fit's body.bin; None for a rig without the trunk's bones and landmarks."""
    ends = _ends(rig)
    if ends is None:
        return None
    logs = _logs(rig, body.mean, ends)
    slopes = [(_logs(rig, body.mean + step, ends) - logs) / STEP for step in STEP * np.eye(len(body.mean))]
    jacobian = np.stack(slopes, axis=1)
    return TrunkLengths(logs, np.sqrt(np.einsum("ki,ij,kj->k", jacobian, body.covariance, jacobian)))


def _logs(rig: Rig, body: Array, ends: Sequence[tuple[int, int]]) -> Array:
    vertices = pose(rig, _at_rest(rig, body))
    return np.log([np.linalg.norm(vertices[start] - vertices[end]) for start, end in ends])


def _at_rest(rig: Rig, body: Array) -> RigParameters:
    """The bones at rest, scaled to the body's size, with closed joints."""
    rest, count = rest_parameters(rig), 3 * len(rig.bones)
    scales = body[:count].reshape(-1, 3)
    kept = np.array([shape.kind == "body" for shape in rig.shapes], dtype=np.bool_)
    places = rest.translations.copy()
    for joint in sorted(rig.joints, key=lambda joint: joint.child):
        ends = [
            rest.rotations[bone] @ (scales[bone] * (rest.rotations[bone].T @ (joint.anchor - rest.translations[bone])))
            for bone in (joint.parent, joint.child)
        ]
        places[joint.child] = places[joint.parent] + ends[0] - ends[1]
    return RigParameters(rest.rotations, places, scales, np.where(kept, body[count:], 0.0))


@lru_cache(maxsize=8)
def _ends(rig: Rig) -> tuple[tuple[int, int], ...] | None:
    """The two vertices of each length."""
    names = (NOTCH, XIPHOID, NAVEL)
    if not rig.has_landmarks(names) or not {*TRUNK} <= {*rig.bone_names}:
        return None
    notch, xiphoid, navel = rig.landmark_points(names).positions(rig.template, rig.faces)
    trunk = np.isin(rig.main_bones, [rig.bone_names.index(name) for name in TRUNK])
    ribs, waist, belly = (
        np.flatnonzero(trunk & (np.abs(rig.template[:, 1] - height) < LAYER))
        for height in (xiphoid[1] - BELOW_XIPHOID, navel[1] + ABOVE_NAVEL, navel[1])
    )
    if not all(len(_at_midline(rig, layer)) for layer in (ribs, waist, belly)):
        return None
    return (
        _outermost(rig, ribs, 0),
        _outermost(rig, waist, 0),
        _outermost(rig, _at_midline(rig, ribs), 2),
        _outermost(rig, _at_midline(rig, belly), 2),
        (_nearest(rig, notch), _nearest(rig, navel)),
    )


def _at_midline(rig: Rig, layer: Integers) -> Integers:
    return np.asarray(layer[np.abs(rig.template[layer, 0]) < MIDDLE])


def _outermost(rig: Rig, layer: Integers, axis: int) -> tuple[int, int]:
    """The vertices farthest along an axis (0: to the left, 2: to the front) and against it."""
    along = rig.template[layer, axis]
    return int(layer[along.argmax()]), int(layer[along.argmin()])


def _nearest(rig: Rig, place: Array) -> int:
    return int(np.linalg.norm(rig.template - place, axis=1).argmin())

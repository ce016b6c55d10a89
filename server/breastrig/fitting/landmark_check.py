"""Picks that cannot be right: told before the fit by each other, after the fit by the fitted model.

Before: a similarity that trusts the majority (iteratively reweighted Umeyama) starts the fit, so one pick on the
wrong place or two exchanged sides do not turn it; when the picks as a whole only make sense with left and right
exchanged, or face the camera with the back, they are not used for the start at all.
During: the landmark term's robust kernel lets go of what stays far (presets, `landmark_kernel_scale`), and
checked_fit.py of what was followed although all else contradicts it.
After: what the fitted model is still far from is named, with "exchanged" where the partner's place would fit.
"""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.fitting.similarity import Similarity, similar_parameters, umeyama
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters

TRUST = 0.04  # m; patients' landmarks lie within about 3 cm of a similarity of the model's
DOUBTFUL = 0.02  # m from a pick to the fitted landmark; true picks of the dev scans, clicked 5 mm off, stay under it
ADULT_SCALE = (0.75, 1.3)  # of the model
MIN_LANDMARKS = 3  # fewer leave the similarity open
NEAR_PARTNER = 0.04  # m; a pick this near the other side's landmark was meant for it
EXCHANGED_GAIN = 0.6  # exchanging sides must bring the misfit below this share


@dataclass(frozen=True)
class Doubt:
    """A pick that was not followed, and why, as a sentence."""

    names: tuple[str, ...]
    reason: str


def partner(rig: Rig, name: str) -> str:
    """The landmark on the other side."""
    return next(landmark.mirror for landmark in rig.landmarks if landmark.name == name)


def trusted_similarity(model: Array, picked: Array) -> tuple[Similarity, Array]:
    """A similarity that the majority of the (L, 3) pairs agree on, and the (L,) residuals in m."""
    found = umeyama(model, picked)
    residual = np.linalg.norm(found.apply(model) - picked, axis=1)
    for scale in (4.0 * TRUST, 2.0 * TRUST, TRUST, TRUST, TRUST):
        found = umeyama(model, picked, 1.0 / (1.0 + (residual / scale) ** 2) ** 2)
        residual = np.linalg.norm(found.apply(model) - picked, axis=1)
    return found, residual


def start_from_landmarks(rig: Rig, landmarks: dict[str, Array]) -> RigParameters:
    """The rest pose on three or more landmarks (3,) m; the scale is kept within what adults have."""
    names = tuple(landmarks)
    model = rig.landmark_points(names).positions(rig.template, rig.faces)
    picked = np.array([landmarks[name] for name in names])
    found, residual = trusted_similarity(model, picked)
    scale = float(np.clip(found.scale, *ADULT_SCALE))
    share = 1.0 / (1.0 + (residual / TRUST) ** 2) ** 2
    shift = share @ (picked - scale * model @ found.rotation.T) / share.sum()
    return similar_parameters(rig, Similarity(scale, found.rotation, shift))


def sides_exchanged(rig: Rig, landmarks: dict[str, Array]) -> bool:
    """Whether the picks as a whole make sense only with left and right exchanged."""
    names = tuple(landmarks)
    if sum(partner(rig, name) != name for name in names) < 4:
        return False
    picked = np.array([landmarks[name] for name in names])
    misfit = []
    for order in (names, tuple(partner(rig, name) for name in names)):
        model = rig.landmark_points(order).positions(rig.template, rig.faces)
        misfit.append(float(np.median(trusted_similarity(model, picked)[1])))
    return misfit[1] < EXCHANGED_GAIN * misfit[0]


def doubts(
    rig: Rig, fitted: dict[str, Array], picked: dict[str, Array], let_go: Collection[str] = ()
) -> tuple[Doubt, ...]:
    """What the fitted model's landmarks ((3,) m by name) say of the picks; those that the fit let go are among them."""
    far = [name for name in picked if name in let_go or np.linalg.norm(fitted[name] - picked[name]) > DOUBTFUL]
    result, told = [], set()
    for name in far:
        other = partner(rig, name)
        pair = (name, other)
        if name in told:
            continue
        if (
            other != name
            and other in far
            and all(np.linalg.norm(fitted[a] - picked[b]) < NEAR_PARTNER for a, b in (pair, pair[::-1]))
        ):
            told |= set(pair)
            result.append(Doubt(pair, f"{name} and {other} look exchanged; they were not followed."))
            continue
        gap = 1e3 * float(np.linalg.norm(fitted[name] - picked[name]))
        result.append(Doubt((name,), f"{name} is {gap:.0f} mm from where the model puts it; it was not followed."))
    return tuple(result)

"""Landmarks that lie in a hollow of the skin: navel, notch of the breast bone, folds under the breasts.

Where a hollow deepens is seen on the scan, but bodies have many hollows; the fitted form knows which one, and not
exactly where.  Both are chances over the places around the expected one: the form's a Gaussian, the hollow's grows with
the curvature.  Their product's mean is the observation and its covariance the error.  Where a hollow stands out, it is
its place; where several may be meant, the mean of them; where the skin is flat, covered or not on the scan, nothing is
gained over the form, and nothing is observed.  (The deepest place alone, taken where it had most of the chance, was
8.7 mm off at notches and this mean 6.5 mm, on warped bodies.)
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.relief.height_field import HeightField, SmoothSkin, height_field, smooth_skin
from breastrig.relief.limits import Hollow, Relief, relief

NOT_SHOWN = 1.0  # m, error along a fold: it does not say where


@dataclass(frozen=True, eq=False)
class Expected:
    """Where the fitted form has a landmark."""

    place: Array  # (3,) m, in the scan's frame
    outwards: Array  # (3,) unit, out of the body there


@dataclass(frozen=True, eq=False)
class SeenHollow:
    """A landmark that the skin's form shows."""

    place: Array  # (3,) m, on the skin, in the scan's frame
    covariance: Array  # (3, 3) m²; next to no knowledge along a fold
    reason: str  # a few words
    all_round: bool  # known on all axes; False for a fold, which does not say where along it the landmark lies
    slack: float = 1.0  # times its error, in a fit that follows it

    @property
    def error(self) -> float:
        """m, root mean square."""
        return float(np.sqrt(np.trace(self.covariance)))


def seen_hollows(target: ScanTarget, expected: Mapping[str, Expected], axes: Array) -> dict[str, SeenHollow]:
    """Those of the `expected` landmarks whose hollow the scan shows.

    axes: (3, 3), columns are the body's left, up and front in the scan's frame.
    """
    rules, seen = relief(), {}
    for name, each in expected.items():
        hollow = rules.hollow(name)
        found = None if hollow is None else _seen(target, each, axes, hollow, rules)
        if found is not None:
            seen[name] = found
    return seen


def lies_on_smooth_skin(target: ScanTarget, hollow: Hollow, place: Expected, axes: Array) -> bool:
    """Whether the scan shows that nothing of such a hollow is at a place; False also where it shows nothing.

    Of hollows without a limit for it nothing is told.  axes: as in seen_hollows.
    """
    if hollow.smooth is None:
        return False
    found = _evidence(target, place, axes, hollow, (hollow.smooth.around, hollow.smooth.around))
    if found is None:
        return False
    field, skin, evidence = found
    near = np.hypot(field.right, field.up) < hollow.smooth.around
    return bool(skin.shown[near].all() and evidence[near].max() < hollow.smooth.below)


def _evidence(
    target: ScanTarget, expected: Expected, axes: Array, hollow: Hollow, sides: tuple[float, float]
) -> tuple[HeightField, SmoothSkin, Array] | None:
    """The skin around a place and (N, M), how much of a hollow each pixel says, as the logarithm of a chance."""
    outwards = axes[:, 2] if hollow.view == "front" else _mean_normal(target, expected, hollow.around)
    beyond = 2.0 * hollow.scale  # so that the Gaussian meets no edge
    half = (sides[0] + beyond, sides[1] + beyond)
    field = height_field(target, expected.place, outwards, axes[:, 1], half, relief().pixel)
    if field is None:
        return None
    skin = smooth_skin(field, hollow.scale)
    curvature = hollow.across * skin.across + hollow.along * skin.along
    return field, skin, hollow.weight * np.where(skin.shown, np.clip(curvature, 0.0, hollow.most), 0.0)


def _seen(target: ScanTarget, expected: Expected, axes: Array, hollow: Hollow, rules: Relief) -> SeenHollow | None:
    """One of them; None where the scan says no more than the form."""
    sides = (rules.reach * hollow.aside, rules.reach * hollow.up)
    around = _evidence(target, expected, axes, hollow, sides)
    if around is None:
        return None
    field, skin, evidence = around
    form = -0.5 * ((field.right / hollow.aside) ** 2 + (field.up / hollow.up) ** 2)
    looked_at = (np.abs(field.right) < sides[0]) & (np.abs(field.up) < sides[1])
    chance = np.where(looked_at, np.exp(evidence - evidence.max() + form), 0.0)
    mean, covariance = _moments(field, chance / chance.sum())
    if np.sqrt(covariance[1, 1]) > (1.0 - hollow.least_gain) * hollow.up:
        return None
    row = round(len(field.up) // 2 - mean[1] / field.pixel)
    column = round(field.right.size // 2 + mean[0] / field.pixel)
    if not skin.shown[row, column]:
        return None
    error = hollow.error_scale**2 * covariance + hollow.floor**2 * np.eye(2)
    if not hollow.shows_side:
        error = np.diag([NOT_SHOWN**2, error[1, 1]])
    total = np.zeros((3, 3))
    total[:2, :2], total[2, 2] = error, hollow.depth**2
    fine = smooth_skin(field, rules.fine)  # the scale that finds a hollow fills it up
    place = field.point(
        float(mean[0]), float(mean[1]), float((fine if fine.shown[row, column] else skin).height[row, column])
    )
    return SeenHollow(place, field.axes.T @ total @ field.axes, hollow.reason, hollow.shows_side)


def _moments(field: HeightField, chance: Array) -> tuple[Array, Array]:
    """((2,) m, (2, 2) m²): mean and covariance to the right and up."""
    sides = chance.sum(axis=0), chance.sum(axis=1)
    mean = np.array([sides[0] @ field.right[0], sides[1] @ field.up[:, 0]])
    right, up = field.right - mean[0], field.up - mean[1]
    both = float((chance * right * up).sum())
    return mean, np.array([[sides[0] @ right[0] ** 2, both], [both, sides[1] @ up[:, 0] ** 2]])


def _mean_normal(target: ScanTarget, expected: Expected, around: float) -> Array:
    """(3,) unit, of the skin around that faces as the form does."""
    normals = target.normals[target.vertex_tree.query_ball_point(expected.place, around)]
    total = normals[normals @ expected.outwards > 0.2].sum(axis=0)
    length = float(np.linalg.norm(total))
    return expected.outwards if length < 1e-6 else np.asarray(total / length)

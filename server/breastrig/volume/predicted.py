"""Predicts a patient's skin in a stance that was not scanned, from the scan of another one.

Two motions add up: that of the trunk and arms between standing and supine (drawings/skin_maps/lying_motion.py), and the
effect of gravity on the breasts. That is estimated on bodies that were computed in several stances, in more than one
way (breastrig_studies/gravity). To each way the heights of a breast over the sheet of skin around it, in all its
stances, are one Gaussian

x_s = m_s + F_s z, z ~ N(0, 1) for each stance s,

so that the heights seen in one stance determine z, and z the others (conditional Gaussian; Bishop, Pattern Recognition
and Machine Learning, 2006, 2.3 and 12.2). Nobody knows which way is right: what is predicted is the mean of those that
know both stances, and how far they are apart counts as what is not known (variance of a mixture). The numbers are data
beside the rig, found by its hash.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, Field, FiniteFloat
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array
from breastrig.core.errors import BadInput
from breastrig.core.stances import PRONE
from breastrig.drawings.skin_maps.lying_motion import lying_motion
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig.volume.breast_skin import MIRROR, breast_skins

FILE, SCHEMA = "gravity.json", "breastrig/gravity@2"
STANCES = ("standing", "supine", "prone")
LEAST = 1e-3  # m: no deviation is said to be smaller
TENTH = 1e-4  # m: the unit of the file's integers
TOP, FLAT = 0.95, 0.008  # quantile of heights, and m of it up to which there is no breast; twice as high it is one
STERNUM = 0.03  # m, half the width of the skin on the sternum
ARMS_FROM, ARMS_TO = 0.045, 0.12  # m from the breasts, between which the arms' motion comes in where breasts hang


class _Way(BaseModel):
    women: int
    mean: dict[str, list[int]]
    factors: dict[str, list[list[int]]]
    observation_mm: Annotated[FiniteFloat, Field(gt=0.0)]


class _File(BaseModel):
    schema_: Literal["breastrig/gravity@2"] = Field(alias="schema")
    ways: Annotated[list[_Way], Field(min_length=1)]
    band: Annotated[FiniteFloat, Field(gt=0.0)]
    posture_mm: Annotated[FiniteFloat, Field(ge=0.0)]


@dataclass(frozen=True, eq=False)
class Way:
    """One way of computing bodies: P skin vertices that the left breast moves (breast_skin.py), K factors."""

    mean: Mapping[str, Array]  # (P * 3,) m, heights by stance
    factors: Mapping[str, Array]  # (K, P * 3) m
    observation: float  # m: how far a fitted vertex may be from the same skin of these bodies
    women: int

    def moved(self, heights: Array, stance: str, goal: str) -> tuple[Array, Array]:
        """((P, 3) m from (P, 3) heights to those of the other stance, (P,) m² variance of all three axes together)."""
        seen = self.factors[stance]
        away = (heights.ravel() - self.mean[stance]) @ seen.T / self.observation**2
        covariance = np.linalg.inv(np.eye(len(seen)) + seen @ seen.T / self.observation**2)
        change = self.factors[goal] - seen
        move = self.mean[goal] - self.mean[stance] + (covariance @ away) @ change
        variance = np.einsum("kp,kl,lp->p", change, covariance, change)
        return move.reshape(-1, 3), variance.reshape(-1, 3).sum(axis=1)


@dataclass(frozen=True, eq=False)
class GravityPrior:
    """What is known of the motion of breasts between stances."""

    ways: tuple[Way, ...]  # all stances are in one of them
    band: float  # times the standard deviation that holds the true place with 90 %
    posture: float  # m: the radius of what posture leaves open, 90 %

    def between(self, stance: str, goal: str) -> tuple[Way, ...]:
        """The ways that know both stances."""
        return tuple(way for way in self.ways if {stance, goal} <= way.mean.keys())

    def moved(self, heights: Array, stance: str, goal: str) -> tuple[Array, Array]:
        """((P, 3) m from (P, 3) heights to those of the other stance, (P,) m radius that holds them with 90 %)."""
        found = [way.moved(heights, stance, goal) for way in self.between(stance, goal)]
        moves, variances = np.array([move for move, _ in found]), np.array([variance for _, variance in found])
        move = moves.mean(axis=0)
        variance = variances.mean(axis=0) + ((moves - move) ** 2).sum(axis=2).mean(axis=0)
        return move, self.band * np.sqrt(np.maximum(variance, LEAST**2))


@dataclass(frozen=True, eq=False)
class Predicted:
    """The body in the other stance, in the scan's frame: its trunk stays where it is."""

    vertices: Array  # (V, 3) m
    radii: Array  # (V,) m, of what the prediction leaves open, 90 %


@lru_cache(maxsize=4)
def gravity_prior(rig: Rig) -> GravityPrior | None:
    """The rig's gravity prior; None where none has been computed."""
    found = known_part(rig, FILE, _File)
    if found is None:
        return None
    ways = [
        Way(
            {name: TENTH * np.array(heights) for name, heights in way.mean.items()},
            {name: TENTH * np.array(factors) for name, factors in way.factors.items()},
            1e-3 * way.observation_mm,
            way.women,
        )
        for way in found.ways
    ]
    return GravityPrior(
        ways=tuple(ways),
        band=found.band,
        posture=1e-3 * found.posture_mm,
    )


def predicted(rig: Rig, vertices: Array, stance: str, goal: str) -> Predicted:
    """The (V, 3) m vertices of a body that was fitted in `stance`, in `goal`.  Raises BadInput."""
    prior = prior_between(rig, stance, goal)
    local = in_standing_frame(rig, vertices, stance)
    breasts = []
    for each in breast_skins(rig):
        mirror = MIRROR if each.side == "R" else np.ones(3)
        heights = each.heights(local) * mirror
        move, within = prior.moved(heights, stance, goal)
        breasts.append((breast_presence(heights[each.breast]) * move * mirror, within))
    return with_breasts(rig, vertices, stance, goal, breasts)


def prior_between(rig: Rig, stance: str, goal: str) -> GravityPrior:
    """The prior for this prediction; BadInput where the rig has none, or both stances are the same."""
    prior = gravity_prior(rig)
    if prior is None:
        raise BadInput(f"What gravity does to {rig.name} is not known; only the package's own model is predicted.")
    if goal == stance:
        raise BadInput(f"A scan is {goal} already; ask for another stance.")
    return prior


def breast_presence(heights: Array) -> float:
    """0 for (B, 3) m heights of a side without a breast, which does not move, to 1 for those of a breast."""
    share = (np.quantile(np.linalg.norm(heights, axis=1), TOP) - FLAT) / FLAT
    return float(np.clip(share, 0.0, 1.0))


def with_breasts(
    rig: Rig, vertices: Array, stance: str, goal: str, breasts: Sequence[tuple[Array, Array]]
) -> Predicted:
    """The (V, 3) m body in another posture, with its breasts moved: of left and right (P, 3) m in the template's frame
    at the skin that the breast moves, and (P,) m radii."""
    prior = prior_between(rig, stance, goal)
    _, turn = in_template(rig, vertices, stance)
    moves, radii = posture(rig, goal) - posture(rig, stance), np.full(len(vertices), prior.posture)
    hanging = skin_map_settings(rig).error_hanging if PRONE in (stance, goal) else 0.0
    for each, (move, within) in zip(breast_skins(rig), breasts, strict=True):
        moves[each.skin] += move
        radii[each.skin] = np.maximum(radii[each.skin], np.sqrt(prior.posture**2 + within**2 + hanging**2))
    return Predicted(vertices + moves @ turn, radii)


def in_template(rig: Rig, vertices: Array, stance: str = "standing") -> tuple[Array, Array]:
    """((V, 3) m in the template's frame by the skin around the breasts, (3, 3) rotation into it)."""
    ring = np.union1d(*(each.near for each in breast_skins(rig)))
    around = (rig.template + posture(rig, stance))[ring]
    motion = umeyama(vertices[ring], around)
    away = vertices - vertices[ring].mean(axis=0)
    return away @ motion.rotation.T + around.mean(axis=0), motion.rotation


def in_standing_frame(rig: Rig, vertices: Array, stance: str) -> Array:
    """(V, 3) m in the template's frame: the body of a stance with its trunk and arms as they are standing."""
    return in_template(rig, vertices, stance)[0] - posture(rig, stance)


@lru_cache(maxsize=8)
def lying(rig: Rig) -> tuple[Array, Array]:
    """(V, 3) m twice: displacements of lying down, the sternum unmoved, without and with the breasts' own motion.

    Without: as the skin around the breasts moves, across them.
    """
    motions = lying_motion(rig)
    if motions is None:
        return np.zeros_like(rig.template), np.zeros_like(rig.template)
    middle = rig.regions["chest"]
    middle = middle[np.abs(rig.template[middle, 0]) < STERNUM]
    supine = rig.template + motions[0]
    turn = umeyama(supine[middle], rig.template[middle]).rotation
    whole = (supine - supine[middle].mean(axis=0)) @ turn.T + rig.template[middle].mean(axis=0) - rig.template
    trunk = whole.copy()
    for each in breast_skins(rig):
        trunk[each.skin[each.breast]] = (each.sheet @ whole[each.near])[each.breast]
    return trunk, whole


def posture(rig: Rig, stance: str) -> Array:
    """(V, 3) m from a standing body: trunk and arms without the breasts; prone, the arms alone."""
    if stance == "standing":
        return np.zeros_like(rig.template)
    if stance == "supine":
        return lying(rig)[0].copy()
    breasts = rig.template[np.union1d(rig.regions["breast_L"], rig.regions["breast_R"])]
    away = cKDTree(breasts).query(rig.template)[0]
    share = np.clip((away - ARMS_FROM) / (ARMS_TO - ARMS_FROM), 0.0, 1.0)
    return np.asarray(lying(rig)[0] * (share * share * (3.0 - 2.0 * share))[:, None])

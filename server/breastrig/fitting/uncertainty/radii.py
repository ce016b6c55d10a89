"""The 90 % radius of every landmark and of every vertex of a fitted model.

A radius is the posterior's standard deviation times a factor: the posterior lacks the distance of real bodies from what
the model can show.  How far that is differs among bodies, and a fit's strain tells it (Posterior.strain): all its radii
grow with it (docs/decisions/0035).  Factors are data beside the rig, chosen for each kind of place such that it holds
nine of ten true places of known patients, each patient counting alike (conformal prediction normalised by a model's own
deviation: Lei et al., Distribution-free predictive inference for regression, 2018). Written by
breastrig_studies/radii_factors.py; docs/decisions/0025.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from pydantic import Field

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.settings_file import Positive, SettingsPart
from breastrig.core.stances import STANDING, split_side
from breastrig.drawings.line_error import across
from breastrig.fitting.posterior import LeaveOneOut, Posterior
from breastrig.rig.known import checked_part, known_numbers
from breastrig.rig.model import Rig

Factors = dict[str, Positive]  # by kind: of landmarks without their side, of regions likewise; "other" for the rest


class StanceFactors(SettingsPart):
    """Factors for bodies in one stance."""

    given: Factors = Field(default={})  # landmarks that were given
    others: Factors = Field(default={})  # those that were not, beside given ones
    alone: Factors = Field(default={})  # all landmarks of a fit without any
    proposed: Factors = Field(default={})  # the same around where they are expected (body/landmarks.py)
    seen: Factors = Field(default={})  # skin that the scan shows, with landmarks given
    hidden: Factors = Field(default={})  # skin that it does not show
    seen_alone: Factors = Field(default={})  # likewise without any landmark
    hidden_alone: Factors = Field(default={})


class Scatter(NamedTuple):
    """The picks' deviations from everything else."""

    deviation: float  # root mean square on an axis, in the units of picks as good as is said
    picks: int


NO_PICKS = Scatter(1.0, 0)
LEAST_STRAIN = 0.75  # of the usual one, that a radius counts; of a scan of a part, which strains little, it is 1
PART = 0.66  # of the model's vertices, that a scan shows: whole ones 0.74 and more, parts 0.57 and less


class WithoutPicks(SettingsPart):
    """Errors of a fit placed by the scan alone; see Start.margin for the clarity of its start."""

    clear: Positive  # margin from which the body lies as it was found
    unclear: Positive  # and up to which it lies another way, as nearly all did
    astray: Positive  # m, root mean square distance of every place, where it does

    def lost(self, margin: float) -> float:
        """m, root mean square distance for the chance that the body lies another way."""
        return self.astray * min(max((self.clear - margin) / (self.clear - self.unclear), 0.0), 1.0)


class Calibration(SettingsPart):
    """The calibration of one model."""

    expected_scatter: Positive  # before any pick is known, see radii.py
    freedom_given: Positive  # how many residuals that expectation counts as, for radii of what was given
    freedom_elsewhere: Positive  # and for all others
    without_picks: WithoutPicks
    usual_strain: Positive | None = None  # median of the fits with which factors were estimated; absent: without
    stances: dict[str, StanceFactors] = Field(default={})

    def enlarged(self, scatter: Scatter, *, given: bool) -> float:
        """The factor of radii for this scatter of the picks, of `given` landmarks or of all else; 1 without picks.

        The root of the posterior mean of a variance (an inverse chi square): few picks say little, each more says more.
        """
        expected, found = self.freedom_given if given else self.freedom_elsewhere, 2 * scatter.picks  # axes of the skin
        square = (scatter.deviation / self.expected_scatter) ** 2
        return float(((expected + found * square) / (expected + found)) ** 0.5)

    def strained(self, strain: float, *, part: bool) -> float:
        """The factor of all radii of a fit with this strain; 1 without scan, or where nobody knows what is usual."""
        if self.usual_strain is None or not np.isfinite(strain):
            return 1.0
        return max(strain / self.usual_strain, 1.0 if part else LEAST_STRAIN)

    def of_stance(self, stance: str) -> StanceFactors:
        """The factors of this stance; those that are not measured in it are of standing bodies."""
        standing, its = self.stances.get(STANDING, StanceFactors()), self.stances.get(stance, StanceFactors())
        return standing.model_copy(update={name: group for name, group in its if group})


def factor_of(factors: Factors, name: str) -> float:
    """The factor of a landmark or region by its name, else that of others, else 1."""
    return factors.get(split_side(name)[0], factors.get("other", 1.0))


@lru_cache(maxsize=8)
def calibration(rig: Rig) -> Calibration | None:
    """This rig's calibration; None when it has none."""
    known, factors = known_numbers(rig, "uncertainty.toml"), known_numbers(rig, "radii.json")
    if known is None or factors is None:
        return None
    return checked_part(rig, "uncertainty.toml", Calibration, known | {"stances": factors.get("stances", {})})


HOLDS_90 = 1.5  # radius of 90 % for a variance of one in all: 1.44 where three axes share it, 1.52 two, 1.64 one
OTHER = "other"  # of factors: what none is for
BOTH = frozenset({"nipple_L", "nipple_R"})  # seen by colour where the form has them: so the body lies as it was found
OUTLYING = 10.0  # standard deviations; more is a wrong pick and says no more of the others (docs/decisions/0025)
SEEN_DISTANCE, SEEN_COSINE = 0.015, 0.5  # m, cosine of 60 degrees: a vertex with scan this near, facing alike, is shown


@dataclass(frozen=True, eq=False)
class Radii:
    """90 % radii, m."""

    landmarks: dict[str, float]
    vertices: Array  # (V,)
    lines: float  # of nine of ten places of lines on the breast of which less is known, across the line
    joint: Array  # (3 L, 3 L) m², of the landmarks' errors together, a radius being HOLDS_90 deviations
    seen: Booleans  # (V,) vertices on skin that the scan shows
    once_picked: Array  # (V,) from deviations to radii as soon as a landmark is picked
    lost: float  # in all of them: for the chance that the body lies another way
    size: Array | float = 0.0  # (V,) m, in those of vertices: for a size that is not known


PLANNED_ON = "breast"  # beginnings of the names of regions on which lines are planned; of a rig without, all of it


def line_error(rig: Rig, vertices: Array, seen: Booleans) -> float:
    """Line error (90 %, m) of lines on the breast with the larger one.

    vertices: (V,) m, radii of the model's vertices, (V,) of which are `seen`: lines lie on skin that the scan shows.
    """
    return max(across(vertices[members]) for members in planned_on(rig, seen))


def planned_on(rig: Rig, seen: Booleans) -> list[Integers]:
    """Vertices of each breast where lines may lie: those of (V,) `seen` ones, without any all of the model."""
    breasts = [np.array(members) for name, members in rig.regions.items() if name.startswith(PLANNED_ON)]
    shown = [members[seen[members]] for members in breasts or [np.arange(len(seen))]]
    return [members for members in shown if len(members)] or [np.arange(len(seen))]


def radii(
    posterior: Posterior, margin: float | None = None, *, expected: bool = False, size_deviation: float = 0.0
) -> Radii | None:
    """The radii of a fit; None for a model without a calibration.

    `margin` is the clarity of its start, where the scan alone has placed it (Start.margin). Landmarks' radii are around
    the model's, or around the `expected` ones (body/landmarks.py). A size of that standard deviation, a share, moves
    places from the middle of the skin that the scan shows.
    """
    rig, task = posterior.task.rig, posterior.task
    known = calibration(rig)
    if known is None:
        return None
    by_colour, factors = task.given.keys() - task.picked, known.of_stance(task.stance)
    lost = 0.0 if margin is None or by_colour >= BOTH else HOLDS_90 * known.without_picks.lost(margin)
    scatter, names, seen = scatter_of(posterior), tuple(rig.landmark_names), seen_vertices(posterior)
    strained = known.strained(posterior.strain, part=shows_part(seen))
    at_given, elsewhere = (known.enlarged(scatter, given=given) for given in (True, False))
    times = landmark_factors(posterior, factors, expected=expected)
    times *= strained * np.array([at_given if name in task.given else elsewhere for name in names])
    larger = np.repeat(times / HOLDS_90, 3)
    joint = larger[:, None] * posterior.joint_landmark_covariance(names) * larger
    joint += (lost / HOLDS_90) ** 2 / 3.0 * np.eye(len(joint))  # where else each lies is not known
    at, middle = posterior.state.vertices, posterior.state.vertices[seen if seen.any() else ~seen].mean(axis=0)
    moved = size_deviation * (rig.landmark_points(names).positions(at, rig.faces) - middle).ravel()
    joint += np.outer(moved, moved)
    size = HOLDS_90 * size_deviation * np.linalg.norm(at - middle, axis=1)
    at_landmarks = HOLDS_90 * np.sqrt(np.diag(joint).reshape(-1, 3).sum(axis=1))
    scattered = strained * np.where(seen, elsewhere, max(elsewhere, 1.0))
    now, once_picked = (scattered * skin_factors(posterior, factors, seen, picked=when) for when in (None, True))
    at_vertices = np.hypot(now * np.sqrt(posterior.vertex_variances()), np.hypot(lost, size))
    landmarks = dict(zip(names, at_landmarks.tolist(), strict=True))
    lines = line_error(rig, at_vertices, seen)
    return Radii(landmarks, at_vertices, lines, joint, seen, once_picked, lost, size if size_deviation else 0.0)


def landmark_factors(posterior: Posterior, factors: StanceFactors, *, expected: bool = False) -> Array:
    """(L,) of the rig's landmarks; of those without a pick around where they are `expected`."""
    task = posterior.task
    without = factors.others if task.picked else factors.proposed if expected else factors.alone
    return np.array(
        [factor_of(factors.given if name in task.given else without, name) for name in task.rig.landmark_names]
    )


def skin_factors(posterior: Posterior, factors: StanceFactors, seen: Booleans, *, picked: bool | None = None) -> Array:
    """(V,) of the model's vertices, (V,) of which are `seen`; where regions overlap the largest counts.

    `picked`: whether a person has picked landmarks; None: as the fit has it.
    """
    rig, picked = posterior.task.rig, bool(posterior.task.picked) if picked is None else picked
    shown, hidden = (factors.seen, factors.hidden) if picked else (factors.seen_alone, factors.hidden_alone)
    found = np.zeros(len(seen))
    for name, vertices in rig.regions.items():
        here = np.where(seen[vertices], factor_of(shown, name), factor_of(hidden, name))
        found[vertices] = np.maximum(found[vertices], here)
    others = np.where(seen, factor_of(shown, OTHER), factor_of(hidden, OTHER))
    return np.where(found > 0.0, found, others)


def scatter_of(posterior: Posterior) -> Scatter:
    """The picks' scatter by leave-one-out residuals (posterior.py): some clicks are more careful than others."""
    picked = posterior.task.picked
    if posterior.picks is None or not picked:
        return NO_PICKS
    found = LeaveOneOut(posterior.of_picks_alone).deviations()
    deviations = np.minimum([each for name, each in found.items() if name in picked], OUTLYING)
    return Scatter(float(np.sqrt(np.mean(deviations**2) / 2.0)), len(deviations))  # the skin has two axes


def shows_part(seen: Booleans) -> bool:
    """Whether a scan that shows (V,) `seen` vertices is one of a part of the body."""
    return float(seen.mean()) < PART


def seen_vertices(posterior: Posterior) -> Booleans:
    """(V,) which of the model's vertices lie on skin that the scan shows."""
    target, vertices = posterior.task.target, posterior.state.vertices
    distance, nearest = target.vertex_tree.query(vertices, distance_upper_bound=SEEN_DISTANCE)
    near = np.flatnonzero(np.isfinite(distance))
    facing = np.einsum("vi,vi->v", posterior.state.normals[near], target.normals[np.asarray(nearest)[near]])
    seen = np.zeros(len(vertices), dtype=np.bool_)
    seen[near[facing > SEEN_COSINE]] = True
    return seen

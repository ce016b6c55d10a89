"""The 90 % radius of every landmark and of every vertex of a fitted model."""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.core.stances import split_side
from breastrig.fitting.body.hanging import hanging_shifts, hangs_by
from breastrig.fitting.picks.leave_one_out import LeaveOneOut
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.uncertainty.calibration import Calibration, Misfit, calibration
from breastrig.rig.model import Rig

HOLDS_90 = 1.5  # radius of 90 % for a variance of one in all: 1.44 where three axes share it, 1.52 two, 1.64 one
BOTH = frozenset({"nipple_L", "nipple_R"})  # seen by colour where the form has them: so the body lies as it was found
FEW = 4  # fewer picks show no scatter
OUTLYING = 6.0  # standard deviations; more is a wrong pick and says nothing of the others
MOVED = 0.5  # of the way to where a landmark is expected, that its radius around the model's grows
SEEN_DISTANCE, SEEN_COSINE = 0.015, 0.5  # m, cosine of 60 degrees: a vertex with scan this near, facing alike, is shown


@dataclass(frozen=True, eq=False)
class Radii:
    """m; each holds the true place with 90 %."""

    landmarks: dict[str, float]
    vertices: Array  # (V,)
    lines: float  # of nine of ten places of lines on the breast of which less is known


PLANNED_ON = "breast"  # beginnings of the names of regions on which lines are planned; of a rig without, all of it


def line_error(rig: Rig, vertices: Array, seen: Booleans) -> float:
    """m: the radius that holds nine of ten places of lines on the breast of which less is known.

    vertices: (V,) m, radii of the model's vertices, (V,) of which are `seen`: lines lie on skin that the scan shows.
    """
    breasts = [np.array(members) for name, members in rig.regions.items() if name.startswith(PLANNED_ON)]
    shown = [members[seen[members]] for members in breasts or [np.arange(len(vertices))]]
    squares = [float(np.mean(vertices[members] ** 2)) for members in shown if len(members)]
    return float(np.sqrt(max(squares, default=np.mean(vertices**2))))


def radii(posterior: Posterior, margin: float | None = None, *, expected: bool = False) -> Radii | None:
    """Of a fit; None for a model of which nobody knows how far real bodies are from it.

    `margin` is how clear its start was, where the scan alone has placed it (Start.margin).  Landmarks' radii are around
    the model's, or around where they are `expected` (body/hanging.py).
    """
    rig, task = posterior.task.rig, posterior.task
    known = calibration(rig)
    if known is None:
        return None
    names = tuple(rig.landmark_names)
    lost = 0.0 if margin is None or task.from_colour >= BOTH else known.without_picks.lost(margin)
    if task.landmarks and task.from_colour.issuperset(task.landmarks):  # by colour alone: the form places all others
        stretch = known.without_picks.stretch
        misfits = [
            known.landmark(name).shown if name in task.from_colour else known.without_picks.landmark(name)
            for name in names
        ]
    elif task.landmarks:
        stretch, misfits = known.stretch, [_of(known.landmark(name), name in task.landmarks) for name in names]
    else:
        stretch, misfits = known.without_picks.stretch, [known.without_picks.landmark(name) for name in names]
    spread = stretch**2 * posterior.landmark_variances(names) + np.array(misfits) ** 2
    scatter, seen = _scatter(posterior, known), seen_vertices(posterior)
    at_landmarks = HOLDS_90 * scatter * np.sqrt(spread + lost**2)
    for k, name in enumerate(names):  # a relief observation is all that is known of its landmark
        observation = posterior.relief.get(name)
        if (
            observation is not None and observation.all_round and (expected or observation.slack == 1.0)
        ):  # else the model is beside it
            at_landmarks[k] = HOLDS_90 * np.hypot(observation.error, lost)
    at_landmarks = np.hypot(at_landmarks, [_of_hanging(posterior, known, name) for name in names])
    if not expected:
        at_landmarks += MOVED * np.linalg.norm(hanging_shifts(posterior.state, task, names), axis=1)
    at_vertices = HOLDS_90 * np.where(seen, scatter, max(scatter, known.least_scatter_hidden))
    at_vertices *= np.sqrt(
        stretch**2 * posterior.vertex_variances() + lost**2 + vertex_misfit(posterior, known, seen) ** 2
    )
    at_vertices = np.hypot(at_vertices, _of_hanging_skin(posterior, known, seen))
    landmarks = dict(zip(names, at_landmarks.tolist(), strict=True))
    return Radii(landmarks, at_vertices, line_error(rig, at_vertices, seen))


def _of_hanging(posterior: Posterior, known: Calibration, name: str) -> float:
    """m, what a hanging breast adds to a landmark's radius."""
    task, kind = posterior.task, known.hanging.get(split_side(name)[0])
    if kind is None:
        return 0.0
    misfit = kind.shown if name in task.landmarks else kind.hidden if task.landmarks else kind.without_picks
    return HOLDS_90 * misfit * hangs_by(posterior.state, task.recipe, name)


def _of_hanging_skin(posterior: Posterior, known: Calibration, seen: Booleans) -> Array:
    """(V,) m, what hanging breasts add to the radii of skin on them and around.

    Without picks only where one was seen to hang: the weight alone does not tell (body/hanging.py).
    """
    task = posterior.task
    added = np.zeros(len(seen))
    if not (task.landmarks or task.hanging):
        return added
    for name, vertices in task.rig.regions.items():
        kind = known.hanging_regions.get(split_side(name)[0])
        if kind is not None:
            misfit = np.where(seen[vertices], kind.shown, kind.hidden) if task.landmarks else kind.without_picks
            here = HOLDS_90 * misfit * hangs_by(posterior.state, task.recipe, name)
            added[vertices] = np.maximum(added[vertices], here)
    return added


def _scatter(posterior: Posterior, known: Calibration) -> float:
    """By how much the picks' own scatter enlarges the radii: clicks are more careful here than there, and it shows.

    The square of the picks' root mean square deviation (leave_one_out.py), in units of what is usual.
    """
    if posterior.picks is None or len(posterior.task.landmarks) < FEW or posterior.task.from_colour:
        return 1.0
    deviations = np.array(list(LeaveOneOut(posterior).deviations().values()))
    scatter = np.sqrt(np.mean(np.minimum(deviations, OUTLYING) ** 2) / 3.0)
    return float(np.clip((scatter / known.usual_scatter) ** 2, known.least_scatter, known.most_scatter))


def seen_vertices(posterior: Posterior) -> Booleans:
    """(V,) which of the model's vertices lie on skin that the scan shows."""
    target, vertices = posterior.task.target, posterior.state.vertices
    distance, nearest = target.vertex_tree.query(vertices, distance_upper_bound=SEEN_DISTANCE)
    near = np.flatnonzero(np.isfinite(distance))
    facing = np.einsum("vi,vi->v", posterior.state.normals[near], target.normals[np.asarray(nearest)[near]])
    seen = np.zeros(len(vertices), dtype=np.bool_)
    seen[near[facing > SEEN_COSINE]] = True
    return seen


def vertex_misfit(posterior: Posterior, known: Calibration, seen: Booleans) -> Array:
    """(V,) m"""
    rig = posterior.task.rig
    result = np.where(seen, known.region("other").shown, known.region("other").hidden)
    for name, vertices in rig.regions.items():
        misfit = known.region(name)
        result[vertices] = np.where(seen[vertices], misfit.shown, misfit.hidden)
    return np.asarray(result)


def _of(misfit: Misfit, shown: bool) -> float:
    return misfit.shown if shown else misfit.hidden

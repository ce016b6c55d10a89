"""Whether two scans of one patient are better fitted together: points carried from one stance to the other.

truth.ply of one patient has the same vertices in every stance, so the true place of a carried point is known to
the vertex.  Measured are the vertices that both scans saw (a scan point within 15 mm whose normal is within 60
degrees) on chest and breasts: within 130 mm of the line between the nipples.  A point starts on scan A and ends
on scan B.  Ways:

* `separate`, `together`, `alike`: from scan A to the nearest point of the fitted model, the same point of the model
  on B, along the normal to scan B; the two fits made apart, with one body, or with bodies held alike;
* `smooth_separate`, `smooth_together`, `smooth_alike`: the program's transfer (drawings/skin_maps/skin_map.py) between
  these fits;
* `rigid`, `spline`: a rigid motion and a thin-plate spline through the landmarks, then to the nearest skin of B.

Every way is measured with the true landmarks, and again (`clicks`) with picks 5 mm off along the skin.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby, product

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.spatial.transform import Rotation

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import FitFailed
from breastrig.correspondence.match import match
from breastrig.drawings.project_drawing import ON_SKIN
from breastrig.drawings.skin_maps.skin_map import FittedScan, carried
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.task import FitTask
from breastrig.fitting.two_stances import ALIKE, ONE_BODY, Coupling, fit_pair_iterates
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose
from breastrig_studies.cohort import Case
from breastrig_studies.studies.case import SEEN_COSINE, SEEN_DISTANCE, Scene, read_scene

CHEST = 0.13  # m from the line between the nipples
CLICK = 0.005  # m
SEED = 7
MOST_POINTS = 1000  # a pair; more change the mean by less than 0.05 mm

Picks = dict[str, Array]


@dataclass(frozen=True, eq=False)
class _Question:
    """Where the points stand on scan A, and where they truly are on B."""

    a: Scene
    b: Scene
    points: Array  # (M, 3) m, on scan A
    true: Array  # (M, 3) m, in B's frame

    def summary(self, found: Array) -> dict[str, float]:
        gaps = 1e3 * np.linalg.norm(found - self.true, axis=1)
        return {"mean": round(float(gaps.mean()), 3), "p95": round(float(np.percentile(gaps, 95)), 3)}


def seen(scene: Scene) -> Booleans:
    """(V,) vertices of the truth that the scan shows."""
    assert scene.truth is not None
    distance, nearest = scene.target.vertex_tree.query(scene.truth.vertices)
    normals = vertex_normals(scene.truth.vertices, scene.truth.triangles)
    facing = np.einsum("vi,vi->v", normals, scene.target.normals[nearest])
    return np.asarray((distance < SEEN_DISTANCE) & (facing > SEEN_COSINE))


def on_the_chest(scene: Scene) -> Booleans:
    """(V,) vertices of the truth within CHEST of the line between the nipples."""
    assert scene.truth is not None
    left, right = scene.landmarks["nipple_L"], scene.landmarks["nipple_R"]
    across, vertices = right - left, scene.truth.vertices
    share = np.clip((vertices - left) @ across / (across @ across), 0.0, 1.0)
    return np.asarray(np.linalg.norm(vertices - left - share[:, None] * across, axis=1) < CHEST)


def _question(a: Scene, b: Scene) -> _Question:
    assert a.truth is not None
    assert b.truth is not None
    chosen = np.flatnonzero(seen(a) & seen(b) & on_the_chest(a))
    chosen = chosen[:: -(-len(chosen) // MOST_POINTS) or 1]
    points = a.target.search.query(a.truth.vertices[chosen]).points
    return _Question(a, b, points, b.truth.vertices[chosen])


def to_skin(scene: Scene, points: Array) -> Array:
    return np.asarray(scene.target.search.query(points).points)


def by_models(rig: Rig, a: FittedScan, b: FittedScan, points: Array) -> Array:
    """(M, 3) m: points of scan A at the same places of the fitted model on scan B."""
    nearest = ClosestPointSearch(a.vertices, rig.faces).query(points)
    places = nearest.on_mesh
    result = places.positions(b.vertices, rig.faces)
    normals = places.directions(vertex_normals(b.vertices, rig.faces), rig.faces)
    missing: Integers = np.arange(len(result))
    for rules in ON_SKIN:
        found = match(b.target, result[missing], normals[missing], rules)
        result[missing[found.vertices]] = found.points
        missing = np.delete(missing, found.vertices)
    return result


def _by_landmarks(asked: _Question, picks: tuple[Picks, Picks]) -> dict[str, Array]:
    names = [name for name in picks[0] if name in picks[1]]
    source, goal = (np.array([side[name] for name in names]) for side in picks)
    turn = Rotation.align_vectors(goal - goal.mean(axis=0), source - source.mean(axis=0))[0]
    moved = turn.apply(asked.points - source.mean(axis=0)) + goal.mean(axis=0)
    bent = RBFInterpolator(source, goal, kernel="thin_plate_spline")(asked.points)
    return {"rigid": to_skin(asked.b, moved), "spline": to_skin(asked.b, bent)}


def _fitted_apart(rig: Rig, recipe: Recipe, scene: Scene, picks: Picks) -> FittedScan:
    return FittedScan(scene.target, scene.fitted(rig, recipe, picks).vertices, picks, scene.case.stance)


def _fitted_together(
    rig: Rig, recipe: Recipe, scenes: tuple[Scene, Scene], picks: tuple[Picks, Picks], coupling: Coupling
) -> tuple[FittedScan, FittedScan]:
    tasks = [
        FitTask(rig, scene.target, scene.start(rig, given), recipe, {}, scene.case.stance).with_picks(given)
        for scene, given in zip(scenes, picks, strict=True)
    ]
    last = list(fit_pair_iterates(tasks[0], tasks[1], coupling))[-1]
    fits = [
        FittedScan(scene.target, pose(rig, side.parameters), given, scene.case.stance)
        for scene, side, given in zip(scenes, (last.first, last.second), picks, strict=True)
    ]
    if not all(np.isfinite(fit.vertices).all() for fit in fits):
        raise FitFailed("The fit of both stances broke down: a number is not finite.")
    return fits[0], fits[1]


def _clicked(scene: Scene) -> Picks:
    rng = np.random.default_rng(SEED)
    return {name: scene.along_the_skin(place, CLICK, rng) for name, place in scene.landmarks.items()}


def _errors(
    rig: Rig, recipe: Recipe, asked: tuple[_Question, _Question], picks: tuple[Picks, Picks]
) -> list[dict[str, object]]:
    """The errors of every way there and back, for one set of picks."""
    scenes = asked[0].a, asked[0].b
    apart = _fitted_apart(rig, recipe, scenes[0], picks[0]), _fitted_apart(rig, recipe, scenes[1], picks[1])
    both = _fitted_together(rig, recipe, scenes, picks, ONE_BODY)
    alike = _fitted_together(rig, recipe, scenes, picks, ALIKE)
    rows: list[dict[str, object]] = []
    for question, back in zip(asked, (False, True), strict=True):
        row: dict[str, object] = {}
        for name, fits in (("separate", apart), ("together", both), ("alike", alike)):
            a, b = (fits[1], fits[0]) if back else fits
            row[f"{name}_mm"] = question.summary(by_models(rig, a, b, question.points))
            row[f"smooth_{name}_mm"] = question.summary(carried(rig, a, b, question.points))
        for name, found in _by_landmarks(question, (picks[1], picks[0]) if back else picks).items():
            row[f"{name}_mm"] = question.summary(found)["mean"]
        rows.append(row)
    return rows


def gain(cases: Sequence[Case], rig: Rig, recipe: Recipe, progress: Callable[[str], None]) -> list[dict[str, object]]:
    """One row for each ordered pair of a standing and a supine scan of one patient; none without truth.ply.

    Errors of the carried points in mm (see above); `points` says how many, `clicks` repeats the errors with picks
    5 mm off.
    """
    rows = []
    known = sorted((case for case in cases if (case.folder / "truth.ply").is_file()), key=lambda case: case.patient)
    for patient, group in groupby(known, key=lambda case: case.patient):
        own = list(group)
        standing, supine = ([case for case in own if case.stance == stance] for stance in ("standing", "supine"))
        for pair in product(standing, supine):
            progress(f"{patient}: {pair[0].name} and {pair[1].name}")
            scenes = read_scene(pair[0]), read_scene(pair[1])
            asked = _question(*scenes), _question(*scenes[::-1])
            exact = _errors(rig, recipe, asked, (scenes[0].landmarks, scenes[1].landmarks))
            clicks = _errors(rig, recipe, asked, (_clicked(scenes[0]), _clicked(scenes[1])))
            for question, row, again in zip(asked, exact, clicks, strict=True):
                about = {
                    "family": question.a.case.family,
                    "patient": patient,
                    "from": question.a.case.name,
                    "to": question.b.case.name,
                    "points": len(question.points),
                }
                rows.append(about | row | {"clicks": again})
    return rows

"""Measures the error of skin predicted in a stance that was not scanned.

The standing scan is fitted with its landmarks and predicted; the frame of the other scan is not known, so the
prediction is aligned to it rigidly by its landmarks. Two baselines are aligned in the same way: the standing body
(`rigid`), and, supine, the standing body moved as skin does on the mean of other patients (`mean_motion`).

Places: the `nipples`, the `breasts`' true skin, and the `lines` of the study of transfers.
"""

from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.fitting.recipe import Recipe
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig.volume.predicted import gravity_prior, in_template, lying, predicted
from breastrig_studies.cohort import Case
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.transfer import fitted, places

START = "standing"
ON_SKIN = 0.015  # m: true skin that is farther from the model is not predicted


def prediction_study(cases: tuple[Case, ...], rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """{"rows": one for each other stance of the patient and kind of place}."""
    start = next(case for case in cases if case.stance == START)
    scene, others = read_scene(start), [read_scene(case) for case in cases if case.stance != START]
    if gravity_prior(rig) is None or scene.truth is None:
        return {"rows": []}
    fit = fitted(rig, recipe, scene, scene.landmarks)
    rows = [row for goal in others if goal.truth is not None for row in _rows(rig, scene, fit, goal)]
    return {"rows": rows}


def _rows(rig: Rig, scene: Scene, fit: FittedScan, goal: Scene) -> list[dict[str, Any]]:
    found = predicted(rig, fit.vertices, START, goal.case.stance)
    radii = np.hypot(found.radii, 0.0 if fit.radii is None else fit.radii)
    search = fit.search(rig)

    def at(points: Array) -> SurfacePoints:
        nearest = search.query(points)
        return SurfacePoints(nearest.faces, nearest.barycentric)

    moves = {"predicted": found.vertices - fit.vertices, "rigid": np.zeros_like(fit.vertices)}
    if goal.case.stance == "supine":
        moves["mean_motion"] = lying(rig)[1] @ in_template(rig, fit.vertices)[1]

    def moved(way: str, points: Array) -> Array:
        return points + at(points).positions(moves[way], rig.faces)

    names = [name for name in scene.landmarks if name in goal.landmarks]
    marks, there = (np.array([each.landmarks[name] for name in names]) for each in (scene, goal))
    asked = {"lines": _lines(rig, scene, goal, fit)} if goal.case.stance == "supine" else {}
    nipples = [k for k, name in enumerate(names) if name.startswith("nipple")]
    asked |= {"nipples": (marks[nipples], there[nipples]), "breasts": _breasts(rig, scene, goal, fit)}
    rows = []
    for kind, (points, true) in asked.items():
        if not len(points):
            continue
        gaps = {way: _gaps(moved(way, marks), there, moved(way, points), true) for way in moves}
        within = at(points).positions(np.repeat(radii[:, None], 3, axis=1), rig.faces)[:, 0]
        rows.append(
            {"to": goal.case.name, "places": kind, "held": round(float((gaps["predicted"] <= within).mean()), 3)}
            | {
                way: {
                    "mean_mm": round(1e3 * float(gap.mean()), 2),
                    "p95_mm": round(1e3 * float(np.quantile(gap, 0.95)), 2),
                }
                for way, gap in gaps.items()
            }
        )
    return rows


def _gaps(marks: Array, there: Array, points: Array, true: Array) -> Array:
    """(M,) m from (M, 3) points, laid by their landmarks on the other scan's, to their true places."""
    turn = umeyama(marks, there).rotation
    return np.asarray(np.linalg.norm((points - marks.mean(axis=0)) @ turn.T + there.mean(axis=0) - true, axis=1))


def _lines(rig: Rig, scene: Scene, goal: Scene, fit: FittedScan) -> tuple[Array, Array]:
    found = places(rig, (scene, goal), fit)
    return found.points, found.true


def _breasts(rig: Rig, scene: Scene, goal: Scene, fit: FittedScan) -> tuple[Array, Array]:
    """True skin nearest to the model's breasts, and the same skin in the other stance."""
    assert scene.truth is not None
    assert goal.truth is not None
    nearest = fit.search(rig).query(scene.truth.vertices)
    breasts = np.union1d(rig.regions["breast_L"], rig.regions["breast_R"])
    kept = np.isin(rig.faces[nearest.faces], breasts).all(axis=1) & (nearest.distances < ON_SKIN)
    return scene.truth.vertices[kept], goal.truth.vertices[kept]

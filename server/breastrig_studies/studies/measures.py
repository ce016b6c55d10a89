"""Are the report's measures right, and do their bands hold the true ones?

The truth of a measure is the same measure of the reference fit (reference_fit.py), whose skin lies on the whole true
surface, between the true landmarks: lengths between landmarks then need nothing of the model but its skin; base width
and volume need its outline of the breast as well, so they are only as true as that outline is carried rightly.
"""

from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.refine import refined, skin_behind
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.task import FitTask, ended
from breastrig.fitting.uncertainty.radii import Radii, radii
from breastrig.report.measures import measures
from breastrig.report.stance import Stance
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose
from breastrig_studies.studies.case import Scene
from breastrig_studies.studies.landmarks import CLICK_ERROR
from breastrig_studies.studies.reference_fit import reference_fit

SHOWN = 0.01  # m; a landmark farther from the scan cannot be picked
SEED = 5
DIFFERENCE = ", left - right"  # after a row's kind


def measures_study(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """{"exact" | "clicked" | "none": rows of [measure, kind, unit, true, found, low, high]}; {} without a truth."""
    reference = reference_fit(scene, rig, recipe)
    if reference is None or scene.truth is None:
        return {}
    whole = ScanTarget(scene.truth.vertices, np.asarray(scene.truth.triangles))
    true = _numbers(_stance(scene, rig, whole, reference.vertices, dict(scene.landmarks), None))
    rng = np.random.default_rng(SEED)
    gaps = np.atleast_1d(scene.target.vertex_tree.query(np.array(list(scene.landmarks.values())))[0])
    shown = {n: place for (n, place), gap in zip(scene.landmarks.items(), gaps, strict=True) if gap < SHOWN}
    clicked = {name: scene.along_the_skin(place, CLICK_ERROR, rng) for name, place in shown.items()}
    answer = {}
    for kind, picks in {"exact": shown, "clicked": clicked, "none": {}}.items():
        task = FitTask(rig, scene.target, scene.start(rig, picks), recipe, {}, scene.case.stance).with_picks(picks)
        *_, last = checked_iterates(task)
        known = radii(Posterior(ended(task, last), last.parameters))
        fitted = pose(rig, last.parameters)
        behind = skin_behind(rig, scene.case.stance, scene.target, fitted)
        skin = refined(scene.target, fitted, rig.faces, behind).vertices
        found = _numbers(_stance(scene, rig, scene.target, skin, picks, known))
        answer[kind] = [[*key[:3], true[key][0], *numbers] for key, numbers in found.items() if key in true]
    return answer


def _stance(
    scene: Scene, rig: Rig, skin: ScanTarget, vertices: Array, picks: dict[str, Array], known: Radii | None
) -> Stance:
    return Stance(
        rig,
        vertices,
        skin.vertices,
        skin.faces,
        scene.case.stance,
        picks,
        landmark_radii={} if known is None else known.landmarks,
        joint=None if known is None else (tuple(rig.landmark_names), known.joint),
        radii=None if known is None else known.vertices,
    )


def _numbers(stance: Stance) -> dict[tuple[str, str, str, str], tuple[float, float | None, float | None]]:
    """Value, low and high by measure, kind, unit and side; differences of both sides are of a kind of their own."""
    return {
        (row.measure, row.kind + more, row.unit, side): (value.value, value.low, value.high)
        for row in measures(stance)
        for more, side, value in (
            ("", "left", row.left),
            ("", "right", row.right),
            ("", "", row.value),
            (DIFFERENCE, "", row.difference),
        )
        if value is not None
    }

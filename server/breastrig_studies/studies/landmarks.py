"""The effect of landmarks on a fit, right and wrong ones.

Half given, the other half measured, both ways round; none given, the scan as it lies; every pick 5 mm off; one pick 50
mm off; two sides exchanged. "Named" is what a user reads: an issue of the program with that name in it.
"""

from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.distances import summary_mm
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.starts.orientation import partner, sides_exchanged
from breastrig.rig.model import Rig
from breastrig_studies.studies.case import Scene

CLICK_ERROR = 0.005  # m, along the skin
CLICKERS = 4  # independent clickings of all landmarks
WRONG_PLACE = 0.05  # m, along the skin
FIRST_HALF = (  # both sides and the middle in each half
    "suprasternal_notch",
    "xiphoid",
    "midclavicle_R",
    "acromion_L",
    "nipple_R",
    "inframammary_fold_L",
)


def halves(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """Landmarks that the fit was not given, mm."""
    errors: dict[str, float] = {}
    for given in (FIRST_HALF, tuple(name for name in scene.landmarks if name not in FIRST_HALF)):
        others = tuple(name for name in scene.landmarks if name not in given)
        if not others:
            continue
        fit = scene.fitted(rig, recipe, {name: scene.landmarks[name] for name in scene.landmarks if name in given})
        errors |= dict(zip(others, scene.landmark_errors(rig, fit.vertices, others).tolist(), strict=True))
    each = {name: round(1e3 * errors[name], 3) for name in scene.landmarks if name in errors}
    return {"landmarks_mm": summary_mm(np.array(list(errors.values())))["mean"], "each": each}


def no_landmarks(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """A fit from the scan alone, as it lies, stance found by the program."""
    start = scene.start(rig, {})
    fit = scene.fitted(rig, recipe, {}, start=start, stance=scene.found_stance(rig, recipe, start))
    return scene.numbers(rig, fit.vertices)


def clicks(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """True picks once, then all picks 5 mm off, several times."""
    rng = np.random.default_rng(5)
    trials: list[dict[str, Any]] = []
    for _ in range(1 + CLICKERS):
        exact = not trials
        picked = scene.landmarks
        if not exact:
            picked = {name: scene.along_the_skin(at, CLICK_ERROR, rng) for name, at in scene.landmarks.items()}
        fit = scene.fitted(rig, recipe, picked)
        named = sorted({name for doubt in fit.doubts for name in doubt.names})
        trials.append(scene.numbers(rig, fit.vertices) | {"named": named})
    mean = {key: float(np.mean([trial[key] for trial in trials[1:]])) for key in ("surface_mm", "landmarks_mm")}
    known = [trial["truth_mm"] for trial in trials[1:] if trial["truth_mm"] is not None]
    mean_truth = float(np.mean(known)) if known else None
    return {"exact": trials[0], "clicked": mean | {"truth_mm": mean_truth}, "trials": trials[1:]}


def _judged(scene: Scene, rig: Rig, recipe: Recipe, picked: dict[str, Array], wrong: tuple[str, ...]) -> dict[str, Any]:
    """A fit to partly wrong picks: who was named, who without reason, how far the model is from the true places."""
    exchanged = sides_exchanged(rig, picked, scene.target, recipe.outliers)
    fit = scene.fitted(rig, recipe, {} if exchanged else picked)
    named = {name for doubt in fit.doubts for name in doubt.names}
    if exchanged:
        named = {name for name in picked if partner(rig, name) != name}  # "left and right look exchanged"
    return scene.numbers(rig, fit.vertices) | {
        "wrong": list(wrong),
        "named": all(name in named for name in wrong),
        "false_alarms": sorted(named - set(wrong)),
        "wrong_landmarks_mm": summary_mm(scene.landmark_errors(rig, fit.vertices, wrong))["mean"],
    }


def one_wrong(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """Each landmark in turn picked 50 mm away, the others true."""
    rng = np.random.default_rng(50)
    trials = []
    for name, place in scene.landmarks.items():
        moved = scene.along_the_skin(place, WRONG_PLACE, rng)
        trials.append(_judged(scene, rig, recipe, scene.landmarks | {name: moved}, (name,)))
    return {"trials": trials}


def exchanged_sides(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """Each pair exchanged in turn, then all pairs at once."""
    pairs = [
        (name, partner(rig, name))
        for name in scene.landmarks
        if name < partner(rig, name) and partner(rig, name) in scene.landmarks
    ]
    trials = []
    for chosen in [*([pair] for pair in pairs), pairs]:
        picked = dict(scene.landmarks)
        for a, b in chosen:
            picked[a], picked[b] = scene.landmarks[b], scene.landmarks[a]
        if chosen:
            trials.append(_judged(scene, rig, recipe, picked, tuple(name for pair in chosen for name in pair)))
    return {"trials": trials}

"""Prone scans: with the landmarks that an MRI shows, with every second of them, with none, and turned head down.

What the model alone is from the skin, how far nipples and all landmarks are off, what is said of the fit, and whether
the stance is found.
"""

from typing import Any

import numpy as np

from breastrig.fitting.recipe import Recipe
from breastrig.rig.model import Rig
from breastrig_studies.studies.case import Scene
from breastrig_studies.studies.trust.verdicts import SHOWN, head_down, judged

NIPPLES = ("nipple_L", "nipple_R")


def prone(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """{"stance": found, "fits": {kind: {"level", "error_mm", "surface_mm", "nipples_mm", "reasons"}}}."""
    gaps = np.atleast_1d(scene.target.vertex_tree.query(np.array(list(scene.landmarks.values())))[0])
    shown = {n: place for (n, place), gap in zip(scene.landmarks.items(), gaps, strict=True) if gap < SHOWN}
    found = scene.place(rig)
    picks = {"given": shown, "half": dict(sorted(shown.items())[::2]), "none": {}}
    fits = {
        kind: judged(scene, rig, recipe, scene.start(rig, given), given, None if given else found.margin, {})
        for kind, given in picks.items()
    }
    fits["head_down"] = judged(scene, rig, recipe, head_down(rig, scene, found.similarity), {}, None, {})
    answers = {}
    for kind, (answer, places) in fits.items():
        known = [name for name in NIPPLES if name in scene.landmarks]
        off = [float(np.linalg.norm(places[name] - scene.landmarks[name])) for name in known]
        answers[kind] = answer | {"nipples_mm": round(1e3 * float(np.mean(off)), 2) if off else None}
    return {"stance": scene.found_stance(rig, recipe, found.parameters), "fits": answers}

"""How near does the fit come?  The paper's Table 1 for one preset, with the true surface and the free-form layer."""

import statistics
from typing import Any

import numpy as np

from breastrig.fitting.body.trunk_depth import skin_behind
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.refine import refined
from breastrig.geometry.normals import turned_triangles
from breastrig.report.distances import landmark_summary_mm, summary_mm, surface_distances, surface_summary_mm
from breastrig.rig.model import Rig
from breastrig_studies.studies.case import Fitted, Scene

REPEATS = 3  # fits whose median time counts ...
ENOUGH_SECONDS = 1.0  # ... unless one takes this long: then chance matters less


def accuracy(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """All numbers of Table 1 for the fit with all landmarks."""
    start = scene.start(rig, scene.landmarks)
    times: list[float] = []
    while len(times) < REPEATS and sum(times) < ENOUGH_SECONDS:
        fit: Fitted = scene.fitted(rig, recipe, scene.landmarks, start)
        times.append(fit.seconds)
    distances = surface_distances(scene.target, fit.vertices, rig.faces)
    behind = skin_behind(rig, scene.case.stance, scene.target, fit.vertices)
    fine = refined(scene.target, fit.vertices, rig.faces, behind).vertices
    names = tuple(scene.landmarks)
    places = rig.landmark_points(names).positions(fit.vertices, rig.faces)
    moved = np.linalg.norm(rig.blendshapes, axis=2)  # (S, V) m at weight 1
    return {
        "time_s": round(statistics.median(times), 4),
        "iterations": fit.iterations,
        "surface_mm": surface_summary_mm(distances.model),
        "scan_to_model_mm": summary_mm(distances.scan),
        "truth_mm": summary_mm(scene.truth_errors(fit.vertices, rig.faces)),
        "turned_triangles": int(turned_triangles(fit.vertices, rig.faces).sum()),
        "landmark_mm": landmark_summary_mm(dict(zip(names, places, strict=True)), scene.landmarks),
        "refined": {
            "surface_mm": surface_summary_mm(surface_distances(scene.target, fine, rig.faces).model),
            "truth_mm": summary_mm(scene.truth_errors(fine, rig.faces)),
            "turned_triangles": int(turned_triangles(fine, rig.faces).sum()),
        },
        "shape_effect_mm": {  # how far each shape moved the skin: |weight| times its root mean square displacement
            name: round(float(1e3 * abs(weight) * np.sqrt((moved[k] ** 2).mean())), 5)
            for k, (name, weight) in enumerate(zip(rig.shape_names, fit.parameters.weights, strict=True))
        },
    }

"""Is a drawing that was transferred to another patient at the same place of the breast?

Between two patients no point has a true partner, so the place is judged by what both have: a shape's distance to
the true nipple and to the true fold, in parts of the distance from nipple to xiphoid.  A shape that stands one and a
half such lengths from the nipple shall do so in both patients.
"""

from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.drawings.project_drawing import on_scan
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.drawings.transfer import transferred
from breastrig.fitting.recipe import Recipe
from breastrig.geometry.polyline import Polyline
from breastrig.rig.model import Rig
from breastrig_studies.cohort import Case
from breastrig_studies.studies.case import Scene, read_scene

SHAPES = ("breast", "inframammary_fold", "meridian_upper", "meridian_lower")  # each with its side
ANCHORS = ("nipple", "inframammary_fold")


def other_patient(cases: tuple[Case, ...], rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """{"rows": one for each shape and landmark}: the relative place in the first and in the second patient."""
    scenes = [read_scene(case) for case in cases]
    fits = []
    for scene in scenes:
        vertices = scene.fitted(rig, recipe, scene.landmarks).vertices
        fits.append(FittedScan(scene.target, vertices, scene.landmarks, scene.case.stance))
    shapes = [
        line
        for drawing in rig.drawings
        for line in on_scan(rig, fits[0].vertices, drawing, fits[0].target)
        if line.name[:-2] in SHAPES
    ]
    carried = transferred(rig, fits[0], fits[1], shapes, other_patient=True) if shapes else ()
    rows = []
    for shape, there in zip(shapes, carried, strict=True):
        for anchor in ANCHORS:
            places = [_relative(scene, line, anchor) for scene, line in zip(scenes, (shape, there.line), strict=True)]
            rows.append({"shape": shape.name, "landmark": anchor, "first": places[0], "second": places[1]})
    return {"rows": rows, "first": cases[0].patient, "second": cases[1].patient}


def _relative(scene: Scene, line: Polyline, anchor: str) -> float:
    """Distance of the line to the landmark of its side, in parts of that from nipple to xiphoid."""
    side = line.name[-1]
    place: Array = scene.landmarks[f"{anchor}_{side}"]
    size = np.linalg.norm(scene.landmarks[f"nipple_{side}"] - scene.landmarks["xiphoid"])
    return round(float(line.distances(place[None])[0] / size), 4)

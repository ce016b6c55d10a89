"""Measures the error of a lesion transferred through the body to another stance.

PATIENT/tumours.json has balls inside the breasts as the same tissue in several stances (millimetres in the axes of each
scan's file). Both scans are fitted with their landmarks.

Ways: `volume`, the program's; what a user could have instead: `rigid` motion and thin-plate `spline` through the
landmarks of both.
"""

import json
from itertools import permutations
from typing import Any

import numpy as np
from scipy.interpolate import RBFInterpolator

from breastrig.core.arrays import Array
from breastrig.drawings.line_error import carried_errors
from breastrig.drawings.skin_maps.interior_map import moved_inside
from breastrig.fitting.recipe import Recipe
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig_studies.cohort import Case
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.transfer import fitted

FILE = "tumours.json"
WAYS = ("volume", "rigid", "spline")
NEEDED = 4  # landmarks for an affine motion


def lesions_study(cases: tuple[Case, ...], rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """{"rows": one for each pair of stances and direction of the patient's scans that show lesions}."""
    found = json.loads((cases[0].folder.parent / FILE).read_text("utf-8"))["tumours"]
    shown = [case for case in cases if found and case.name in found[0]["center"]]
    scenes = [read_scene(case) for case in shown]
    fits = [fitted(rig, recipe, scene, scene.landmarks) for scene in scenes]
    centers = [1e-3 * np.array([each["center"][case.name] for each in found]) for case in shown]
    rows = []
    for a, b in permutations(range(len(shown)), 2):
        there = moved_inside(rig, fits[a], fits[b], centers[a])
        ways = {"volume": there} | _by_landmarks(scenes[a], scenes[b], centers[a])
        gaps = {way: np.linalg.norm(moved - centers[b], axis=1) for way, moved in ways.items()}
        row: dict[str, Any] = {"from": shown[a].name, "to": shown[b].name, "lesions": len(found)}
        row |= {way: {"mean_mm": _mm(gap.mean()), "p95_mm": _mm(np.percentile(gap, 95))} for way, gap in gaps.items()}
        said = carried_errors(rig, fits[a], fits[b], centers[a], there, on_skin=False)
        rows.append(row | ({} if said is None else {"held": round(float(np.mean(gaps["volume"] <= said)), 4)}))
    return {"rows": rows}


def _mm(metres: float) -> float:
    return round(1e3 * float(metres), 3)


def _by_landmarks(a: Scene, b: Scene, points: Array) -> dict[str, Array]:
    names = [name for name in a.landmarks if name in b.landmarks]
    if len(names) < NEEDED:
        return {}
    source, goal = (np.array([scene.landmarks[name] for name in names]) for scene in (a, b))
    turn = umeyama(source, goal).rotation
    return {
        "rigid": np.asarray((points - source.mean(axis=0)) @ turn.T + goal.mean(axis=0)),
        "spline": np.asarray(RBFInterpolator(source, goal, kernel="linear", degree=1)(points)),
    }

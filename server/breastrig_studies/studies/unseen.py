"""Measures the parts of a body that a scan does not show.

The scan is cut at the navel, at the nipples and along the midline, fitted with the landmarks that are left, and
compared with the fit of the whole scan: bone scales, volume, size of the shape weights, and how far the skin moved.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.recipe import Recipe
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig_studies.studies.case import Fitted, Scene, ready

CUTS = {"navel": "umbilicus", "nipples": "nipple_L", "half": "xiphoid"}  # where each cut runs
MARGIN = 0.005  # m, so that the landmark of the cut itself stays


@dataclass(frozen=True, eq=False)
class Cut:
    """A part of a scene and its fit."""

    scene: Scene
    fit: Fitted


def whole_fit(scene: Scene, rig: Rig, recipe: Recipe) -> Fitted:
    return scene.fitted(rig, recipe, scene.landmarks)


def cut_fit(scene: Scene, rig: Rig, recipe: Recipe, whole: Fitted, cut: str) -> Cut | None:
    """The fit to the rest of a cut: above navel or nipples, or the left half; None without the cut's landmark."""
    if CUTS[cut] not in scene.landmarks:
        return None
    axes = umeyama(rig.template, whole.vertices).rotation  # columns: left, up, front
    axis = axes[:, 0] if cut == "half" else axes[:, 1]
    level = axis @ scene.landmarks[CUTS[cut]] - MARGIN

    def above(points: Array) -> Array:
        return np.asarray(points @ axis > level)

    faces = scene.target.faces[above(scene.target.vertices)[scene.target.faces].all(axis=1)]
    used, renumbered = np.unique(faces, return_inverse=True)
    part = replace(
        scene,
        target=ready(ScanTarget(scene.target.vertices[used], renumbered.reshape(-1, 3))),
        landmarks={name: place for name, place in scene.landmarks.items() if above(place[None])[0]},
    )
    return Cut(part, part.fitted(rig, recipe, part.landmarks))


def _volume(rig: Rig, vertices: Array) -> float:
    """m³ between the skin and the body's middle."""
    return float(np.linalg.det(vertices[rig.faces] - vertices.mean(axis=0)).sum() / 6.0)


def unseen(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """The numbers of every cut."""
    whole = whole_fit(scene, rig, recipe)
    sigma = np.array([shape.sigma for shape in rig.shapes])

    def size(fit: Fitted) -> float:
        return float(np.sqrt(np.mean((fit.parameters.weights / sigma) ** 2)))

    answer: dict[str, Any] = {}
    for cut in CUTS:
        part = cut_fit(scene, rig, recipe, whole, cut)
        if part is None:
            continue
        scales = part.fit.parameters.scales / whole.parameters.scales
        gap = 1e3 * np.linalg.norm(part.fit.vertices - whole.vertices, axis=1)
        answer[cut] = {
            "kept": len(part.scene.target.faces) / len(scene.target.faces),
            "smallest_scale": float(scales.min()),
            "largest_scale": float(scales.max()),
            "volume": _volume(rig, part.fit.vertices) / _volume(rig, whole.vertices),
            "weights": size(part.fit) / max(size(whole), 1e-9),
            "moved_mm": float(gap.mean()),
            "most_moved_mm": float(gap.max()),
        }
    return answer

"""How far a fitted surface is from the scan, from the true surface and from the true landmarks.

Surface, scan and landmark numbers are those of every fit (report/distances.py); what only an evaluation can
know, the truth, is added here.  All results are millimetres, rounded to 0.1 µm, ready for JSON.
"""

from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.correspondence.target import ScanTarget
from breastrig.evaluation.subject import Subject
from breastrig.fitting.similarity import umeyama
from breastrig.geometry.normals import vertex_normals
from breastrig.report.distances import landmark_summary_mm, summary_mm, surface_distances, surface_summary_mm
from breastrig.rig.model import Rig

SEEN_DISTANCE = 0.015  # m; paragraph 4 of the specification
SEEN_COSINE = 0.5  # 60 degrees
WRONG_WAY = np.radians(45.0)  # a fit turned further than this away from the true landmarks stands wrong


def seen(rig: Rig, target: ScanTarget, vertices: Array) -> Booleans:
    """(V,) whether the scan shows the skin at each of the (V, 3) m model vertices."""
    distances, nearest = target.vertex_tree.query(vertices)
    facing = np.einsum("vi,vi->v", vertex_normals(vertices, rig.faces), target.normals[nearest])
    return np.asarray((distances < SEEN_DISTANCE) & (facing > SEEN_COSINE))


def truth_mm(rig: Rig, subject: Subject, vertices: Array) -> dict[str, float | None] | None:
    """Distance of the seen model vertices to the true surface; None where no truth is known."""
    if subject.truth is None:
        return None
    visible = seen(rig, subject.target, vertices)
    distances = subject.truth.query(vertices[visible], 16).distances if visible.any() else np.zeros(0)
    return {**summary_mm(distances), "seen": round(float(visible.mean()), 4)}


def landmarks_mm(rig: Rig, subject: Subject, vertices: Array, names: tuple[str, ...] | None = None) -> dict[str, Any]:
    """Distances of the model's landmarks to the true ones: those named, or all."""
    chosen = tuple(subject.landmarks) if names is None else names
    places = rig.landmark_points(chosen).positions(vertices, rig.faces) if chosen else np.zeros((0, 3))
    model = dict(zip(chosen, places, strict=True))
    return landmark_summary_mm(model, {name: subject.landmarks[name] for name in chosen})


def stands_wrong(rig: Rig, subject: Subject, vertices: Array) -> bool:
    """Whether the fitted model is turned away from the true landmarks, for instance head down."""
    model = rig.landmark_points(tuple(subject.landmarks)).positions(vertices, rig.faces)
    turn = umeyama(model, np.array(list(subject.landmarks.values()))).rotation
    return bool(np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0)) > WRONG_WAY)


def all_measures(rig: Rig, subject: Subject, vertices: Array) -> dict[str, Any]:
    """Every number of Table 1 but the time."""
    distances = surface_distances(subject.target, vertices, rig.faces)
    return {
        "surface_distance_mm": surface_summary_mm(distances.model),
        "scan_to_model_mm": summary_mm(distances.scan),
        "landmark_distance_mm": landmarks_mm(rig, subject, vertices),
        "truth_distance_mm": truth_mm(rig, subject, vertices),
    }


def surface_mean_mm(rig: Rig, subject: Subject, vertices: Array) -> float | None:
    """Mean of the paper's surface distance."""
    return surface_summary_mm(surface_distances(subject.target, vertices, rig.faces).model)["mean"]

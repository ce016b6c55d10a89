"""What one stage of the recipe asks of one state of the model: its matches, and the terms made of them."""

from dataclasses import replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.match import Correspondences, MatchRules, match
from breastrig.energies.landmarks import Landmarks
from breastrig.energies.point_to_plane import PointToPlane
from breastrig.energies.point_to_point import PointToPoint
from breastrig.fitting.observation_weights import observation_weights
from breastrig.fitting.recipe import Range, Stage
from breastrig.fitting.task import FitTask
from breastrig.least_squares.problem import ResidualTerm
from breastrig.least_squares.robust import KERNELS
from breastrig.rig.parameters import RigParameters


def along(pair: Range, progress: float) -> float:
    """A range's value when the stage has tightened by `progress` (0 to 1)."""
    return float(pair[0] * (pair[1] / pair[0]) ** progress)


def stage_matches(task: FitTask, stage: Stage, progress: float, vertices: Array, normals: Array) -> Correspondences:
    """Matches of this stage's share of the model's (V, 3) vertices (m) with their unit normals."""
    rules = MatchRules(
        stage.method, along(stage.max_distance, progress), stage.max_angle, reject_border=stage.reject_border
    )
    if stage.every == 1:
        return match(task.target, vertices, normals, rules)
    chosen = np.arange(0, len(vertices), stage.every)
    found = match(task.target, vertices[chosen], normals[chosen], rules)
    return replace(found, vertices=chosen[found.vertices])


def projected(matches: Correspondences, vertices: Array) -> Correspondences:
    """The matches with each scan point moved along its tangent plane until it lies on its normal through the vertex.

    vertices: (V, 3) m, all of the model.
    """
    own = vertices[matches.vertices]
    heights = np.einsum("mi,mi->m", matches.normals, matches.points - own)
    return replace(matches, points=own + heights[:, None] * matches.normals)


def scan_terms(
    task: FitTask, stage: Stage, progress: float, vertices: Array, matches: Correspondences
) -> list[ResidualTerm[RigParameters]]:
    """The terms that the scan and its landmarks give for the model's (V, 3) vertices (m)."""
    counts = observation_weights(task.rig, task.recipe.observations, stage.every)[matches.vertices]
    weights = counts * KERNELS[stage.kernel](matches.distances / along(stage.kernel_scale, progress))
    data_sigma = along(stage.data_sigma, progress)
    data: ResidualTerm[RigParameters]
    if stage.data_term == "point_to_projection":
        data = PointToPoint(task.rig, projected(matches, vertices), weights, data_sigma)
    elif stage.along_sigma is not None:
        data = PointToPoint(task.rig, matches, weights, along(stage.along_sigma, progress), data_sigma)
    else:
        data = PointToPlane(task.rig, matches, weights, data_sigma)
    terms: list[ResidualTerm[RigParameters]] = [data]
    if task.landmarks:
        names = tuple(task.landmarks)
        unsure = np.array([task.landmark_errors.get(name, 0.0) for name in names])
        sigma = np.hypot(along(stage.landmark_sigma, progress), unsure)
        targets, points = np.array([task.landmarks[name] for name in names]), task.rig.landmark_points(names)
        if stage.landmark_kernel_scale is not None:
            gaps = np.linalg.norm(points.positions(vertices, task.rig.faces) - targets, axis=1)
            trust = KERNELS["geman_mcclure"](gaps / np.hypot(along(stage.landmark_kernel_scale, progress), unsure))
            sigma = sigma / np.sqrt(np.maximum(trust, 1e-6))
        terms.append(Landmarks(task.rig, points, targets, sigma))
    return terms

"""The registration: match, build the terms, one damped Newton step, yield; stage after stage.

A generator of frozen iterates is the only way to run a fit: the command line, the service and the tests all
consume it, and whoever stops consuming cancels the fit.  Nothing here prints, stores or draws.
"""

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from breastrig.correspondence.match import Correspondences
from breastrig.energies.joint_rest import JointRest
from breastrig.fitting.bounds import free_unknowns, onto_simplex, step_bounds
from breastrig.fitting.priors import expected_joints, prior_terms, step_scaling
from breastrig.fitting.recipe import Stage
from breastrig.fitting.stage_terms import scan_terms, stage_matches
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.geometry.normals import VertexNormals
from breastrig.least_squares.newton import Status, newton_step
from breastrig.rig.skinning import posed

__all__ = ["MIN_MATCHES", "FitIterate", "FitTask", "fit_iterates"]

MIN_MATCHES = 30  # fewer cannot hold 136 unknowns, whatever the priors


def fit_iterates(task: FitTask) -> Iterator[FitIterate]:
    """Yields the start as iteration 0, then one iterate a step; the last one's status says why it stopped."""
    began = time.perf_counter()
    rig, recipe = task.rig, task.recipe
    names = tuple(task.landmarks)
    landmark_points = rig.landmark_points(names) if names else None
    picked = np.array([task.landmarks[name] for name in names])
    normals_of = VertexNormals(rig.faces, len(rig.template))
    joints = expected_joints(task)
    priors, held, scaling = prior_terms(task, joints), [JointRest(joints)], step_scaling(task, task.start.dof)
    x, iteration, quiet, previous = task.start, 0, 0, np.inf
    energy = float("nan")

    def iterate(stage: Stage, matches: Correspondences, status: Status) -> FitIterate:
        vertices = posed(rig, x).vertices
        gap = None
        if landmark_points is not None:
            gap = float(np.linalg.norm(landmark_points.positions(vertices, rig.faces) - picked, axis=1).mean())
        mean = float(matches.distances.mean()) if len(matches.distances) else float("nan")
        coverage = len(matches.distances) * stage.every / len(vertices)
        return FitIterate(iteration, stage.name, x, energy, mean, coverage, gap, time.perf_counter() - began, status)

    for stage in recipe.stages:
        free = free_unknowns(task, stage, x.dof)
        last_stage = stage is recipe.stages[-1]
        quiet = 0
        for step_number in range(stage.iterations):
            progress = min(step_number / max(stage.tighten - 1, 1), 1.0)
            vertices = posed(rig, x).vertices
            matches = stage_matches(task, stage, progress, vertices, normals_of(vertices))
            mean = float(matches.distances.mean()) if len(matches.distances) else np.inf
            still = progress == 1.0 and abs(mean - previous) < recipe.stop.distance_change_m
            quiet = quiet + 1 if still else 0
            previous = mean
            if last_stage and quiet >= recipe.stop.patience:
                yield iterate(stage, matches, Status.CONVERGED)
                return
            if len(matches.distances) < MIN_MATCHES and not names:
                yield iterate(stage, matches, Status.STALLED)
                return
            yield iterate(stage, matches, Status.RUNNING)
            terms = [*priors, *scan_terms(task, stage, progress, vertices, matches)]
            step = newton_step(
                terms, held, x, scaling=scaling, damping=recipe.damping, bounds=step_bounds(task, x), free=free
            )
            if step.status is Status.NOT_FINITE:
                yield iterate(stage, matches, Status.NOT_FINITE)
                return
            x, energy = step.x, step.energy
            if recipe.shapes.constraint == "simplex":
                x = replace(x, weights=onto_simplex(x.weights))
            iteration += 1
            if step.status is Status.STALLED and last_stage:
                yield iterate(stage, matches, Status.STALLED)
                return
    vertices = posed(rig, x).vertices
    matches = stage_matches(task, stage, 1.0, vertices, normals_of(vertices))
    yield iterate(stage, matches, Status.OUT_OF_ITERATIONS)

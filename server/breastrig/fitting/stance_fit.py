"""One scan's part of a fit: its priors, matches and terms at a state, and what is told of the state.

The single fit has one of these, the fit of two stances two; the rules that stop a fit stand here too, so that
both stop alike.
"""

import time

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.match import Correspondences
from breastrig.energies.joint_rest import JointRest
from breastrig.fitting.priors import expected_joints, prior_terms, step_scaling
from breastrig.fitting.recipe import Stage, Stop
from breastrig.fitting.stage_terms import scan_terms, stage_matches
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.geometry.normals import VertexNormals
from breastrig.least_squares.newton import Status
from breastrig.least_squares.problem import Constraint, ResidualTerm
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import posed

MIN_MATCHES = 30  # fewer cannot hold 136 unknowns, whatever the priors


def stage_progress(stage: Stage, step: int) -> float:
    """How far the stage has tightened before its step number `step`: 0 to 1."""
    return min(step / max(stage.tighten - 1, 1), 1.0)


class Stillness:
    """Counts the iterations in a row in which the mean distance hardly changed."""

    def __init__(self, stop: Stop) -> None:
        self._stop, self._previous, self._quiet = stop, np.inf, 0

    def new_stage(self) -> None:
        self._quiet = 0

    def reached(self, mean: float, progress: float) -> bool:
        """Whether the fit may end at this mean distance (m); only a stage that has tightened can be still."""
        still = progress == 1.0 and abs(mean - self._previous) < self._stop.distance_change_m
        self._quiet = self._quiet + 1 if still else 0
        self._previous = mean
        return self._quiet >= self._stop.patience


class StanceFit:
    """All of a fit that hangs on one scan and not on the unknowns' layout."""

    def __init__(self, task: FitTask) -> None:
        self.task = task
        joints = expected_joints(task)
        self.priors: list[ResidualTerm[RigParameters]] = prior_terms(task, joints)
        self.held: list[Constraint[RigParameters]] = [JointRest(joints)]
        self.scaling = step_scaling(task, task.start.dof)
        self._normals_of = VertexNormals(task.rig.faces, len(task.rig.template))
        self._names = tuple(task.landmarks)
        self._picked = np.array([task.landmarks[name] for name in self._names])
        self._began = time.perf_counter()

    def matches(self, stage: Stage, progress: float, x: RigParameters) -> Correspondences:
        vertices = posed(self.task.rig, x).vertices
        return stage_matches(self.task, stage, progress, vertices, self._normals_of(vertices))

    def lost(self, matches: Correspondences) -> bool:
        """Neither skin nor landmarks hold the model."""
        return len(matches.distances) < MIN_MATCHES and not self._names

    def terms(
        self, stage: Stage, progress: float, x: RigParameters, matches: Correspondences
    ) -> list[ResidualTerm[RigParameters]]:
        vertices = posed(self.task.rig, x).vertices
        return [*self.priors, *scan_terms(self.task, stage, progress, vertices, matches)]

    def landmark_distance(self, vertices: Array) -> float | None:
        """m, mean over the picked landmarks; None without picks."""
        if not self._names:
            return None
        places = self.task.rig.landmark_points(self._names).positions(vertices, self.task.rig.faces)
        return float(np.linalg.norm(places - self._picked, axis=1).mean())

    def iterate(
        self, iteration: int, stage: Stage, x: RigParameters, energy: float, matches: Correspondences, status: Status
    ) -> FitIterate:
        vertices = posed(self.task.rig, x).vertices
        return FitIterate(
            iteration=iteration,
            stage=stage.name,
            parameters=x,
            energy=energy,
            mean_distance=mean_distance(matches, np.nan),
            coverage=len(matches.distances) * stage.every / len(vertices),
            landmark_distance=self.landmark_distance(vertices),
            elapsed_s=time.perf_counter() - self._began,
            status=status,
        )


def mean_distance(matches: Correspondences, without: float) -> float:
    """m, mean over the accepted matches, or `without` when there are none."""
    return float(matches.distances.mean()) if len(matches.distances) else without

"""Reads one case and prepares it, with the steps that all questions share: fit, measure, pick.

`truth`: from each *seen* model vertex (a scan point within 15 mm whose normal is within 60 degrees) to the true
surface. Scenes of the last cases are kept, because the questions come case by case.
"""

import time
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadScan, FitFailed
from breastrig.core.stances import PRONE
from breastrig.core.units import METRES_PER_UNIT
from breastrig.correspondence.distances import ACCEPTED, summary_mm
from breastrig.correspondence.match import match
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.hypotheses import found_stance
from breastrig.fitting.picks.issues import unusual
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.prepare_scan import prepared
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.starts.orientation import (
    MIN_LANDMARKS,
    SURE_LANDMARKS,
    Start,
    best_start,
    prone_start,
    start_from_scan,
)
from breastrig.fitting.task import FitTask, PickIssue, ended
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose
from breastrig.scan.clean import Surface, clean
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.orient import Frame, propose_frame
from breastrig.scan.read import read_scan
from breastrig_studies.cohort import Case

SEEN_DISTANCE, SEEN_COSINE = 0.015, 0.5  # m, cosine of 60 degrees
KEPT_SCENES = 2  # the case at hand and its neighbour in the queue; each holds some 30 MB of search trees


@dataclass(frozen=True, eq=False)
class Fitted:
    """The end of one fit, in the frame of the scene (m)."""

    vertices: Array  # (V, 3)
    parameters: RigParameters
    seconds: float  # of the solver alone: one core's time, so that work beside it does not count
    iterations: int
    doubts: tuple[PickIssue, ...]  # what the program says of the picks


class TrueLandmarks(dict[str, Array]):
    """True places, (3,) m by name; a body without a breast has no nipple there, and no answer where one is needed."""

    def __missing__(self, name: str) -> Array:
        raise FitFailed(f"The body has no {name}, without which this question has no answer.")


@dataclass(frozen=True, eq=False)
class Scene:
    """A scan, in its own frame (m), and what is known of it."""

    case: Case
    target: ScanTarget  # as the program fits it in this stance: without the table under a lying patient
    whole: Surface  # with the table
    landmarks: dict[str, Array]  # true places, (3,) m
    truth: ClosestPointSearch | None
    _starts: dict[Rig, Start] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def frame(self) -> Frame:
        """Front and stance as the program proposes them."""
        return propose_frame(self.whole.vertices, self.whole.faces)

    def found_stance(self, rig: Rig, recipe: Recipe, start: RigParameters) -> str:
        """The stance that the program finds by itself, without landmarks."""
        return found_stance(FitTask(rig, self.target, start, recipe, {}), self.frame).stance

    def place(self, rig: Rig) -> Start:
        """The start that the program finds in the known stance, without landmarks."""
        if self.case.stance == PRONE:
            return prone_start(rig, self.target, self.frame)
        return self._upright(rig)

    def _upright(self, rig: Rig) -> Start:
        """The start found from the scan alone, cached."""
        if rig not in self._starts:
            self._starts[rig] = start_from_scan(rig, self.target, self.frame.fronts)
        return self._starts[rig]

    def start(self, rig: Rig, given: dict[str, Array]) -> RigParameters:
        """The start that the program chooses for these landmarks ((3,) m by name)."""
        if len(given) < MIN_LANDMARKS:
            return self.place(rig).parameters
        known = self._upright(rig).similarity if len(given) < SURE_LANDMARKS else None
        return best_start(rig, self.target, given, lambda: self.frame.fronts, known)

    def fitted(
        self,
        rig: Rig,
        recipe: Recipe,
        given: dict[str, Array],
        start: RigParameters | None = None,
        stance: str | None = None,
    ) -> Fitted:
        """The program's fit from its own start (or `start`) in the known stance (or `stance`); FitFailed."""
        first = self.start(rig, given) if start is None else start
        task = FitTask(rig, self.target, first, recipe, {}, stance or self.case.stance).with_picks(given)
        began = time.process_time()
        *_, last = checked_iterates(task)
        seconds = time.process_time() - began
        vertices = pose(rig, last.parameters)
        if not np.isfinite(vertices).all():
            raise FitFailed("The fit broke down: a number is not finite.")
        if not np.isfinite(last.mean_distance):
            raise FitFailed("The model found no skin of the scan near it.")
        posterior = Posterior(ended(task, last), last.parameters)
        doubts = (*last.not_followed, *unusual(posterior))
        return Fitted(vertices, last.parameters, seconds, last.iteration, doubts)

    def landmark_errors(self, rig: Rig, vertices: Array, names: tuple[str, ...] = ()) -> Array:
        """(L,) m between the model's landmarks and the true ones; all that are known when none are named."""
        names = names or tuple(self.landmarks)
        places = rig.landmark_points(names).positions(vertices, rig.faces)
        return np.asarray(np.linalg.norm(places - np.array([self.landmarks[name] for name in names]), axis=1))

    def truth_errors(self, vertices: Array, faces: Integers) -> Array:
        """(V,) m to the true surface, nan where the scan shows nothing or nothing is known."""
        result = np.full(len(vertices), np.nan)
        if self.truth is None:
            return result
        distance, nearest = self.target.vertex_tree.query(vertices)
        facing = np.einsum("vi,vi->v", vertex_normals(vertices, faces), self.target.normals[nearest])
        seen = (distance < SEEN_DISTANCE) & (facing > SEEN_COSINE)
        result[seen] = self.truth.query(vertices[seen]).distances
        return result

    def numbers(self, rig: Rig, vertices: Array) -> dict[str, Any]:
        """Surface, truth and landmarks in mm, for the studies; Table 1 has more."""
        found = match(self.target, vertices, vertex_normals(vertices, rig.faces), ACCEPTED)
        return {
            "surface_mm": summary_mm(found.distances)["mean"],
            "truth_mm": summary_mm(self.truth_errors(vertices, rig.faces))["mean"],
            "landmarks_mm": summary_mm(self.landmark_errors(rig, vertices))["mean"],
        }

    def along_the_skin(self, place: Array, distance: float, rng: np.random.Generator) -> Array:
        """A pick on the scan's skin about `distance` m away from (3,) m, in a random direction."""
        step = rng.normal(size=3)
        moved = place
        for _ in range(4):  # on the skin and `distance` away, by turns
            step *= distance / np.linalg.norm(step)
            moved = self.target.search.query((place + step)[None]).points[0]
            step = moved - place
        return np.asarray(moved)


def ready(target: ScanTarget) -> ScanTarget:
    """Builds what is built on first use, so that no fit's time counts it."""
    _ = target.rays, target.search, target.vertex_tree, target.normals, target.on_border, target.face_normals
    return target


@lru_cache(maxsize=KEPT_SCENES)
def read_scene(case: Case) -> Scene:
    """The case's files; BadInput says what is wrong with them."""
    scan = read_scan(case.scan, None, case.unit, texture=False)
    scanned = prepared(clean(scan), case.stance)
    places, unit = read_landmarks(case.folder / "landmarks.json")
    per_unit = METRES_PER_UNIT[unit or scan.unit]
    landmarks = {name: per_unit * np.asarray(place) for name, place in places.items()}
    truth = None
    if (case.folder / "truth.ply").is_file():
        clear = read_scan(case.folder / "truth.ply", None, scan.unit, texture=False)
        truth = ClosestPointSearch(clear.vertices, np.asarray(clear.faces))
    if not landmarks:
        raise BadScan(f"{case.folder / 'landmarks.json'} is empty; a case needs true landmarks to be measured.")
    return Scene(case, ready(scanned.target), scanned.surface, TrueLandmarks(landmarks), truth)

"""One case, fitted in the ways that the questions ask for, measured against what is known.

`truth`: from each *seen* model vertex (a scan point within 15 mm whose normal is within 60 degrees) to the true
surface.  `half`: half of the landmarks given, the other half measured, both ways round.  `none`: no landmarks, the
scan turned at random, so that nothing can hang on its being upright.
"""

import time
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.units import METRES_PER_UNIT
from breastrig.correspondence.target import ScanTarget
from breastrig.evaluation.cohort import Case
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.landmark_check import start_from_landmarks
from breastrig.fitting.orientation import start_from_scan
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.refine import refined
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.report.distances import summary_mm, surface_distances, surface_summary_mm
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose
from breastrig.scan.clean import clean
from breastrig.scan.landmark_files import read_landmarks
from breastrig.scan.orient import propose_frame
from breastrig.scan.read import read_scan

SEEN_DISTANCE, SEEN_COSINE = 0.015, 0.5  # m, cosine of 60 degrees
CLICK_ERROR = 0.005  # m, along the skin
FIRST_HALF = (  # both sides and the middle in each half
    "suprasternal_notch",
    "xiphoid",
    "midclavicle_R",
    "acromion_L",
    "nipple_R",
    "inframammary_fold_L",
)


@dataclass(frozen=True, eq=False)
class _Scene:
    rig: Rig
    recipe: Recipe
    stance: str
    target: ScanTarget
    landmarks: dict[str, Array]  # true places, m
    truth: ClosestPointSearch | None

    def fitted(self, given: dict[str, Array]) -> tuple[Array, float, int]:
        """(V, 3) m fitted vertices, solve time in s, iterations."""
        task = FitTask(self.rig, self.target, start_from_landmarks(self.rig, given), self.recipe, given, self.stance)
        began = time.perf_counter()
        last = list(fit_iterates(task))[-1]
        return pose(self.rig, last.parameters), time.perf_counter() - began, last.iteration

    def landmark_errors(self, vertices: Array, names: tuple[str, ...]) -> Array:
        """(L,) m between the model's landmarks and the true ones."""
        places = self.rig.landmark_points(names).positions(vertices, self.rig.faces)
        return np.asarray(np.linalg.norm(places - np.array([self.landmarks[n] for n in names]), axis=1))

    def truth_errors(self, vertices: Array) -> Array:
        """(V,) m to the true surface, nan where the scan shows nothing or nothing is known."""
        result = np.full(len(vertices), np.nan)
        if self.truth is None:
            return result
        distance, nearest = self.target.vertex_tree.query(vertices)
        facing = np.einsum("vi,vi->v", vertex_normals(vertices, self.rig.faces), self.target.normals[nearest])
        seen = (distance < SEEN_DISTANCE) & (facing > SEEN_COSINE)
        result[seen] = self.truth.query(vertices[seen], candidates=16).distances
        return result


def _scene(case: Case, rig: Rig, recipe: Recipe) -> _Scene:
    scan = read_scan(case.folder / "scan.ply", None, case.unit, texture=False)
    surface = clean(scan)
    centre = surface.vertices.mean(axis=0)
    target = ScanTarget(surface.vertices - centre, surface.faces)
    places, unit = read_landmarks(case.folder / "landmarks.json")
    per_unit = METRES_PER_UNIT[unit or scan.unit]
    landmarks = {name: per_unit * np.asarray(place) - centre for name, place in places.items()}
    truth = None
    if (case.folder / "truth.ply").is_file():
        clear = read_scan(case.folder / "truth.ply", None, scan.unit, texture=False)
        truth = ClosestPointSearch(clear.vertices - centre, np.asarray(clear.faces))
    _ = target.rays, target.search, target.vertex_tree, target.normals, target.on_border, target.face_normals
    return _Scene(rig, recipe, case.stance, target, landmarks, truth)


def _clicked(scene: _Scene, rng: np.random.Generator) -> dict[str, Array]:
    """The landmarks with a click error along the skin."""
    moved = {}
    for name, place in scene.landmarks.items():
        step = rng.normal(size=3)
        for _ in range(4):  # on the skin and CLICK_ERROR away, by turns
            step *= CLICK_ERROR / np.linalg.norm(step)
            moved[name] = scene.target.search.query((place + step)[None], candidates=8).points[0]
            step = moved[name] - place
    return moved


def _turned(scene: _Scene, rng: np.random.Generator) -> tuple[float, float]:
    """Mean surface distance and mean landmark error (m) without landmarks, from a random orientation."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    target = ScanTarget(scene.target.vertices @ turn.T, scene.target.faces)
    frame = propose_frame(target.vertices, target.faces)
    start = start_from_scan(scene.rig, target, frame.front)
    task = FitTask(scene.rig, target, start.parameters, scene.recipe, {}, frame.stance)
    vertices = pose(scene.rig, list(fit_iterates(task))[-1].parameters)
    surface = surface_distances(target, vertices, scene.rig.faces).model
    errors = scene.landmark_errors(vertices @ turn, tuple(scene.landmarks))
    return float(np.nanmean(surface)), float(errors.mean())


def evaluate_case(case: Case, rig: Rig, recipe: Recipe) -> dict[str, object]:
    """All numbers of one case, in mm and s."""
    scene = _scene(case, rig, recipe)
    names = tuple(scene.landmarks)
    rng = np.random.default_rng(7)
    vertices, seconds, iterations = scene.fitted(scene.landmarks)
    distances = surface_distances(scene.target, vertices, rig.faces)
    fine = refined(scene.target, vertices, rig.faces).vertices
    halves = []
    for given in (FIRST_HALF, tuple(name for name in names if name not in FIRST_HALF)):
        others = tuple(name for name in names if name not in given)
        part, _, _ = scene.fitted({name: scene.landmarks[name] for name in names if name in given})
        halves.append(scene.landmark_errors(part, others))
    clicked, _, _ = scene.fitted(_clicked(scene, rng))
    turned = [_turned(scene, rng) for _ in range(2)]
    landmark = 1e3 * scene.landmark_errors(vertices, names)
    return {
        "patient": case.patient,
        "case": case.name,
        "stance": case.stance,
        "family": case.family,
        "preset": recipe.name,
        "time_s": round(seconds, 4),
        "iterations": iterations,
        "surface_mm": surface_summary_mm(distances.model),
        "scan_to_model_mm": summary_mm(distances.scan),
        "truth_mm": summary_mm(scene.truth_errors(vertices)),
        "landmark_mm": {
            "mean": round(float(landmark.mean()), 4),
            "std": round(float(landmark.std()), 4),
            "max": round(float(landmark.max()), 4),
            "min": round(float(landmark.min()), 4),
        },
        "half_given_mm": summary_mm(np.concatenate(halves)),
        "click_error": {
            "truth_mm": summary_mm(scene.truth_errors(clicked)),
            "landmark_mm": summary_mm(scene.landmark_errors(clicked, names)),
        },
        "no_landmarks": {
            "surface_mm": round(1e3 * float(np.mean([surface for surface, _ in turned])), 4),
            "landmark_mm": round(1e3 * float(np.mean([error for _, error in turned])), 4),
        },
        "refined": {
            "surface_mm": surface_summary_mm(surface_distances(scene.target, fine, rig.faces).model),
            "truth_mm": summary_mm(scene.truth_errors(fine)),
        },
    }

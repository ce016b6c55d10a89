"""One case, fitted in the ways that the questions ask for, measured against what is known.

`truth`: from each *seen* model vertex (a scan point within 15 mm whose normal is within 60 degrees) to the true
surface.  `half`: half of the landmarks given, the other half measured, both ways round.  `none`: no landmarks, the
scan turned at random, so that nothing can hang on its being upright.
"""

import time
import zlib
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadLandmarks, FitFailed
from breastrig.core.units import METRES_PER_UNIT
from breastrig.correspondence.target import ScanTarget
from breastrig.evaluation.cohort import Case
from breastrig.evaluation.peers import Peer
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.landmark_check import MIN_LANDMARKS, start_from_landmarks
from breastrig.fitting.orientation import start_from_scan
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.refine import refined
from breastrig.fitting.similarity import umeyama
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.least_squares.newton import Status
from breastrig.report.distances import summary_mm, surface_distances, surface_summary_mm
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose
from breastrig.scan.clean import clean
from breastrig.scan.landmark_files import read_landmarks
from breastrig.scan.orient import propose_frame
from breastrig.scan.read import read_scan

SEEN_DISTANCE, SEEN_COSINE = 0.015, 0.5  # m, cosine of 60 degrees
CLICK_ERROR = 0.005  # m, along the skin, in a random direction
CLICKABLE = 0.010  # m; a landmark farther from the scan lies in a hole, where nobody can click
WRONG_WAY = np.radians(45.0)  # a model turned further than this from the true landmarks stands wrong
TURNS = 3  # random orientations of a scan that is fitted without landmarks
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

    centre: Array  # (3,) m, in the scan's own frame

    def fitted(self, given: dict[str, Array]) -> tuple[Array, float, int]:
        """(V, 3) m fitted vertices, solve time in s, iterations."""
        task = FitTask(self.rig, self.target, start_from_landmarks(self.rig, given), self.recipe, given, self.stance)
        began = time.perf_counter()
        last = list(fit_iterates(task))[-1]
        if last.status is Status.NOT_FINITE or not np.isfinite(last.mean_distance):
            raise FitFailed("The fit found no skin near the model, or a number was not finite.")
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
    per_unit = METRES_PER_UNIT[unit] if unit else scan.metres_per_unit
    unknown = [name for name in places if name not in rig.landmark_names]
    if unknown or len(places) < MIN_LANDMARKS:
        what = f"the model has no landmark {unknown[0]}" if unknown else "fewer than three landmarks are given"
        raise BadLandmarks(f"{case.folder / 'landmarks.json'}: {what}; mend the file.")
    landmarks = {name: per_unit * np.asarray(place) - centre for name, place in places.items()}
    truth = None
    if (case.folder / "truth.ply").is_file():
        clear = read_scan(case.folder / "truth.ply", None, scan.unit, texture=False)
        truth = ClosestPointSearch(clear.vertices - centre, np.asarray(clear.faces))
    _ = target.rays, target.search, target.vertex_tree, target.normals, target.on_border, target.face_normals
    return _Scene(rig, recipe, case.stance, target, landmarks, truth, centre)


def _clicked(scene: _Scene, rng: np.random.Generator) -> dict[str, Array]:
    """The landmarks that the scan shows, with a click error along the skin."""
    moved, target = {}, scene.target
    for name, place in scene.landmarks.items():
        step = rng.normal(size=3)
        at = target.search.query(place[None], candidates=16)
        if at.distances[0] > CLICKABLE:
            continue
        normal = target.normals_at(at.faces, at.barycentric)[0]
        step -= (step @ normal) * normal
        step *= CLICK_ERROR / np.linalg.norm(step)
        moved[name] = target.search.query(at.points + step, candidates=16).points[0]
    return moved


def _turned(scene: _Scene, rng: np.random.Generator) -> tuple[float, float, bool]:
    """Mean surface distance and landmark error (m) without landmarks, randomly turned; whether it stands wrong."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    target = ScanTarget(scene.target.vertices @ turn.T, scene.target.faces)
    frame = propose_frame(target.vertices, target.faces)
    start = start_from_scan(scene.rig, target, frame.front)
    task = FitTask(scene.rig, target, start.parameters, scene.recipe, {}, frame.stance)
    last = list(fit_iterates(task))[-1]
    if last.status is Status.NOT_FINITE or not np.isfinite(last.mean_distance):
        raise FitFailed("Without landmarks the fit found no skin near the model.")
    vertices = pose(scene.rig, last.parameters)
    surface = surface_distances(target, vertices, scene.rig.faces).model
    names = tuple(scene.landmarks)
    errors = scene.landmark_errors(vertices @ turn, names)
    model = scene.rig.landmark_points(names).positions(vertices @ turn, scene.rig.faces)
    left = umeyama(model, np.array(list(scene.landmarks.values()))).rotation
    wrong = np.arccos(np.clip(0.5 * (np.trace(left) - 1.0), -1.0, 1.0)) > WRONG_WAY
    return float(np.nanmean(surface)), float(errors.mean()), bool(wrong)


def _half_given(scene: _Scene) -> dict[str, dict[str, float | None]]:
    """Landmarks measured that were not given, and the surface, over both ways round; empty where it cannot be."""
    names = tuple(scene.landmarks)
    errors, surfaces = [], []
    for given in (FIRST_HALF, tuple(name for name in names if name not in FIRST_HALF)):
        kept, others = [n for n in names if n in given], tuple(n for n in names if n not in given)
        if len(kept) < MIN_LANDMARKS or not others:
            continue
        vertices, _, _ = scene.fitted({name: scene.landmarks[name] for name in kept})
        errors.append(scene.landmark_errors(vertices, others))
        surfaces.append(surface_distances(scene.target, vertices, scene.rig.faces).model)
    nothing = np.zeros(0)
    return {
        "landmark_mm": summary_mm(np.concatenate(errors) if errors else nothing),
        "surface_mm": summary_mm(np.concatenate(surfaces) if surfaces else nothing),
    }


def _table_1(scene: _Scene, vertices: Array, seconds: float, iterations: int) -> dict[str, object]:
    distances = surface_distances(scene.target, vertices, scene.rig.faces)
    landmark = 1e3 * scene.landmark_errors(vertices, tuple(scene.landmarks))
    named = {"mean": landmark.mean(), "std": landmark.std(), "max": landmark.max(), "min": landmark.min()}
    return {
        "time_s": round(seconds, 4),
        "iterations": iterations,
        "surface_mm": surface_summary_mm(distances.model),
        "scan_to_model_mm": summary_mm(distances.scan),
        "truth_mm": summary_mm(scene.truth_errors(vertices)),
        "landmark_mm": {name: round(float(value), 4) for name, value in named.items()},
    }


def evaluate_case(case: Case, rig: Rig, recipe: Recipe) -> tuple[dict[str, object], Array]:
    """All numbers of one case, in mm and s, and (V, 3) m the fitted surface in the scan's own frame.

    Raises FitFailed when one of the fits has no usable result.
    """
    scene = _scene(case, rig, recipe)
    names = tuple(scene.landmarks)
    rng = np.random.default_rng(zlib.crc32(case.title.encode()))
    vertices, seconds, iterations = scene.fitted(scene.landmarks)
    fine = refined(scene.target, vertices, rig.faces).vertices
    half = _half_given(scene)
    clicks = _clicked(scene, rng)
    click_numbers: dict[str, dict[str, float | None]] = {
        "truth_mm": summary_mm(np.zeros(0)),
        "landmark_mm": summary_mm(np.zeros(0)),
    }
    if len(clicks) >= MIN_LANDMARKS:
        clicked, _, _ = scene.fitted(clicks)
        click_numbers["truth_mm"] = summary_mm(scene.truth_errors(clicked))
        click_numbers["landmark_mm"] = summary_mm(scene.landmark_errors(clicked, names))
    turned = [_turned(scene, rng) for _ in range(TURNS)]
    numbers = _table_1(scene, vertices, seconds, iterations) | {
        "half_given_mm": half["landmark_mm"],
        "half_given_surface_mm": half["surface_mm"],
        "click_error": {"picks": len(clicks), **click_numbers},
        "no_landmarks": {
            "surface_mm": round(1e3 * float(np.mean([surface for surface, _, _ in turned])), 4),
            "landmark_mm": round(1e3 * float(np.mean([error for _, error, _ in turned])), 4),
            "stands_wrong": sum(wrong for _, _, wrong in turned),
        },
        "refined": {
            "surface_mm": surface_summary_mm(surface_distances(scene.target, fine, rig.faces).model),
            "truth_mm": summary_mm(scene.truth_errors(fine)),
        },
    }
    return numbers, vertices + scene.centre


def evaluate_peer(case: Case, rig: Rig, peer: Peer) -> tuple[dict[str, object], Array]:
    """The same of another method, as far as Table 1 goes."""
    scene = _scene(case, rig, load_recipe("default"))
    began = time.perf_counter()
    vertices = peer(rig, scene.target, scene.landmarks)
    numbers = _table_1(scene, vertices, time.perf_counter() - began, 0)
    return numbers, vertices + scene.centre

"""The example patient's scan, spoilt in the ways that real scans are; each with its figure.

The reference is the fit of the unspoilt scan with the same landmarks: what matters is how far the fitted model
moves on the chest and breasts, which every spoilt scan still shows somewhere.
"""

from dataclasses import dataclass

import numpy as np
import pytest
import trimesh

from breastrig.core.arrays import Array, Integers
from breastrig.core.assets import asset_folder
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.landmark_check import start_from_landmarks
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.least_squares.newton import Status
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose
from breastrig.scan.clean import clean, compact
from breastrig.scan.landmark_files import read_landmarks
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan

EXAMPLE = asset_folder("example") / "standing"


@dataclass(frozen=True, eq=False)
class Patient:
    rig: Rig
    vertices: Array  # (V, 3) m, centred
    faces: Integers
    landmarks: dict[str, Array]
    chest: Integers  # model vertices above the navel and in front
    fitted: Array  # (V, 3) m, the model on the unspoilt scan

    def fit(self, vertices: Array, faces: Integers) -> Array:
        """(V, 3) m: the model fitted to another scan of her."""
        surface = clean(Scan(vertices, faces, "m", 1.0, "As asked for.", "0" * 64))
        target = ScanTarget(surface.vertices, surface.faces)
        start = start_from_landmarks(self.rig, self.landmarks)
        last = list(fit_iterates(FitTask(self.rig, target, start, load_recipe("default"), self.landmarks)))[-1]
        assert last.status is Status.CONVERGED
        return pose(self.rig, last.parameters)

    def moved_mm(self, vertices: Array, faces: Integers) -> float:
        """Mean distance of the chest from where the unspoilt scan puts it."""
        gap = self.fit(vertices, faces)[self.chest] - self.fitted[self.chest]
        return float(1e3 * np.linalg.norm(gap, axis=1).mean())


@pytest.fixture(scope="module")
def patient() -> Patient:
    rig = read_rig(default_rig_path())
    scan = read_scan(EXAMPLE / "scan.ply", None, "auto")
    centre = scan.vertices.mean(axis=0)
    places, _ = read_landmarks(EXAMPLE / "landmarks.json")
    landmarks = {name: 1e-3 * np.asarray(place) - centre for name, place in places.items()}
    chest = np.unique(np.concatenate([rig.regions["breast_L"], rig.regions["breast_R"]]))
    blank = Patient(rig, scan.vertices - centre, np.asarray(scan.faces), landmarks, chest, np.zeros((0, 3)))
    return Patient(rig, blank.vertices, blank.faces, landmarks, chest, blank.fit(blank.vertices, blank.faces))


def test_two_millimetres_of_noise_move_the_model_less_than_one(patient: Patient, rng: np.random.Generator) -> None:
    noisy = patient.vertices + rng.normal(scale=0.002, size=patient.vertices.shape)
    assert patient.moved_mm(noisy, patient.faces) < 1.0


def test_a_third_of_the_surface_missing_in_patches(patient: Patient, rng: np.random.Generator) -> None:
    centres = patient.vertices[rng.choice(len(patient.vertices), 400)]
    middle = patient.vertices[patient.faces].mean(axis=1)
    gone = np.zeros(len(middle), dtype=np.bool_)
    for centre in centres:
        if gone.mean() > 0.3:
            break
        gone |= np.linalg.norm(middle - centre, axis=1) < 0.025
    assert gone.mean() > 0.3
    assert patient.moved_mm(patient.vertices, patient.faces[~gone]) < 1.2


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_arm_that_is_missing(patient: Patient, side: float) -> None:
    beyond = side * patient.landmarks["acromion_L" if side > 0 else "acromion_R"][0]
    kept = (side * patient.vertices[patient.faces][:, :, 0] < beyond).all(axis=1)
    assert patient.moved_mm(patient.vertices, patient.faces[kept]) < 0.6


def test_a_scan_of_the_very_front_only(patient: Patient) -> None:
    corners = patient.vertices[patient.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing = normals[:, 2] > 0.35 * np.linalg.norm(normals, axis=1)
    assert patient.moved_mm(patient.vertices, patient.faces[facing]) < 2.0


def test_two_thousand_triangles_are_enough(patient: Patient) -> None:
    cells = np.round(patient.vertices / 0.018).astype(np.int64)  # one vertex for each cube of 18 mm
    _, inverse = np.unique(cells, axis=0, return_inverse=True)
    inverse = inverse.ravel()
    count = np.bincount(inverse)
    merged = np.stack([np.bincount(inverse, weights=patient.vertices[:, axis]) / count for axis in range(3)], axis=1)
    faces = inverse[patient.faces]
    solid = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    faces = np.unique(np.sort(faces[solid], axis=1), axis=0, return_index=True)[1]
    coarse = inverse[patient.faces][solid][faces]
    assert len(coarse) < 2500
    assert patient.moved_mm(merged, coarse) < 2.5


def test_half_a_million_triangles_change_nothing(patient: Patient) -> None:
    vertices, faces = patient.vertices, patient.faces
    for _ in range(2):
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    assert len(faces) > 450_000
    assert patient.moved_mm(vertices, faces) < 0.5


def test_inside_out_and_mixed_winding_change_nothing(patient: Patient, rng: np.random.Generator) -> None:
    mixed = np.where(rng.random(len(patient.faces))[:, None] < 0.5, patient.faces[:, ::-1], patient.faces)
    assert patient.moved_mm(patient.vertices, patient.faces[:, ::-1]) == 0.0
    assert patient.moved_mm(patient.vertices, mixed) == 0.0


def test_what_the_scan_does_not_show_keeps_human_proportions(patient: Patient) -> None:
    """Cut at the nipples: the unseen waist and hips stay within a hand's breadth of the full scan's fit."""
    height = patient.landmarks["nipple_L"][1]
    kept = (patient.vertices[patient.faces][:, :, 1] > height).all(axis=1)
    vertices, faces = compact(patient.vertices, patient.faces[kept])
    upper = {name: place for name, place in patient.landmarks.items() if place[1] > height - 0.01}
    cut = Patient(patient.rig, vertices, faces, upper, patient.chest, patient.fitted)
    gap = 1e3 * np.linalg.norm(cut.fit(vertices, faces) - patient.fitted, axis=1)
    assert gap.mean() < 10.0
    assert gap.max() < 70.0

"""The example patient's scan, spoilt in the ways that real scans are; each with its figure.

The reference is the fit of the unspoilt scan with the same landmarks: what matters is how far the fitted model
moves on the chest and breasts, which every spoilt scan still shows somewhere.
"""

import numpy as np
import pytest
from helpers.example_patient import Patient, example_patient

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def patient() -> Patient:
    return example_patient()


@pytest.mark.slow
def test_two_millimetres_of_noise_move_the_model_by_one(patient: Patient, rng: np.random.Generator) -> None:
    """In the mean of six scans; single ones differ by a quarter of it."""
    scans = (patient.vertices + rng.normal(scale=0.002, size=patient.vertices.shape) for _ in range(6))
    assert np.mean([patient.moved_mm(noisy, patient.faces) for noisy in scans]) < 1.1


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


def test_an_arm_that_is_missing(patient: Patient) -> None:
    kept = (patient.vertices[patient.faces][:, :, 0] < patient.landmarks["acromion_L"][0]).all(axis=1)
    assert patient.moved_mm(patient.vertices, patient.faces[kept]) < 0.6


def test_a_scan_of_the_very_front_only(patient: Patient) -> None:
    corners = patient.vertices[patient.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing = normals[:, 2] > 0.35 * np.linalg.norm(normals, axis=1)
    assert patient.moved_mm(patient.vertices, patient.faces[facing]) < 3.0


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


def test_mixed_winding_changes_nothing(patient: Patient, rng: np.random.Generator) -> None:
    mixed = np.where(rng.random(len(patient.faces))[:, None] < 0.5, patient.faces[:, ::-1], patient.faces)
    assert patient.moved_mm(patient.vertices, mixed) == 0.0

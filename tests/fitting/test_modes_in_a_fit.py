"""What the smooth modes do to a fit of the example patient (decision 0039)."""

import numpy as np
import pytest
from helpers.example_patient import Patient, example_patient, without_modes

from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.rig.skinning import pose

MOVED = 0.01  # m, a pick beside what shapes can show


@pytest.fixture(scope="module")
def patient() -> Patient:
    return example_patient()


def from_pick(patient: Patient, recipe: Recipe) -> tuple[float, float]:
    """(mm from the model's left fold to a pick that lies MOVED beside the true one, mm that the shoulders moved)."""
    picks = patient.landmarks | {
        "inframammary_fold_L": patient.landmarks["inframammary_fold_L"] + np.array([MOVED, 0.0, 0.0])
    }
    x = patient.parameters(patient.vertices, patient.faces, picks, recipe)
    names = ("inframammary_fold_L", "acromion_L", "acromion_R")
    places = patient.rig.landmark_points(names).positions(pose(patient.rig, x), patient.rig.faces)
    before = patient.rig.landmark_points(names).positions(patient.fitted, patient.rig.faces)
    away = np.linalg.norm(places - np.array([picks["inframammary_fold_L"], *before[1:]]), axis=1)
    return 1e3 * float(away[0]), 1e3 * float(away[1:].max())


def test_a_pick_beside_what_shapes_can_show_is_followed_farther(patient: Patient) -> None:
    recipe = load_recipe("default")
    away, moved = from_pick(patient, recipe)
    without, _ = from_pick(patient, without_modes(recipe))
    assert without > 5.0
    assert away < 0.8 * without
    assert moved < 0.1, "the arms stay where they are"

"""What the scan does not show stays plausible: half of the example's scan against the fit of the whole.

On ten given scans cut in the same three ways the bones kept 0.85 to 1.20 of their scales, the volume 0.80 to 1.08.
"""

import numpy as np
import pytest
from helpers.example_patient import Patient, example_patient, silent, without_modes

from breastrig.core.arrays import Array, Booleans
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.expected_body import prior_terms
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.task import FitTask
from breastrig.least_squares.newton import assemble
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose
from breastrig.rig.state import BodyState
from breastrig.scan.clean import compact

CUTS = ("navel", "nipples", "left half")
UNSEEN_MEAN = {"navel": 0.001, "nipples": 0.006, "left half": 0.0075}  # m between the two fits
UNSEEN_WORST = {"navel": 0.015, "nipples": 0.04, "left half": 0.07}  # m; hips, and the other arm as it hangs


@pytest.fixture(scope="module")
def patient() -> Patient:
    return example_patient()


def kept(patient: Patient, cut: str, points: Array) -> Booleans:
    """Which of (M, 3) points the cut leaves."""
    if cut == "left half":
        return np.asarray(points[:, 0] > patient.landmarks["xiphoid"][0] - 0.005)
    below = "umbilicus" if cut == "navel" else "nipple_L"
    return np.asarray(points[:, 1] > patient.landmarks[below][1] - 0.005)


def cut_fit(patient: Patient, cut: str, recipe: Recipe | None = None) -> RigParameters:
    inside = kept(patient, cut, patient.vertices)[patient.faces].all(axis=1)
    landmarks = {n: p for n, p in patient.landmarks.items() if kept(patient, cut, p[None])[0]}
    return patient.parameters(*compact(patient.vertices, patient.faces[inside]), landmarks, recipe)


def volume(patient: Patient, vertices: Array) -> float:
    """m³ between the skin and the body's middle."""
    corners = vertices[patient.rig.faces] - vertices.mean(axis=0)
    return float(np.linalg.det(corners).sum() / 6.0)


@pytest.mark.slow
@pytest.mark.parametrize("cut", CUTS)
def test_unseen_parts_keep_human_proportions(patient: Patient, cut: str) -> None:
    x, full = cut_fit(patient, cut), patient.x
    ratio = x.scales / full.scales
    assert ratio.min() > 0.8, f"smallest share of a bone's scale {ratio.min():.2f}"
    assert ratio.max() < 1.25, f"largest share of a bone's scale {ratio.max():.2f}"
    share = volume(patient, pose(patient.rig, x)) / volume(patient, patient.fitted)
    assert 0.85 < share < 1.15, f"volume {share:.3f} of the full scan's fit"
    sizes = [np.sqrt(np.mean((p.weights / [shape.sigma for shape in patient.rig.shapes]) ** 2)) for p in (x, full)]
    assert sizes[0] < 1.1 * sizes[1], "less to see must not make the shapes wilder"
    gap = np.linalg.norm(pose(patient.rig, x) - patient.fitted, axis=1)
    assert gap.mean() < UNSEEN_MEAN[cut], f"{1e3 * gap.mean():.1f} mm"
    assert gap.max() < UNSEEN_WORST[cut], f"{1e3 * gap.max():.0f} mm"


def test_an_unseen_breast_takes_the_shape_of_the_seen_one(patient: Patient) -> None:
    """Half a body: where nothing tells of it, each weight is what its priors agree on, given all that is seen."""
    x, rig = cut_fit(patient, "left half", without_modes(silent(load_recipe("default")))), patient.rig
    names = [shape.name for shape in rig.shapes]
    seen = {name: x.weights[k] for k, name in enumerate(names) if name.endswith("_L")}
    assert max(abs(weight) for weight in seen.values()) > 0.5  # there is a shape to follow
    assert np.sqrt(np.mean(np.square(list(seen.values())))) > 0.2
    task = FitTask(rig, ScanTarget(patient.vertices, patient.faces), x, load_recipe("default"), {})
    state = BodyState(rig, x)
    system = assemble(prior_terms(task), state)
    free = [
        k for k, shape in enumerate(rig.shapes) if shape.name.endswith("_R") and shape.min < x.weights[k] < shape.max
    ]
    hidden = len(system.gradient) - len(names) + np.array(free)
    to_go = np.linalg.solve(system.hessian[np.ix_(hidden, hidden)], -system.gradient[hidden])
    for step, k in zip(to_go, free, strict=True):
        assert abs(step) < 0.05, f"{names[k]} is {step:.2f} from where the priors have it"
    followed = [x.weights[k] * seen[rig.shapes[k].mirror] for k in free if abs(seen[rig.shapes[k].mirror]) > 0.3]
    assert np.mean(np.array(followed) > 0.0) > 0.8, "large shapes go the same way on both sides"

"""What a pick was meant for is asked by evidence."""

import numpy as np
import pytest
from helpers.rig_patient import patient

from breastrig.core.arrays import Array
from breastrig.fitting.fit import fit_iterates
from breastrig.fitting.picks.issues import mistaken
from breastrig.fitting.posterior import LeaveOneOut, Posterior, evidence_along_skin, meant_evidence
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.fitting.task import FitTask
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.least_squares.problem import log_student
from breastrig.rig.parameters import RigParameters


def test_the_evidence_is_the_density_of_a_students_t(rng: np.random.Generator) -> None:
    """Along the skin alone."""
    from scipy.stats import multivariate_t

    root = rng.normal(size=(3, 3))
    covariance, normal = root @ root.T, np.array([0.0, 0.0, 1.0])
    gaps = rng.normal(size=(5, 3))
    found = np.array([evidence_along_skin(gap, covariance, normal) for gap in gaps])
    true = multivariate_t(np.zeros(2), covariance[:2, :2], df=4).logpdf(gaps[:, :2])
    np.testing.assert_allclose(found, true, atol=1e-12)
    assert log_student(0.0, 3) == 0.0


def fitted(seed: int) -> tuple[FitTask, RigParameters, dict[str, Array]]:
    """The task of a body that the rig shows exactly, where its fit ends, and its landmarks."""
    rig = read_rig(default_rig_path())
    target, true, _ = patient(rig, seed)
    task = FitTask(rig, target, start_from_landmarks(rig, true), load_recipe("default"), {}).with_picks(true)
    *_, last = fit_iterates(task)
    return task, last.parameters, true


def test_a_place_between_two_landmarks_says_of_neither_that_it_is_the_other() -> None:
    """As on a breast that hangs: a pick near the nipple was rejected as one of it, although it was the fold's."""
    task, x, true = fitted(5)
    nipple, fold = true["nipple_L"], true["inframammary_fold_L"]
    found = []
    for share in (1.0, 0.6):
        picks = true | {"inframammary_fold_L": fold + share * (nipple - fold)}
        found.append([doubt.names for doubt in mistaken(task.with_picks(picks).without(("nipple_L",)), x, 3)])
    assert found == [[("inframammary_fold_L",)], []]


@pytest.mark.parametrize("name", ["nipple_L", "acromion_R"])
def test_a_right_pick_was_meant_for_its_landmark(name: str) -> None:
    task, x, _ = fitted(3)
    posterior = Posterior(task, x, partners=False)
    own = LeaveOneOut(posterior).evidence()[name]
    others = [meant_evidence(posterior, task.given[name], each) for each in task.rig.landmark_names if each != name]
    assert own > max(others) + 10.0

"""A lying back: where it is expected, and that it does not reach through the table."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.rig_patient import patient

from breastrig.correspondence.target import ScanTarget
from breastrig.energies.table_contact import TableContact
from breastrig.fitting.fit import FitTask
from breastrig.fitting.problem import ScanProblem, resting_back, table_contact
from breastrig.fitting.recipe import load_recipe
from breastrig.geometry.plane import Plane
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.state import BodyState


@pytest.fixture(scope="module")
def torso() -> Rig:
    return read_rig(default_rig_path())


def contact(rig: Rig, height: float) -> TableContact:
    """All of the back expected 0.02 m above a table at this height along +Z."""
    back = rig.regions["back"]
    return TableContact(
        rig, Plane(np.array([0.0, 0.0, 1.0]), height), (back,), np.array([0.02]), np.array([[1e-4]]), 0.004
    )


def test_a_back_at_its_expected_height_costs_nothing(torso: Rig) -> None:
    state = BodyState(torso, rest_parameters(torso))
    depth = state.vertices[torso.regions["back"], 2]
    resting = contact(torso, float(depth.mean()) - 0.02).residual(state)
    assert resting[0] == pytest.approx(0.0, abs=1e-9)
    low = contact(torso, float(depth.min()) - 1e-6).residual(state)
    assert low[1:] == pytest.approx(0.0)


def test_what_reaches_through_the_table_is_pushed_back(torso: Rig) -> None:
    state = BodyState(torso, rest_parameters(torso))
    depth = state.vertices[torso.regions["back"], 2]
    term = contact(torso, float(np.median(depth)))
    below = term.residual(state)[1:]
    assert (below[depth < np.median(depth)] < 0.0).all()
    assert (below[depth >= np.median(depth)] == 0.0).all()


def task(rig: Rig, stance: str, table: Plane | None) -> FitTask:
    target, landmarks, _ = patient(rig, 1)
    seen = ScanTarget(target.vertices, target.faces, table=table)
    return FitTask(rig, seen, rest_parameters(rig), load_recipe("default"), landmarks, stance)


def test_a_plane_far_from_the_back_is_no_table_under_it(torso: Rig) -> None:
    """A wall behind, or a pillow under her: such a plane must not pull the back to it."""
    depth = float(torso.template[torso.regions["back"], 2].mean())
    normal = np.array([0.0, 0.0, 1.0])
    assert resting_back(task(torso, "supine", Plane(normal, depth - 0.05))) is not None
    assert resting_back(task(torso, "supine", Plane(normal, depth - 0.20))) is None
    assert resting_back(task(torso, "supine", Plane(normal, depth + 0.10))) is None


def test_only_a_lying_patient_on_a_table_that_is_seen_rests_on_it(torso: Rig) -> None:
    plane = Plane(np.array([0.0, 0.0, 1.0]), float(torso.template[torso.regions["back"], 2].mean()) - 0.05)
    assert resting_back(task(torso, "standing", plane)) is None
    assert resting_back(task(torso, "supine", None)) is None
    lying = task(torso, "supine", plane)
    assert resting_back(replace(lying, rig=replace(torso, name="somebody"))) is None
    problem, stage = ScanProblem(lying), lying.recipe.stages[0]
    state = problem.start()
    terms = problem.terms(stage, 1.0, state, problem.matches(stage, 1.0, state))
    found = next(term for term in terms if isinstance(term, TableContact))
    np.testing.assert_array_equal(np.sort(np.concatenate(found.parts)), np.sort(torso.regions["back"]))


def test_arms_and_front_that_lie_higher_raise_the_back(torso: Rig) -> None:
    """Women of whom the scan shows more height above the table have a higher back: that is all that tells it."""
    depth = float(torso.template[torso.regions["back"], 2].mean()) - 0.05
    lying = task(torso, "supine", Plane(np.array([0.0, 0.0, 1.0]), depth))
    known = resting_back(lying)
    assert known is not None
    state = BodyState(torso, rest_parameters(torso))
    shift = torso.template.copy()
    shift[:, 2] += 0.02
    heights = [known.back_given(vertices[:, 2] - depth, 0.004)[0] for vertices in (torso.template, shift)]
    assert (heights[1] > heights[0] + 0.003).all()
    assert table_contact(lying, known, state).mean == pytest.approx(heights[0])

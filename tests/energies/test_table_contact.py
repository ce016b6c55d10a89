"""A lying back: where it is expected, and that it does not reach through the table."""

import numpy as np
import pytest
from helpers.rig_patient import patient

from breastrig.correspondence.target import ScanTarget
from breastrig.energies.table_contact import TableContact
from breastrig.fitting.body.expected_body import prior_terms, table_contact
from breastrig.fitting.fit import FitTask
from breastrig.fitting.recipe import load_recipe
from breastrig.geometry.plane import Plane
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.state import BodyState


def contact(rig: Rig, height: float) -> TableContact:
    """All of the back expected 0.02 m above a table at this height along +Z."""
    back = rig.regions["back"]
    return TableContact(rig, Plane(np.array([0.0, 0.0, 1.0]), height), (back,), np.array([0.02]), 0.01, 0.005, 0.004)


def test_a_back_at_its_expected_height_costs_nothing(torso: Rig) -> None:
    state = BodyState(torso, rest_parameters(torso))
    depth = state.vertices[torso.regions["back"], 2]
    resting = contact(torso, float(depth.mean()) - 0.02).residual(state)
    assert resting[:2] == pytest.approx(0.0, abs=1e-9)
    low = contact(torso, float(depth.min()) - 1e-6).residual(state)
    assert low[2:] == pytest.approx(0.0)


def test_what_reaches_through_the_table_is_pushed_back(torso: Rig) -> None:
    state = BodyState(torso, rest_parameters(torso))
    depth = state.vertices[torso.regions["back"], 2]
    term = contact(torso, float(np.median(depth)))
    below = term.residual(state)[2:]
    assert (below[depth < np.median(depth)] < 0.0).all()
    assert (below[depth >= np.median(depth)] == 0.0).all()


def task(rig: Rig, stance: str, table: Plane | None) -> FitTask:
    target, landmarks, _ = patient(rig, 1)
    seen = ScanTarget(target.vertices, target.faces, table=table)
    return FitTask(rig, seen, rest_parameters(rig), load_recipe("default"), {}, stance).with_picks(landmarks)


def test_a_plane_far_from_the_back_is_no_table_under_it(torso: Rig) -> None:
    """A wall behind, or a pillow under her: such a plane must not pull the back to it."""
    depth = float(torso.template[torso.regions["back"], 2].mean())
    normal = np.array([0.0, 0.0, 1.0])
    assert table_contact(task(torso, "supine", Plane(normal, depth - 0.05))) is not None
    assert table_contact(task(torso, "supine", Plane(normal, depth - 0.20))) is None
    assert table_contact(task(torso, "supine", Plane(normal, depth + 0.10))) is None


def test_only_a_lying_patient_on_a_table_that_is_seen_rests_on_it(torso: Rig) -> None:
    plane = Plane(np.array([0.0, 0.0, 1.0]), float(torso.template[torso.regions["back"], 2].mean()) - 0.05)
    assert table_contact(task(torso, "standing", plane)) is None
    assert table_contact(task(torso, "supine", None)) is None
    lying = task(torso, "supine", plane)
    found = table_contact(lying)
    assert sum(map(len, found.groups)) > 0.9 * len(torso.regions["back"])
    assert "table_contact" in {term.name for term in prior_terms(lying)}

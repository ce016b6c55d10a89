"""Breasts that hang are found without landmarks; whose breasts do not pays nothing for it."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.correspondence.distances import Comparison
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.expected_body import body_terms
from breastrig.fitting.body.hanging import hanging_shapes, hanging_start, opening_of, unexplained_overhang
from breastrig.fitting.fit import FitIterate
from breastrig.fitting.picks.issues import unusual
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.solve import checked_iterates, iterates_with_second_start
from breastrig.fitting.starts.orientation import start_from_scan
from breastrig.fitting.task import FitTask, ended
from breastrig.fitting.verdicts.fit_signals import fit_signals
from breastrig.least_squares.newton import Status
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import pose
from breastrig.rig.state import BodyState
from breastrig.scan.clean import compact
from breastrig_studies.virtual.warped.body import warped_body
from breastrig_studies.virtual.warped.numbers import Numbers
from breastrig_studies.virtual.warped.sources import read_sources

FRONT = np.array([[0.0, 0.0, 1.0]])
HANGING = replace(Numbers(), nipples_over_folds=(-0.04, -0.04))
NIPPLES = ("nipple_L", "nipple_R")


@cache
def woman(numbers: Numbers, stance: str = "standing") -> tuple[ScanTarget, dict[str, Array]]:
    """The skin of one woman of the virtual cohort that a camera before her sees, and her landmarks."""
    source = next(each for each in read_sources() if each.name == "cohort_patient_4")
    warped = warped_body(source, source.lying[0], numbers)
    body = warped.standing if stance == "standing" else warped.supine
    vertices, places = body.vertices, body.landmarks
    middles = vertices[source.faces].mean(axis=1)
    seen = source.scanned[source.faces].all(axis=1) & (middles[:, 2] > -0.02)
    seen &= (middles[:, 1] > places["umbilicus"][1] - 0.1) & (middles[:, 1] < places["suprasternal_notch"][1] + 0.04)
    return ScanTarget(*compact(vertices, source.faces[seen])), places


def fitted(rig: Rig, numbers: Numbers, recipe: Recipe) -> tuple[list[FitIterate], float]:
    """All iterates of a fit without landmarks, and m from its nipples to the true ones."""
    target, places = woman(numbers)
    start = start_from_scan(rig, target, FRONT).parameters
    iterates = list(iterates_with_second_start(FitTask(rig, target, start, recipe, {})))
    found = rig.landmark_points(NIPPLES).positions(pose(rig, iterates[-1].parameters), rig.faces)
    return iterates, float(np.linalg.norm(found - [places[name] for name in NIPPLES], axis=1).mean())


@pytest.mark.slow
def test_nipples_of_breasts_that_hang_are_found_without_landmarks(rig: Rig) -> None:
    recipe = load_recipe("default")
    once, flattened = fitted(rig, HANGING, recipe.model_copy(update={"hanging": None}))
    twice, off = fitted(rig, HANGING, recipe)
    assert flattened > 0.08
    assert off < 0.011
    assert [each.iteration for each in twice] == list(range(len(twice)))
    assert all(a.elapsed_s <= b.elapsed_s for a, b in pairwise(twice))
    assert [each.status is Status.RUNNING for each in twice] == [True] * (len(twice) - 1) + [False]
    assert len(twice) > len(once)


def test_skin_that_faces_down_is_unexplained_on_its_own_side_only(rig: Rig) -> None:
    """A model that hangs on the left is looked at with one that does not, and with itself."""
    rest = rest_parameters(rig)
    weights = rest.weights.copy()
    weights[rig.shape_names.index("ptosis_L")] = 2.5
    hanging = replace(rest, weights=weights)
    target = ScanTarget(pose(rig, hanging), rig.faces)
    assert unexplained_overhang(rig, target, hanging) == {"L": 0.0, "R": 0.0}
    missed = unexplained_overhang(rig, target, rest)
    settings = load_recipe("default").hanging
    assert missed["L"] > settings.least
    assert missed["R"] < settings.least
    start = hanging_start(rig, rest, settings, missed)
    changed = {name for name, a, b in zip(rig.shape_names, start.weights, rest.weights, strict=True) if a != b}
    assert changed == {"ptosis_L"}
    assert hanging_start(rig, rest, settings, {"L": 0.0, "R": 0.0}) is rest


def test_where_breasts_were_seen_to_hang_that_is_expected_and_nothing_else_changes(rig: Rig) -> None:
    recipe, rest = load_recipe("default"), rest_parameters(rig)
    place = rig.shape_names.index("ptosis_L")

    def energy(hanging: tuple[str, ...], weight: float) -> float:
        weights = rest.weights.copy()
        weights[place] = weight
        assert recipe.hanging is not None
        asked = (recipe.hanging, hanging) if hanging else None
        terms = body_terms(rig, recipe.shapes, recipe.scales, recipe.body, "standing", asked)
        state = BodyState(rig, replace(rest, weights=weights))
        return float(sum(np.sum(term.residual(state) ** 2) for term in terms))

    assert energy(("ptosis_L",), 2.0) < energy((), 2.0) - 10.0  # three standard deviations less
    assert energy(("ptosis_L",), 0.0) > energy((), 0.0)
    assert energy(("ptosis_R",), 2.0) > energy((), 2.0)
    weights = rest.weights.copy()
    weights[place] = 1.5
    assert hanging_shapes(rig, replace(rest, weights=weights), recipe) == ("ptosis_L",)
    assert hanging_shapes(rig, rest, recipe) == ()
    assert hanging_shapes(rig, replace(rest, weights=weights), load_recipe("paper")) == ()


def test_only_a_preset_that_asks_looks() -> None:
    recipe = load_recipe("default")
    assert [stage.name for stage in opening_of(recipe)] == ["pose", "shape"]
    assert opening_of(recipe.model_copy(update={"stages": recipe.stages[2:]})) == ()
    assert opening_of(load_recipe("paper")) == ()


@pytest.mark.slow
def test_right_picks_on_breasts_that_hang_are_believed_and_the_fit_is_good(rig: Rig) -> None:
    target, places = woman(HANGING)
    gaps, _ = target.vertex_tree.query(np.array(list(places.values())))
    picks = {name: at for (name, at), gap in zip(places.items(), gaps, strict=True) if gap < 0.01}
    start = start_from_scan(rig, target, FRONT).parameters
    task = FitTask(rig, target, start, load_recipe("default"), {}).with_picks(picks)
    *_, last = checked_iterates(task)
    assert last.not_followed == ()
    assert unusual(Posterior(ended(task, last), last.parameters)) == ()
    wrong = picks | {"nipple_L": picks["nipple_L"] + [0.05, 0.0, 0.0]}
    task = task.with_picks(wrong)
    *_, last = checked_iterates(task)
    named = {name for doubt in unusual(Posterior(ended(task, last), last.parameters)) for name in doubt.names}
    assert "nipple_L" in named | {name for doubt in last.not_followed for name in doubt.names}


def test_how_skin_faces_is_not_asked_of_breasts_that_hang(rig: Rig) -> None:
    """The same skin with the breasts' lower halves turned: of breasts that do not hang it is a reason to look."""
    rest = rest_parameters(rig)
    weights = rest.weights.copy()
    for side in "LR":
        weights[rig.shape_names.index(f"ptosis_{side}")] = 2.0
    hanging = replace(rest, weights=weights)
    target = ScanTarget(pose(rig, rest), rig.faces)
    compared = Comparison(target, pose(rig, hanging), rig.faces)
    stiff = fit_signals(rig, hanging, compared, None)
    asked = fit_signals(rig, rest, compared, None)
    assert stiff.angle_p90 < 0.5 * asked.angle_p90

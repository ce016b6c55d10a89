"""The basis of a fit's checks is its posterior: what it promises is what the fit has with that pick in it."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.forearm import forearm_rig
from helpers.rig_patient import patient

from breastrig.fitting.checks.basis import CheckBasis, basis_bytes, check_basis, on_vertices, read_basis
from breastrig.fitting.checks.choose import next_checks, widest
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.fitting.uncertainty.radii import planned_on, radii
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig

GIVEN = ("suprasternal_notch", "nipple_R", "umbilicus")


@pytest.fixture(scope="module")
def torso() -> Rig:
    return read_rig(default_rig_path())


@pytest.fixture(scope="module")
def fitted(torso: Rig) -> Posterior:
    """A patient with three picks."""
    target, true, _ = patient(torso, 5)
    start = start_from_landmarks(torso, true)
    task = FitTask(torso, target, start, load_recipe("default"), {}).with_picks({name: true[name] for name in GIVEN})
    last = list(fit_iterates(task))[-1]
    return Posterior(replace(task, relief=last.relief), last.parameters)


def basis_of(posterior: Posterior, deviation: float = 0.0) -> CheckBasis:
    known = radii(posterior, size_deviation=deviation)
    assert known is not None
    return check_basis(posterior, known, {}, posterior.task.picked)


@pytest.mark.parametrize("name", ["nipple_L", "midclavicle_L", "xiphoid", "inframammary_fold_R", "acromion_R"])
def test_a_pick_leaves_what_the_posterior_has_with_it(name: str, torso: Rig, fitted: Posterior) -> None:
    """Partners and what the skin's form shows of it included; picked where the model has it, so that nothing moves."""
    basis = basis_of(fitted)
    vertices = np.arange(0, len(torso.template), 7)
    index = torso.landmark_names.index(name)
    _, added, _ = basis.observable.picked(index)
    after = basis.gaussian(fitted.state, vertices).with_information(added)
    place = torso.landmark_points((name,)).positions(fitted.state.vertices, torso.faces)[0]
    picks = fitted.task.landmarks | {name: place}
    relief = {seen: each for seen, each in (fitted.task.relief or {}).items() if seen != name}
    with_it = Posterior(replace(fitted.task.with_picks(picks), relief=relief), fitted.state.x)
    np.testing.assert_allclose(after.vertices, with_it.vertex_variances()[vertices], rtol=1e-6)
    names = tuple(torso.landmark_names)
    joint = with_it.joint_landmark_covariance(names)
    np.testing.assert_allclose(after.landmarks, joint, atol=1e-6 * np.abs(joint).max())


def test_open_are_the_landmarks_that_the_scan_shows_and_nobody_has_picked(torso: Rig, fitted: Posterior) -> None:
    target = fitted.task.target
    names = tuple(torso.landmark_names)
    whole = basis_of(fitted).observable
    assert {name for name, free in zip(names, whole.open, strict=True) if free} == {*names} - {*GIVEN}
    notch = fitted.task.landmarks["suprasternal_notch"]
    low = target.vertices[:, 1] < notch[1] - 0.06  # without collarbones
    cut = type(target)(target.vertices, target.faces[low[target.faces].all(axis=1)])
    part = basis_of(Posterior(replace(fitted.task, target=cut), fitted.state.x)).observable
    shut = {name for name, free in zip(names, part.open, strict=True) if not free}
    assert {"midclavicle_L", "midclavicle_R"} <= shut
    assert {"nipple_L", "xiphoid"} <= {*names} - shut
    points = torso.landmark_points(("xiphoid",)).positions(fitted.state.vertices, torso.faces)
    whole_skin = np.linalg.norm(target.vertices - points[0], axis=1) > 0.03
    holed = type(target)(target.vertices, target.faces[whole_skin[target.faces].all(axis=1)])
    part = basis_of(Posterior(replace(fitted.task, target=holed), fitted.state.x)).observable
    assert not part.open[names.index("xiphoid")], "in a hole"


@pytest.mark.parametrize("deviation", [0.0, 0.03])
def test_places_lie_on_the_scan_and_the_breasts_narrow_from_check_to_check(
    deviation: float, torso: Rig, fitted: Posterior
) -> None:
    basis, known = basis_of(fitted, deviation), radii(fitted, size_deviation=deviation)
    np.testing.assert_array_equal(basis.places.radii, basis_of(fitted).places.radii)
    basis = read_basis(basis_bytes(basis), torso, fitted.state.x)
    gaps = np.linalg.norm(fitted.task.target.search.query(basis.places.points).points - basis.places.points, axis=1)
    assert gaps.max() < 1e-9
    vertices, widths = basis.widths([on_vertices(part) for part in planned_on(torso, known.seen)])
    before = basis.gaussian(fitted.state, vertices)
    now = widest(widths.radii(before.vertices))
    assert now == pytest.approx(known.lines, rel=1e-6), "the quantity that the fit states"
    narrowing = [now, *(check.width for check in next_checks(before, basis.observable, widths))]
    assert len(narrowing) == len(torso.landmark_names) - len(GIVEN) + 1
    assert (np.diff(narrowing) <= 1e-9).all()


def test_the_file_gives_the_basis_back_and_nothing_where_it_is_another_rigs_or_damaged(
    torso: Rig, fitted: Posterior
) -> None:
    basis, x = basis_of(fitted), fitted.state.x
    content = basis_bytes(basis)
    back = read_basis(content, torso, x)
    np.testing.assert_array_equal(back.covariance, basis.covariance)
    np.testing.assert_array_equal(back.once_picked, basis.once_picked)
    for part in ("points", "normals", "radii", "shown"):
        np.testing.assert_array_equal(getattr(back.places, part), getattr(basis.places, part))
    np.testing.assert_allclose(back.observable.replaced, basis.observable.replaced, rtol=1e-12, atol=1e-6)
    np.testing.assert_allclose(back.observable.beside, basis.observable.beside, rtol=1e-9, atol=1e-18)
    assert back.observable.partners == {k: each for k, each in basis.observable.partners.items() if each[1] > 0.0}
    assert (back.lost, back.observable.pick) == (basis.lost, basis.observable.pick)
    assert basis_bytes(None) == b""
    for wrong in (b"", content[:-8], content[:400] + np.array([np.nan]).tobytes() + content[408:]):
        assert read_basis(wrong, torso, x) is None
    other = forearm_rig()
    assert read_basis(content, other, x) is None

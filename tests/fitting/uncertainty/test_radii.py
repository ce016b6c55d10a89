"""The radii that hold nine of ten true places: they know what was picked, what was seen, and how much was given."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from helpers.rig_patient import patient
from helpers.torso_landmarks import LANDMARKS

from breastrig.drawings.line_error import ACROSS
from breastrig.fitting.checks.basis import basis_bytes, check_basis, read_basis
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.fitting.uncertainty.radii import Calibration, calibration, line_error, radii, seen_vertices, skin_factors
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose

NOT_PRONE = {"umbilicus", "acromion", "midclavicle"}  # what an MRI does not show


def without_sides(names: Iterable[str]) -> set[str]:
    return {name.removesuffix("_L").removesuffix("_R") for name in names}


def posterior_of(rig: Rig, names: tuple[str, ...] | None = None) -> Posterior:
    target, true, _ = patient(rig, 3)
    picks = true if names is None else {name: true[name] for name in names}
    task = FitTask(rig, target, start_from_landmarks(rig, true), load_recipe("default"), {}).with_picks(picks)
    return Posterior(task, list(fit_iterates(task))[-1].parameters)


@pytest.mark.slow
def test_variances_are_those_of_samples_of_the_posterior(torso: Rig) -> None:
    """Steps drawn from the Gaussian move vertices and landmarks as the variances say."""
    posterior = posterior_of(torso)
    rng = np.random.default_rng(1)
    draws = [posterior.state.x.retract(posterior.sample(rng)) for _ in range(300)]
    at_rest = posterior.state.vertices
    moved = np.array([pose(torso, x) for x in draws]) - at_rest
    spread = np.sqrt((moved**2).sum(axis=2).mean(axis=0))
    np.testing.assert_allclose(np.sqrt(posterior.vertex_variances()), spread, rtol=0.25)
    names = tuple(torso.landmark_names)
    points = torso.landmark_points(names)
    places = np.array([points.positions(pose(torso, x), torso.faces) for x in draws])
    spread = np.sqrt(((places - points.positions(at_rest, torso.faces)) ** 2).sum(axis=2).mean(axis=0))
    np.testing.assert_allclose(np.sqrt(posterior.landmark_variances(names)), spread, rtol=0.25)


@pytest.mark.slow
def test_a_picked_landmark_is_surer_than_one_that_was_not(torso: Rig) -> None:
    half = ("suprasternal_notch", "xiphoid", "nipple_R", "acromion_L")
    all_given, half_given = radii(posterior_of(torso)), radii(posterior_of(torso, half))
    for name in torso.landmark_names:
        if name not in half:
            assert all_given.landmarks[name] < half_given.landmarks[name], name
    assert set(half_given.landmarks) == set(torso.landmark_names)


def test_unseen_skin_is_less_sure_than_seen_skin(torso: Rig) -> None:
    posterior = posterior_of(torso)
    keep = posterior.task.target.vertices[:, 2] > np.median(posterior.task.target.vertices[:, 2])
    half = posterior.task.target
    faces = half.faces[keep[half.faces].all(axis=1)]
    cut = type(half)(half.vertices, faces)
    task = FitTask(torso, cut, posterior.state.x, load_recipe("default"), {})
    seen = seen_vertices(posterior)
    assert seen.mean() > 0.98, "the patient's scan shows all of her"
    known = radii(Posterior(task, posterior.state.x))
    whole = radii(Posterior(FitTask(torso, half, posterior.state.x, load_recipe("default"), {}), posterior.state.x))
    back = torso.regions["back"]
    assert known.vertices[back].mean() > whole.vertices[back].mean()
    assert (known.vertices > 0.0).all()


@pytest.mark.parametrize("stance", ["standing", "supine", "prone"])
def test_every_landmark_and_region_of_the_torso_has_its_factors(stance: str, torso: Rig) -> None:
    known = calibration(torso)
    found = known.of_stance(stance)
    for landmarks in (found.given, found.others, found.alone, found.proposed):
        assert without_sides(LANDMARKS) - NOT_PRONE <= set(landmarks) <= without_sides(torso.landmark_names) | {"other"}
    for regions in (found.seen, found.hidden, found.seen_alone, found.hidden_alone):
        assert "breast" in regions
        assert set(regions) <= without_sides(torso.regions) | {"other"}


def test_without_landmarks_everything_is_less_sure_and_least_where_the_body_may_lie_another_way(torso: Rig) -> None:
    given = posterior_of(torso)
    task = FitTask(torso, given.task.target, given.state.x, load_recipe("default"), {})
    alone = Posterior(task, given.state.x)
    with_picks, clear, unclear = radii(given), radii(alone, 0.2), radii(alone, 0.0)
    known = calibration(read_rig(default_rig_path()))
    for name in torso.landmark_names:
        assert with_picks.landmarks[name] < clear.landmarks[name] < 0.1, name
        assert unclear.landmarks[name] > known.without_picks.astray, name
    assert (unclear.vertices > known.without_picks.astray).all()


def test_of_another_model_nothing_is_said(torso: Rig) -> None:
    assert calibration(replace(torso, known={})) is None


def test_a_calibrated_rig_without_landmarks_has_radii_of_its_skin(torso: Rig) -> None:
    target, true, _ = patient(torso, 3)
    task = FitTask(replace(torso, landmarks=()), target, start_from_landmarks(torso, true), load_recipe("default"), {})
    posterior = Posterior(task, list(fit_iterates(task))[-1].parameters)
    found = radii(posterior)
    assert (found.landmarks, found.joint.shape) == ({}, (0, 0))
    assert (found.vertices > 0.0).all()
    basis = check_basis(posterior, found, {}, ())
    read = read_basis(basis_bytes(basis), task.rig, posterior.state.x)
    assert (read.observable.names, read.places.points.shape) == ((), (0, 3))
    np.testing.assert_array_equal(read.covariance, posterior.covariance())


def test_lines_are_as_far_off_as_seen_skin_of_the_breast_of_which_less_is_known(torso: Rig) -> None:
    left, right = (np.array(torso.regions[f"breast_{side}"]) for side in "LR")
    everything = np.ones(len(torso.template), dtype=np.bool_)
    for less, more in ((left, right), (right, left)):
        far, seen = np.full(len(torso.template), 0.05), everything.copy()
        far[more], far[less[::2]], far[less[1::2]] = 0.004, 0.006, 0.010
        spread = float(np.sqrt(np.mean(far[less] ** 2)))
        assert line_error(torso, far, seen) == pytest.approx(ACROSS * spread)
        seen[less[1::2]] = False
        assert line_error(torso, far, seen) == pytest.approx(ACROSS * 0.006)
        seen[less] = False
        assert line_error(torso, far, seen) == pytest.approx(ACROSS * 0.004)
    one = replace(torso, regions={"breast_L": torso.regions["breast_L"]})
    far[left] = 0.003
    assert line_error(one, far, everything) == pytest.approx(ACROSS * 0.003)
    none = replace(torso, regions={})
    assert line_error(none, far, everything) == pytest.approx(ACROSS * float(np.sqrt(np.mean(far**2))))


def test_careful_picks_say_nothing_of_skin_that_the_scan_does_not_show(
    torso: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    posterior, far = posterior_of(torso), {}
    for scatter in (0.5, 1.0, 2.0):
        monkeypatch.setattr(Calibration, "enlarged", lambda *_, found=scatter, **__: found)
        known = radii(posterior)
        far[scatter] = known.vertices
    seen = seen_vertices(posterior)
    np.testing.assert_allclose(far[0.5][seen], 0.5 * far[1.0][seen])
    np.testing.assert_allclose(far[0.5][~seen], far[1.0][~seen])
    np.testing.assert_allclose(far[2.0], 2.0 * far[1.0])


def test_skin_has_the_factor_of_its_region_as_it_is_seen_or_not(torso: Rig) -> None:
    posterior, known = posterior_of(torso), calibration(torso)
    factors, count = known.of_stance("standing"), len(torso.template)
    often = np.bincount(np.concatenate([*torso.regions.values()]), minlength=count)
    kinds = {"back": torso.regions["back"], "arm": torso.regions["arm_R"], "other": np.flatnonzero(often == 0)}
    for is_seen, of_skin in ((True, factors.seen), (False, factors.hidden)):
        found = skin_factors(posterior, factors, np.full(count, is_seen))
        for name, vertices in kinds.items():
            assert found[vertices[often[vertices] <= 1]] == pytest.approx(of_skin[name])

"""The radii that hold nine of ten true places: they know what was picked, what was seen, and how much was given."""

import numpy as np
import pytest
from helpers.rig_patient import patient

from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.orientation import start_from_landmarks
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.uncertainty.calibration import calibration
from breastrig.fitting.uncertainty.radii import radii, seen_vertices
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose


@pytest.fixture(scope="module")
def torso() -> Rig:
    return read_rig(default_rig_path())


def posterior_of(rig: Rig, names: tuple[str, ...] | None = None) -> Posterior:
    target, true, _ = patient(rig, 3)
    picks = true if names is None else {name: true[name] for name in names}
    task = FitTask(rig, target, start_from_landmarks(rig, true), load_recipe("default"), picks)
    return Posterior(task, list(fit_iterates(task))[-1].parameters)


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


def test_a_picked_landmark_is_surer_than_one_that_was_not(torso: Rig) -> None:
    half = ("suprasternal_notch", "xiphoid", "nipple_R", "acromion_L")
    all_given, half_given = radii(posterior_of(torso)), radii(posterior_of(torso, half))
    assert all_given is not None
    assert half_given is not None
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
    assert known is not None
    assert whole is not None
    back = torso.regions["back"]
    assert known.vertices[back].mean() > whole.vertices[back].mean()
    assert (known.vertices > 0.0).all()


def test_every_landmark_and_region_of_the_torso_is_calibrated(torso: Rig) -> None:
    known = calibration("torso")
    assert known is not None
    assert {name.removesuffix("_L").removesuffix("_R") for name in torso.landmark_names} < set(known.landmarks)
    assert {name.removesuffix("_L").removesuffix("_R") for name in torso.regions} < set(known.regions)
    assert set(known.hanging) < set(known.landmarks)


def test_without_landmarks_everything_is_less_sure_and_least_where_the_body_may_lie_another_way(torso: Rig) -> None:
    given = posterior_of(torso)
    task = FitTask(torso, given.task.target, given.state.x, load_recipe("default"), {})
    alone = Posterior(task, given.state.x)
    with_picks, clear, unclear = radii(given), radii(alone, 0.2), radii(alone, 0.0)
    assert with_picks is not None
    assert clear is not None
    assert unclear is not None
    known = calibration("torso")
    assert known is not None
    for name in torso.landmark_names:
        assert with_picks.landmarks[name] < clear.landmarks[name] < 0.1, name
        assert unclear.landmarks[name] > known.without_picks.astray, name
    assert (unclear.vertices > known.without_picks.astray).all()


def test_every_landmark_without_picks_is_calibrated(torso: Rig) -> None:
    known = calibration("torso")
    assert known is not None
    names = {name.removesuffix("_L").removesuffix("_R") for name in torso.landmark_names}
    assert names | {"other"} == set(known.without_picks.landmarks)


def test_of_another_model_nothing_is_said() -> None:
    assert calibration("somebody") is None

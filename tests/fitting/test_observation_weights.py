"""The fit does not ask how finely its model is meshed: a finer one, all over or in places, gives the same body."""

import numpy as np
import pytest
from helpers.finer_rig import finer
from helpers.rig_patient import patient

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import FitTask, fit_iterates, observation_weights
from breastrig.fitting.recipe import Observations, Recipe, load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.geometry.normals import face_areas
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose

pytestmark = pytest.mark.long

SAME = 0.1e-3  # m
SLID = 0.25e-3  # m, single landmarks along smooth skin, where little holds them


@pytest.fixture(scope="module")
def settings() -> Observations:
    observations = load_recipe("default").observations
    assert observations is not None
    return observations


def left_half(rig: Rig) -> np.ndarray:
    return np.asarray(rig.template[rig.faces].mean(axis=1)[:, 0] > 0.0)


def places(rig: Rig, target: ScanTarget, landmarks: dict[str, Array], recipe: Recipe) -> tuple[Array, Array]:
    """The vertices and landmarks of the rig as fitted, (V, 3) and (L, 3) m."""
    task = FitTask(rig, target, start_from_landmarks(rig, landmarks), recipe, {}).with_picks(landmarks)
    vertices = pose(rig, list(fit_iterates(task))[-1].parameters)
    return vertices, rig.landmark_points().positions(vertices, rig.faces)


def apart(first: Array, second: Array, rig: Rig) -> Array:
    """(V,) m from the vertices that both rigs have, as the second is fitted, to the first's surface."""
    return ScanTarget(first, rig.faces).search.query(second[: len(rig.template)]).distances


def assert_same_body(first: tuple[Array, Array], second: tuple[Array, Array], rig: Rig) -> None:
    """Likewise, nearly everywhere, and the landmarks are at the same places."""
    off = apart(first[0], second[0], rig)
    assert off.mean() < SAME, f"{1e3 * off.mean():.3f} mm"
    assert np.percentile(off, 95) < 2.0 * SAME
    moved = np.linalg.norm(first[1] - second[1], axis=1)
    assert moved.mean() < SAME, f"{1e3 * moved.mean():.3f} mm"
    assert moved.max() < SLID, f"{1e3 * moved.max():.3f} mm"


@pytest.mark.slow
def test_a_rig_subdivided_on_one_side_fits_as_the_original(torso: Rig) -> None:
    target, landmarks, _ = patient(torso, 0, smooth=True)
    recipe = load_recipe("default")
    original = places(torso, target, landmarks, recipe)
    other = finer(torso, left_half(torso))
    assert len(other.template) > 1.4 * len(torso.template)
    assert_same_body(original, places(other, target, landmarks, recipe), torso)


def test_every_second_vertex_fits_as_all(torso: Rig) -> None:
    target, landmarks, _ = patient(torso, 0)
    recipe = load_recipe("default")
    last = recipe.stages[-1].model_copy(update={"every": 2})
    halved = recipe.model_copy(update={"stages": (*recipe.stages[:-1], last)})
    assert_same_body(places(torso, target, landmarks, recipe), places(torso, target, landmarks, halved), torso)


def test_a_finer_mesh_counts_the_same_in_all_and_on_the_breasts(torso: Rig, settings: Observations) -> None:
    coarse = observation_weights(torso, settings, 1)
    for other in (finer(torso), finer(torso, left_half(torso))):
        weights = observation_weights(other, settings, 1)
        assert weights.sum() == pytest.approx(coarse.sum(), rel=0.005)
        for name in ("breast_L", "breast_R"):  # with half of the triangles that their outlines cut
            assert weights[other.regions[name]].sum() == pytest.approx(coarse[torso.regions[name]].sum(), rel=0.05)


@pytest.mark.parametrize("every", [2, 3, 5])
def test_the_vertices_of_a_stage_stand_for_those_left_out(every: int, torso: Rig, settings: Observations) -> None:
    everyone, few = (observation_weights(torso, settings, n) for n in (1, every))
    assert few.sum() == pytest.approx(everyone.sum())
    chosen = np.arange(len(few)) % every == 0
    assert (few[~chosen] == 0.0).all()
    assert (few[chosen] > 0.0).all()
    for vertices in torso.regions.values():
        if len(vertices) > 300:
            assert few[vertices].sum() == pytest.approx(everyone[vertices].sum(), rel=0.1)


def test_on_the_built_model_most_vertices_count_about_once(torso: Rig, settings: Observations) -> None:
    """Its vertices are spaced as the preset spaces observations, so the figures of the preset hold for it."""
    weights = observation_weights(torso, settings, 1)
    assert weights.mean() == pytest.approx(1.2, abs=0.05)
    assert np.quantile(weights, 0.1) > 0.5
    assert np.quantile(weights, 0.9) < 1.8


def test_regions_that_a_rig_lacks_leave_one_spacing_for_all(toy_rig: Rig) -> None:
    settings = Observations(spacing=0.02, focus=("hand_L",), focus_spacing=0.005)
    total = face_areas(toy_rig.template, toy_rig.faces).sum() / 0.02**2
    assert observation_weights(toy_rig, settings, 1).sum() == pytest.approx(total)


def test_without_settings_every_vertex_counts_once(toy_rig: Rig) -> None:
    assert load_recipe("paper").observations is None  # equation 7 is a plain sum
    np.testing.assert_array_equal(observation_weights(toy_rig, None, 1), 1.0)
    assert observation_weights(toy_rig, None, 4).sum() == len(toy_rig.template)

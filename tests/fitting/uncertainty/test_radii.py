"""The radii that hold nine of ten true places: they know what was picked, what was seen, and how much was given."""

from collections.abc import Iterable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from helpers.rig_patient import patient

from breastrig.core.arrays import Array
from breastrig.fitting.body.hanging import hanging_shifts
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.fitting.uncertainty import radii as radii_module
from breastrig.fitting.uncertainty.calibration import calibration
from breastrig.fitting.uncertainty.radii import HOLDS_90, line_error, radii, seen_vertices, vertex_misfit
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose
from breastrig.rig.validation.torso import LANDMARKS


@pytest.fixture(scope="module")
def torso() -> Rig:
    return read_rig(default_rig_path())


def without_sides(names: Iterable[str]) -> set[str]:
    return {name.removesuffix("_L").removesuffix("_R") for name in names}


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
    known = calibration(read_rig(default_rig_path()))
    assert known is not None
    assert without_sides(LANDMARKS) <= set(known.landmarks) <= without_sides(torso.landmark_names) | {"other"}
    assert without_sides(torso.regions) < set(known.regions)
    assert set(known.hanging) < set(known.landmarks)
    assert set(known.hanging_regions) < set(known.regions)


def radii_with_and_without(
    monkeypatch: pytest.MonkeyPatch, task: FitTask, weights: dict[str, float]
) -> tuple[Array, Array]:
    """(V,) m each: of the start with these weights, and as if skin of hanging breasts were as well known as other."""
    x, names = task.start, task.rig.shape_names
    changed = x.weights.copy()
    for name, weight in weights.items():
        changed[names.index(name)] = weight
    posterior = Posterior(task, replace(x, weights=changed))
    known = calibration(read_rig(default_rig_path()))
    assert known is not None
    found = []
    for regions in (known.hanging_regions, {}):
        as_if = known.model_copy(update={"hanging_regions": regions})
        monkeypatch.setattr(radii_module, "calibration", lambda _, as_if=as_if: as_if)
        all_radii = radii(posterior)
        assert all_radii is not None
        found.append(all_radii.vertices)
    return found[0], found[1]


def test_skin_of_a_breast_that_hangs_is_less_sure_and_no_other_skin(
    torso: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = calibration(read_rig(default_rig_path()))
    assert known is not None
    picked = posterior_of(torso, ("suprasternal_notch", "xiphoid", "acromion_L")).task
    left, right, chest = (torso.regions[name] for name in ("breast_L", "breast_R", "chest"))
    of_left = np.isin(np.arange(len(torso.template)), np.union1d(left, torso.regions["areola_L"]))
    hangs = {"ptosis_L": 2.5, "ptosis_R": 0.0}
    grown, before = radii_with_and_without(monkeypatch, picked, hangs)
    assert np.array_equal(grown[~of_left], before[~of_left])
    more = HOLDS_90 * known.hanging_regions["breast"].shown * 2.5
    np.testing.assert_allclose(grown[left], np.hypot(before[left], more))
    alone = replace(picked, landmarks={})
    assert np.array_equal(*radii_with_and_without(monkeypatch, alone, hangs)), "the weight alone does not tell"
    grown, before = radii_with_and_without(monkeypatch, replace(alone, hanging=("ptosis_L",)), hangs)
    more = HOLDS_90 * known.hanging_regions["breast"].without_picks * 2.5
    np.testing.assert_allclose(grown[left], np.hypot(before[left], more))
    only_chest = np.setdiff1d(chest, np.concatenate([left, right]))
    more = HOLDS_90 * known.hanging_regions["chest"].without_picks * 1.25
    np.testing.assert_allclose(grown[only_chest], np.hypot(before[only_chest], more))


def test_radii_of_breasts_that_do_not_hang_are_what_they_were(torso: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    picked = posterior_of(torso, ("suprasternal_notch", "xiphoid", "acromion_L")).task
    for task in (picked, replace(picked, landmarks={}, hanging=("ptosis_L", "ptosis_R"))):
        for weight in (1.0, 0.0, -1.0):
            weights = {"ptosis_L": weight, "ptosis_R": weight}
            assert np.array_equal(*radii_with_and_without(monkeypatch, task, weights))


def test_without_landmarks_everything_is_less_sure_and_least_where_the_body_may_lie_another_way(torso: Rig) -> None:
    given = posterior_of(torso)
    task = FitTask(torso, given.task.target, given.state.x, load_recipe("default"), {})
    alone = Posterior(task, given.state.x)
    with_picks, clear, unclear = radii(given), radii(alone, 0.2), radii(alone, 0.0)
    assert with_picks is not None
    assert clear is not None
    assert unclear is not None
    known = calibration(read_rig(default_rig_path()))
    assert known is not None
    for name in torso.landmark_names:
        assert with_picks.landmarks[name] < clear.landmarks[name] < 0.1, name
        assert unclear.landmarks[name] > known.without_picks.astray, name
    assert (unclear.vertices > known.without_picks.astray).all()


def test_every_landmark_without_picks_is_calibrated(torso: Rig) -> None:
    known = calibration(read_rig(default_rig_path()))
    assert known is not None
    found = set(known.without_picks.landmarks)
    assert without_sides(LANDMARKS) <= found <= without_sides(torso.landmark_names) | {"other"}


def test_of_another_model_nothing_is_said(torso: Rig) -> None:
    assert calibration(replace(torso, known={})) is None


def test_lines_are_as_far_off_as_seen_skin_of_the_breast_of_which_less_is_known(torso: Rig) -> None:
    left, right = (np.array(torso.regions[f"breast_{side}"]) for side in "LR")
    everything = np.ones(len(torso.template), dtype=np.bool_)
    for less, more in ((left, right), (right, left)):
        far, seen = np.full(len(torso.template), 0.05), everything.copy()
        far[more], far[less[::2]], far[less[1::2]] = 0.004, 0.006, 0.010
        spread = float(np.sqrt(np.mean(far[less] ** 2)))
        assert line_error(torso, far, seen) == pytest.approx(spread)
        seen[less[1::2]] = False
        assert line_error(torso, far, seen) == pytest.approx(0.006)
        seen[less] = False
        assert line_error(torso, far, seen) == pytest.approx(0.004)
    one = replace(torso, regions={"breast_L": torso.regions["breast_L"]})
    far[left] = 0.003
    assert line_error(one, far, everything) == pytest.approx(0.003)
    none = replace(torso, regions={})
    assert line_error(none, far, everything) == pytest.approx(float(np.sqrt(np.mean(far**2))))


def test_careful_picks_say_nothing_of_skin_that_the_scan_does_not_show(
    torso: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    posterior, far = posterior_of(torso), {}
    for scatter in (0.5, 1.0, 2.0):
        monkeypatch.setattr(radii_module, "_scatter", lambda *_, found=scatter: found)
        known = radii(posterior)
        assert known is not None
        far[scatter] = known.vertices
    seen = seen_vertices(posterior)
    np.testing.assert_allclose(far[0.5][seen], 0.5 * far[1.0][seen])
    np.testing.assert_allclose(far[0.5][~seen], far[1.0][~seen])
    np.testing.assert_allclose(far[2.0], 2.0 * far[1.0])


def test_skin_is_as_far_off_as_its_region_where_it_is_seen_and_where_it_is_not(torso: Rig) -> None:
    known = calibration(torso)
    assert known is not None
    count = len(torso.template)
    regions = np.bincount(np.concatenate([*torso.regions.values()]), minlength=count)
    kinds = {"back": torso.regions["back"], "arm": torso.regions["arm_R"], "other": np.flatnonzero(regions == 0)}
    posterior: Any = SimpleNamespace(rig=torso, task=SimpleNamespace(rig=torso))
    for is_seen in (True, False):
        seen = np.full(count, is_seen)
        found = vertex_misfit(posterior, known, seen)
        for name, vertices in kinds.items():
            expected = known.region(name)
            assert found[vertices[regions[vertices] <= 1]] == pytest.approx(
                expected.shown if is_seen else expected.hidden
            )
            assert expected.shown < expected.hidden


def test_a_radius_around_the_model_grows_by_half_of_the_way_to_where_the_landmark_is_expected(torso: Rig) -> None:
    task = posterior_of(torso, ("suprasternal_notch", "xiphoid", "acromion_L")).task
    weights = task.start.weights.copy()
    weights[torso.shape_names.index("ptosis_R")] = 2.5
    posterior = Posterior(task, replace(task.start, weights=weights))
    around, expected = (radii(posterior, expected=each) for each in (False, True))
    assert around is not None
    assert expected is not None
    names = torso.landmark_names
    shifts = np.linalg.norm(hanging_shifts(posterior.state, task, names), axis=1)
    moved = {name: shift for name, shift in zip(names, shifts, strict=True) if shift}
    assert "inframammary_fold_R" in moved
    assert "inframammary_fold_L" not in moved
    for name in names:
        grown = around.landmarks[name] - expected.landmarks[name]
        assert grown == pytest.approx(0.5 * moved.get(name, 0.0), abs=1e-9)

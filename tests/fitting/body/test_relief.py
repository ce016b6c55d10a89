"""A fit without picks slides along smooth skin; what the skin's hollows show holds its landmarks."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from breastrig.core.arrays import Array
from breastrig.core.assets import asset_folder
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import fit_iterates
from breastrig.fitting.hypotheses import scan_orientation
from breastrig.fitting.posterior import LeaveOneOut, Posterior
from breastrig.fitting.prepare_scan import prepared
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.fitting.task import FitIterate, FitTask, ended
from breastrig.fitting.uncertainty.radii import radii
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.skinning import pose
from breastrig.scan.clean import clean, compact
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.read import read_scan
from breastrig_studies.virtual.bodies import read_bodies
from breastrig_studies.virtual.warped.body import breast_region, filled

pytestmark = pytest.mark.long

STANDING = asset_folder("example") / "standing"
HOLLOWS = {"umbilicus", "suprasternal_notch", "inframammary_fold_L", "inframammary_fold_R"}
TIPS = {"acromion_L", "acromion_R"}
SHOULDERS = TIPS | {"midclavicle_L", "midclavicle_R"}


@pytest.fixture(scope="module")
def task() -> FitTask:
    """The standing example without picks."""
    scan = read_scan(STANDING / "scan.ply", "ply", "auto", texture=False)
    return scan_orientation(read_rig(default_rig_path()), prepared(clean(scan), "auto"), load_recipe("default"))[1]


@pytest.fixture(scope="module")
def true() -> dict[str, Array]:
    """(3,) m, by name."""
    places, unit = read_landmarks(STANDING / "landmarks.json")
    return {name: {"mm": 1e-3, "m": 1.0}[str(unit)] * np.array(place) for name, place in places.items()}


def end(task: FitTask) -> FitIterate:
    *_, last = fit_iterates(task)
    return last


def errors(task: FitTask, last: FitIterate, true: Mapping[str, Array]) -> dict[str, float]:
    """m, by name."""
    points = task.rig.landmark_points(tuple(true)).positions(pose(task.rig, last.parameters), task.rig.faces)
    return {name: float(np.linalg.norm(point - true[name])) for name, point in zip(true, points, strict=True)}


@pytest.mark.slow
def test_hollows_bring_landmarks_nearer_without_bending_the_surface(task: FitTask, true: dict[str, Array]) -> None:
    with_them, without = end(task), end(replace(task, relief={}))
    assert set(with_them.relief or {}) == HOLLOWS | TIPS
    seen, smooth = errors(task, with_them, true), errors(task, without, true)
    assert seen["umbilicus"] < 0.7 * smooth["umbilicus"]
    assert np.mean(list(seen.values())) < np.mean(list(smooth.values()))
    assert with_them.mean_distance < without.mean_distance + 1e-4  # m
    assert with_them.landmark_distance is None  # nobody has picked any


def test_tips_of_hanging_shoulders_are_seen(task: FitTask) -> None:
    last = end(task)
    assert all(last.relief[name].is_place for name in TIPS)
    points = task.rig.landmark_points(tuple(TIPS)).positions(pose(task.rig, last.parameters), task.rig.faces)
    for name, point in zip(TIPS, points, strict=True):  # the fit follows them
        assert np.linalg.norm(point - last.relief[name].place) < last.relief[name].error


def test_before_the_form_is_found_no_hollow_is_looked_for(task: FitTask) -> None:
    *_, shape = (iterate for iterate in fit_iterates(task) if iterate.stage == "shape")
    assert shape.relief is None
    assert end(replace(task, recipe=load_recipe("paper"))).relief is None


def test_what_a_person_picked_is_not_looked_for(task: FitTask, true: dict[str, Array]) -> None:
    picked = {name: true[name] for name in ("umbilicus", "nipple_L", "nipple_R", "acromion_L")}
    *_, last = checked_iterates(task.with_picks(picked))
    assert set(last.relief or {}) == HOLLOWS - {"umbilicus"} | {"acromion_R"}  # the shoulder's tip that is not picked
    assert errors(task, last, true)["umbilicus"] < 0.004
    posterior = Posterior(ended(task.with_picks(picked), last), last.parameters)
    assert set(LeaveOneOut(posterior).names) == set(picked)  # nobody is asked about a hollow


def test_hollows_help_the_landmarks_that_a_person_left_out(task: FitTask, true: dict[str, Array]) -> None:
    half = task.with_picks({name: true[name] for name in ("suprasternal_notch", "xiphoid", "nipple_R")})
    seen, smooth = (errors(half, end(each), true) for each in (half, replace(half, relief={})))
    assert seen["umbilicus"] < 0.7 * smooth["umbilicus"]


def test_a_landmark_in_a_hollow_is_better_known(task: FitTask) -> None:
    last = end(task)
    known = radii(Posterior(replace(task, relief=last.relief), last.parameters))
    smooth = radii(Posterior(replace(task, relief={}), last.parameters))
    assert known.landmarks["umbilicus"] < 0.6 * smooth.landmarks["umbilicus"]
    fold = known.landmarks["inframammary_fold_L"]  # where along the fold, nobody has seen
    assert 0.7 * smooth.landmarks["inframammary_fold_L"] < fold <= smooth.landmarks["inframammary_fold_L"]


def test_what_was_seen_once_is_not_looked_for_again(task: FitTask) -> None:
    last = end(task)
    posterior = Posterior(replace(task, relief=last.relief), last.parameters)
    assert posterior.relief is last.relief
    assert posterior.relief["umbilicus"] is (last.relief or {})["umbilicus"]


@pytest.mark.slow
def test_where_a_breast_was_taken_off_her_fold_is_hardly_ever_seen(task: FitTask) -> None:
    """On the left side of three women; the other fold is seen on all."""
    cohort, seen = read_bodies(), {"inframammary_fold_L": 0, "inframammary_fold_R": 0}
    for number in (2, 4, 6):
        body = next(body for body in cohort.patients[number].bodies if body.stance == "standing")
        nipple, fold = body.landmarks["nipple_L"], body.landmarks["inframammary_fold_L"]
        flat = filled(body.vertices, cohort.faces, breast_region(body.vertices, cohort.faces, nipple, fold, 0.0))
        shown = cohort.faces[(cohort.scanned & (flat[:, 2] > -0.02))[cohort.faces].all(axis=1)]
        vertices, faces = trimesh.remesh.subdivide(*compact(flat, shown))  # as near each other as a scan's
        start = start_from_landmarks(task.rig, body.landmarks)
        noise = 0.001 * np.random.default_rng(0).normal(size=vertices.shape)
        relief = end(replace(task, target=ScanTarget(vertices + noise, np.asarray(faces)), start=start)).relief
        for name in seen:
            seen[name] += name in (relief or {})
    assert seen["inframammary_fold_L"] <= 1
    assert seen["inframammary_fold_R"] == 3

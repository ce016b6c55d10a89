"""One virtual patient, made as `breastrig evaluate --virtual` makes all: read, judged against her truth, and fitted."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from breastrig.core.units import METRES_PER_UNIT
from breastrig.correspondence.distances import surface_distances
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.skinning import pose
from breastrig.scan.clean import clean
from breastrig.scan.read import read_scan
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.virtual import make, make_cohort
from breastrig_studies.virtual.bodies import Bodies, VirtualBody, read_bodies
from breastrig_studies.virtual.scan import Circumstances, SimulatedScan, scan_skin

pytestmark = pytest.mark.long

PATIENT = "patient_5"  # the asymmetric one


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Scanned coarsely and from half of the places."""
    made = tmp_path_factory.mktemp("virtual")

    def half_coarse(bodies: Bodies, body: VirtualBody, random: np.random.Generator) -> SimulatedScan:
        return scan_skin(body, bodies.faces, bodies.scanned, random, Circumstances(voxel=0.008, every=2))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(make, "scan_body", half_coarse)
        make_cohort(made, lambda _: None, [PATIENT])
    return made


@pytest.fixture(scope="module", params=["standing", "supine"])
def case(folder: Path, request: pytest.FixtureRequest) -> Case:
    return next(case for case in read_cohort(folder) if case.name == request.param)


def mesh(path: Path, unit: str) -> tuple[np.ndarray, np.ndarray]:
    """(V, 3) m, (F, 3)."""
    found = trimesh.load(path, process=False)
    return METRES_PER_UNIT[unit] * np.asarray(found.vertices), np.asarray(found.faces)


def landmarks(case: Case) -> dict[str, np.ndarray]:
    """m, in the scan's frame."""
    content = json.loads((case.folder / "landmarks.json").read_text("utf-8"))
    assert content["unit"] == case.unit
    return {name: METRES_PER_UNIT[case.unit] * np.array(place) for name, place in content["landmarks"].items()}


def test_it_is_a_cohort_of_makehumans_family_in_both_units(folder: Path) -> None:
    cases = read_cohort(folder)
    assert [(case.patient, case.stance, case.family) for case in cases] == [
        (PATIENT, "standing", "makehuman"),
        (PATIENT, "supine", "makehuman"),
    ]
    assert {case.unit for case in cases} == {"m", "mm"}
    about = json.loads((folder / PATIENT / "patient.json").read_text("utf-8"))
    assert about["virtual"] is True
    assert (about["band"], about["cup"], about["marked_asymmetry"]) == (100, "C", True)


def test_the_scan_is_near_the_truth_but_not_on_it(case: Case) -> None:
    scan, _ = mesh(case.folder / "scan.ply", case.unit)
    truth, faces = mesh(case.folder / "truth.ply", case.unit)
    away = ClosestPointSearch(truth, faces).query(scan).distances
    skin = away < 0.01  # the rest is the table
    assert 0.0004 < away[skin].mean() < 0.0015
    assert skin.mean() > (0.97 if case.stance == "standing" else 0.5)


def test_true_landmarks_lie_on_the_true_skin_and_the_case_says_how_far_the_scan_is(case: Case) -> None:
    places = landmarks(case)
    scan, _ = mesh(case.folder / "scan.ply", case.unit)
    truth, faces = mesh(case.folder / "truth.ply", case.unit)
    assert ClosestPointSearch(truth, faces).query(np.array(list(places.values()))).distances.max() < 1e-5
    said = json.loads((case.folder / "case.json").read_text("utf-8"))["landmark_gap_mm"]
    for name, place in places.items():
        assert said[name] == pytest.approx(1e3 * np.linalg.norm(scan - place, axis=1).min(), abs=0.06)
    assert np.median(list(said.values())) < 5.0


def test_the_case_says_where_the_body_is(case: Case) -> None:
    placed = np.array(json.loads((case.folder / "case.json").read_text("utf-8"))["body_mm_to_scan"])
    body = next(b for p in read_bodies().patients if p.name == PATIENT for b in p.bodies if b.stance == case.stance)
    truth, _ = mesh(case.folder / "truth.ply", "m")
    expected = 1e3 * body.vertices @ placed[:3, :3].T + placed[:3, 3]
    np.testing.assert_allclose(truth, expected, atol=1e-4 * METRES_PER_UNIT["mm"] / METRES_PER_UNIT[case.unit])
    turn = placed[:3, :3] * 1e3 * METRES_PER_UNIT[case.unit]
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(turn) > 0.0  # never mirrored


def test_she_is_fitted_well(case: Case) -> None:
    rig = read_rig(default_rig_path())
    surface = clean(read_scan(case.folder / "scan.ply", None, case.unit, texture=False))
    centre = surface.vertices.mean(axis=0)
    target = ScanTarget(surface.vertices - centre, surface.faces)
    given = {name: place - centre for name, place in landmarks(case).items()}
    task = FitTask(
        rig,
        target,
        start_from_landmarks(rig, given),
        load_recipe("default"),
        {},
        case.stance,
    ).with_picks(given)
    fitted = pose(rig, list(fit_iterates(task))[-1].parameters)
    assert np.nanmean(surface_distances(target, fitted, rig.faces).model) < 0.0015
    truth, faces = mesh(case.folder / "truth.ply", case.unit)
    seen = target.vertex_tree.query(fitted)[0] < 0.01
    assert ClosestPointSearch(truth - centre, faces).query(fitted[seen]).distances.mean() < 0.002

"""Two visits of the model as a patient: what changed is said, what did not change is not."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.subdivide import subdivided
from scipy.spatial.transform import Rotation

from breastrig.core.arrays import Array
from breastrig.core.errors import BadInput
from breastrig.geometry.normals import vertex_normals
from breastrig.report.measures import measures
from breastrig.report.stance import Stance
from breastrig.report.visits.alignment import aligned, on_breasts, untouched
from breastrig.report.visits.change import Change, change_between, visit_calibration
from breastrig.report.visits.symmetry import symmetry_rows
from breastrig.report.volume import enclosed_volume, vertices_within
from breastrig.rig.model import Rig

TURN = Rotation.from_euler("xyz", (20.0, 140.0, -35.0), degrees=True).as_matrix()
SHIFT = np.array([0.4, -0.2, 1.1])


def visit(rig: Rig, vertices: Array) -> Stance:
    """A fit that lies on its scan exactly, in a frame of the scan's own."""
    placed = vertices @ TURN.T + SHIFT
    return Stance(rig, placed, *subdivided(placed, rig.faces), "standing")


def larger(rig: Rig, height: float) -> Array:
    """The template with a bell of this height (m) on the left nipple."""
    nipple = rig.landmark_points(("nipple_L",)).positions(rig.template, rig.faces)[0]
    bell = height * np.exp(-0.5 * ((rig.template - nipple) ** 2).sum(axis=1) / 0.02**2)
    return rig.template + bell[:, None] * vertex_normals(rig.template, rig.faces)


def gained(found: Change, side: str) -> tuple[float, float]:
    """ml, and half of its band."""
    value = found.volume(side)
    assert value is not None
    assert value.margin is not None
    return value.value, value.margin


def noise(rig: Rig, seed: int) -> Array:
    """(V,) m of a depth camera's drift: smooth over some 50 mm, 1 mm."""
    random = np.random.default_rng(seed)
    centres, sizes = random.choice(rig.template, 600), random.standard_normal(600)
    bells = np.exp(-0.5 * ((rig.template[:, None] - centres) ** 2).sum(axis=2) / 0.025**2)
    return 1e-3 * (bells @ sizes) / np.linalg.norm(bells, axis=1)


def test_a_body_that_moved_has_not_changed(rig: Rig, at_rest: Stance) -> None:
    later = visit(rig, rig.template)
    found = change_between(at_rest, later)
    assert np.abs(found.alignment.moved(later.vertices) - at_rest.vertices).max() < 1e-5
    assert np.nanmax(np.abs(found.along)) < 1e-4
    assert np.isfinite(found.along[on_breasts(rig)]).mean() > 0.95
    assert not found.said.any()
    for side in "LR":
        value, margin = gained(found, side)
        assert abs(value) < min(1.0, margin)


def test_a_bell_on_one_breast_is_measured_in_mm_and_ml(rig: Rig, at_rest: Stance) -> None:
    vertices = larger(rig, 0.012)
    found = change_between(at_rest, visit(rig, vertices))
    true = np.einsum("vi,vi->v", vertices - rig.template, vertex_normals(rig.template, rig.faces))
    assert np.nanmax(np.abs(found.along - true)) < 1.5e-3  # both ends of a way have different normals
    assert (found.along[found.said] > 0.0).all()
    assert np.nanmax(found.along) == pytest.approx(0.012, abs=3e-4)
    ml = 1e6 * (enclosed_volume(vertices, rig.faces) - enclosed_volume(rig.template, rig.faces))
    assert gained(found, "L")[0] == pytest.approx(ml, rel=0.03)
    assert abs(gained(found, "R")[0]) < 1.0


def test_what_an_operation_moved_does_not_move_the_alignment(rig: Rig, at_rest: Stance) -> None:
    """A fifth of the skin around the breasts is 10 mm farther out, as after an operation of the axilla."""
    beside = untouched(rig)
    out = beside[np.argsort(-rig.template[beside, 0])[: len(beside) // 5]]
    vertices = rig.template.copy()
    vertices[out] += 0.01 * vertex_normals(rig.template, rig.faces)[out]
    later = visit(rig, vertices)
    still = np.setdiff1d(np.arange(len(vertices)), out)
    moved = aligned(at_rest, later).moved(later.vertices)
    assert np.abs(moved - rig.template)[still].max() < 2e-4


def test_nothing_is_said_of_scans_that_differ_by_noise(rig: Rig, at_rest: Stance) -> None:
    out = vertex_normals(rig.template, rig.faces)
    shares = []
    for seed in range(3):
        found = change_between(at_rest, visit(rig, rig.template + noise(rig, seed)[:, None] * out))
        shares.append(float(found.said[np.isfinite(found.along)].mean()))
    assert np.mean(shares) <= 0.1


def test_skin_that_one_scan_does_not_show_has_no_change(rig: Rig, at_rest: Stance) -> None:
    later = visit(rig, larger(rig, 0.012))
    right_half = later.scan_faces[(((later.scan_vertices - SHIFT) @ TURN)[later.scan_faces, 0] < 0.0).all(axis=1)]
    found = change_between(at_rest, replace(later, scan_faces=right_half))
    left = on_breasts(rig)[rig.template[on_breasts(rig), 0] > 0.03]
    assert np.isnan(found.along[left]).all()
    assert found.volume("L") is None
    assert gained(found, "R")[0] == pytest.approx(0.0, abs=1.0)


def test_breasts_that_mirror_each_other_are_symmetric(rig: Rig, at_rest: Stance) -> None:
    whole = {row.measure: row.value for row in symmetry_rows(at_rest, measures(at_rest))}
    assert whole["volume_symmetry"] is not None
    assert whole["volume_symmetry"].value == pytest.approx(1.0, abs=1e-3)
    assert whole["shape_symmetry"] is not None
    assert whole["shape_symmetry"].value < 0.05
    grown = visit(rig, larger(rig, 0.012))
    bell = np.linalg.norm(larger(rig, 0.012) - rig.template, axis=1)[vertices_within(rig, "L")]
    found = {row.measure: row.value for row in symmetry_rows(grown, measures(grown))}["shape_symmetry"]
    assert found is not None
    assert found.value == pytest.approx(1e3 * float(np.sqrt(np.mean(bell**2))), rel=0.1)


def test_what_cannot_be_compared_is_said(rig: Rig, at_rest: Stance) -> None:
    elsewhere = replace(at_rest, scan_faces=at_rest.scan_faces[:20])
    with pytest.raises(BadInput, match="share too little skin"):
        change_between(at_rest, elsewhere)
    unknown = replace(at_rest, rig=replace(rig, known={}))
    assert visit_calibration(unknown.rig) is None
    with pytest.raises(BadInput, match="was not measured"):
        change_between(unknown, unknown)

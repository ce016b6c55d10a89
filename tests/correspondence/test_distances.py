"""The reported numbers on surfaces whose distance is known."""

import numpy as np
import pytest
from helpers.surfaces import sphere

from breastrig.correspondence import distances as module
from breastrig.correspondence.distances import (
    Comparison,
    landmark_summary_mm,
    summary_mm,
    surface_distances,
    surface_summary_mm,
)
from breastrig.correspondence.target import ScanTarget


def test_two_spheres_are_as_far_apart_as_their_radii_both_ways() -> None:
    outer, faces = sphere(0.103, 5)
    target = ScanTarget(*sphere(0.1, 5))
    distances = surface_distances(target, outer, faces)
    model, scan = surface_summary_mm(distances.model), summary_mm(distances.scan)
    assert model["coverage"] == 1.0
    for summary in (model, scan):
        assert abs(summary["mean"] - 3.0) < 0.05
        assert abs(summary["max"] - 3.0) < 0.1
        assert summary["std"] < 0.05
        assert abs(summary["p95"] - 3.0) < 0.1


def test_what_the_scan_does_not_show_has_no_distance() -> None:
    vertices, faces = sphere(0.1, 5)
    front = faces[(vertices[faces][:, :, 2] > 0.0).all(axis=1)]
    distances = surface_distances(ScanTarget(vertices, front), vertices, faces)
    assert np.isnan(distances.model[vertices[:, 2] < -0.03]).all()
    assert np.isfinite(distances.model[vertices[:, 2] > 0.03]).all()


@pytest.mark.parametrize("stride", [1, 2, 3, 4, 7])
def test_a_part_of_the_scan_is_measured_as_in_the_whole(stride: int, monkeypatch: pytest.MonkeyPatch) -> None:
    vertices, faces = sphere(0.1, 5)
    front = faces[(vertices[faces][:, :, 2] > -0.05).all(axis=1)]
    target = ScanTarget(*sphere(0.102, 5))
    monkeypatch.setattr(module, "MAX_SCAN_POINTS", len(target.vertices) // 2)
    compared = Comparison(target, vertices, front)
    _ = compared.distances  # of every second of the scan's vertices
    alone = Comparison(target, vertices, front)._looked_at(stride)
    for found, wanted in zip(compared.from_scan(stride), alone, strict=True):
        np.testing.assert_array_equal(found, wanted)
    distances, inside, facing = alone
    whole = compared.search.query(target.vertices[::stride])
    np.testing.assert_allclose(distances, whole.distances, rtol=0, atol=1e-12)
    assert 0.5 < inside.mean() < 1.0  # what lies beyond the opening is left out
    assert facing[inside].all()


def test_nothing_measured_is_none_and_not_zero() -> None:
    assert summary_mm(np.full(3, np.nan)) == {"mean": None, "std": None, "max": None, "p95": None}
    assert landmark_summary_mm({}, {})["mean"] is None


def test_landmark_distances_are_named() -> None:
    model = {"a": np.zeros(3), "b": np.array([0.0, 0.0, 0.001])}
    picked = {"a": np.array([0.0, 0.003, 0.0]), "b": np.array([0.0, 0.0, 0.002])}
    summary = landmark_summary_mm(model, picked)
    assert summary == {"mean": 2.0, "std": 1.0, "max": 3.0, "min": 1.0, "each": {"a": 3.0, "b": 1.0}}


@pytest.mark.parametrize("most", [200, 400, 10_000])
def test_no_more_scan_points_than_meant(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    vertices, faces = sphere(0.1, 3)
    target = ScanTarget(*sphere(0.102, 3))
    monkeypatch.setattr(module, "MAX_SCAN_POINTS", most)
    count = len(surface_distances(target, vertices, faces).scan)
    assert min(len(target.vertices), most) / 2 < count <= min(len(target.vertices), most)

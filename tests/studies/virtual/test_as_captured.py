"""Conditions of a capture change the surface, never where the landmarks are on her."""

from itertools import combinations

import numpy as np
import pytest

from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.boundary import boundary_edges
from breastrig.rig.model import Rig
from breastrig.scan.clean import clean
from breastrig.scan.scan import Scan
from breastrig_studies.virtual.as_captured import CONDITIONS, as_captured

WORN, CLOSED = ("bra", "plaster", "long_hair"), ("flat_back", "walled_back", "poisson")


@pytest.fixture(scope="module")
def marks(rig: Rig) -> dict[str, np.ndarray]:
    return dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))


@pytest.mark.parametrize("condition", CONDITIONS)
def test_the_body_stays_what_it_is(condition: str, rig: Rig, marks: dict[str, np.ndarray]) -> None:
    vertices, faces, moved = as_captured(condition, rig.template, rig.faces, marks, np.random.default_rng(1))
    for first, second in combinations(marks, 2):
        apart = np.linalg.norm(marks[first] - marks[second])
        assert np.linalg.norm(moved[first] - moved[second]) == pytest.approx(apart, abs=1e-9)
    scan = ScanTarget(vertices, faces)
    near = [each for each in moved.values() if scan.vertex_tree.query(each)[0] < 0.035]
    assert len(near) >= (4 if condition in ("one_side", "below_nipples") else 6)
    if condition in WORN:
        by = np.linalg.norm(vertices - rig.template, axis=1)
        assert np.array_equal(faces, rig.faces)
        assert 0.002 < by.max() < 0.045
        assert (by > 0.001).mean() < 0.5
    if condition in CLOSED:
        assert len(boundary_edges(faces)) < len(boundary_edges(rig.faces))


def test_a_flat_back_is_cut_away_and_what_is_left_is_skin(rig: Rig, marks: dict[str, np.ndarray]) -> None:
    vertices, faces, _ = as_captured("flat_back", rig.template, rig.faces, marks, np.random.default_rng(1))
    left = clean(Scan(vertices, faces, "m", 1.0, "", "0" * 64))
    assert "Flat lids" in left.notes[0]
    skin = ScanTarget(rig.template, rig.faces)
    away = skin.vertex_tree.query(left.vertices)[0]
    assert np.mean(away < 1e-6) > 0.9

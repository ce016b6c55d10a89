"""What lies within a lasso is cut, however deep, and nothing else; the page finds the same triangles."""

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.surfaces import sphere

from breastrig.core.errors import BadScan
from breastrig.scan.hand_cuts import HandCut, cut_triangles, without_hand_cuts
from breastrig.scan.scan import Scan

EXAMPLE = Path(__file__).with_name("hand_cuts.json")  # web/test/scan/crop.test.ts reads it too
FROM_FRONT = np.diag([5.0, 5.0, -1.0, 1.0]).T.ravel().tolist()  # of a parallel picture 0.4 m wide


def seen_from(distance: float) -> list[float]:
    """A picture with perspective, by an eye on +Z so far (m) from the origin."""
    picture = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, -1.0, 0], [0, 0, -1.0, distance]])
    return [float(each) for each in picture.T.ravel()]


def ball() -> Scan:
    vertices, faces = sphere(0.1, 4)
    return Scan(vertices, faces, "m", 1.0, "As asked for.", "0" * 64)


def test_a_lasso_cuts_what_lies_within_it_however_deep() -> None:
    scan = ball()
    square = {"to_picture": FROM_FRONT, "lasso": [[0.1, -0.2], [0.4, -0.2], [0.4, 0.2], [0.1, 0.2]]}
    middles = scan.vertices[scan.faces].mean(axis=1)
    expected = (middles[:, 0] > 0.02) & (middles[:, 0] < 0.08) & (np.abs(middles[:, 1]) < 0.04)
    cut = cut_triangles(scan.vertices, scan.faces, [HandCut.of(square)])
    np.testing.assert_array_equal(cut, expected)
    assert (middles[cut, 2] < 0.0).any()
    assert (middles[cut, 2] > 0.0).any()


def test_a_lasso_may_be_hollow_and_nothing_behind_the_eye_is_in_a_picture() -> None:
    scan = ball()
    u = [[-1, -1], [1, -1], [1, 1], [0.4, 1], [0.4, -0.4], [-0.4, -0.4], [-0.4, 1], [-1, 1]]
    middles = scan.vertices[scan.faces].mean(axis=1)
    cut = cut_triangles(scan.vertices, scan.faces, [HandCut.of({"to_picture": FROM_FRONT, "lasso": u})])
    np.testing.assert_array_equal(cut, (np.abs(middles[:, 0]) > 0.08) | (middles[:, 1] < -0.08))
    all_around = {"to_picture": seen_from(0.0), "lasso": [[-99, -99], [99, -99], [99, 99], [-99, 99]]}
    behind = cut_triangles(scan.vertices, scan.faces, [HandCut.of(all_around)])
    assert not behind[middles[:, 2] > 0.0].any()
    assert behind[middles[:, 2] < -0.01].all()


def test_the_page_finds_the_same_triangles() -> None:
    """The example that both read holds a scan, two lassos and what they cut."""
    kept = json.loads(EXAMPLE.read_text("utf-8"))
    vertices = np.array(kept["positions"], dtype=np.float32).reshape(-1, 3).astype(np.float64)
    faces = np.array(kept["index"]).reshape(-1, 3)
    cut = cut_triangles(vertices, faces, [HandCut.of(each) for each in kept["cuts"]])
    assert np.flatnonzero(cut).tolist() == kept["cut"]
    assert 20 < len(kept["cut"]) < len(faces) - 20


def test_what_is_left_of_a_scan_and_what_is_said_of_it() -> None:
    scan = ball()
    half = {"to_picture": FROM_FRONT, "lasso": [[0, -1], [1, -1], [1, 1], [0, 1]]}
    left = without_hand_cuts(scan, [half])
    assert left.cut_by_hand + len(left.faces) == len(scan.faces)
    assert left.cut_by_hand == pytest.approx(0.5 * len(scan.faces), rel=0.02)
    assert left.notes == (f"{left.cut_by_hand:,} triangles were cut away by hand.",)
    assert without_hand_cuts(scan, []) is scan
    beside = {"to_picture": FROM_FRONT, "lasso": [[0.9, 0.9], [1, 0.9], [1, 1]]}
    assert without_hand_cuts(scan, [beside]) is scan
    other = {"to_picture": FROM_FRONT, "lasso": [[0.01, -1], [-1, -1], [-1, 1], [0.01, 1]]}
    with pytest.raises(BadScan, match="leaves nothing to look at; take one of the cuts back"):
        without_hand_cuts(scan, [half, other])

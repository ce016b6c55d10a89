"""Polylines as text that other programs read."""

import numpy as np

from breastrig.geometry.polyline import Polyline
from breastrig.report.files.geometry_files import obj_lines, ply_lines

RING = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.2, 0.05]])
LINES = (
    Polyline("ring", True, "#ff8000", RING, np.array([False, True, False])),
    Polyline("stroke", False, "#101010", RING[:2] + 1.0, np.zeros(2, dtype=np.bool_)),
)


def test_obj_has_one_object_for_each_line_in_the_scans_unit() -> None:
    text = obj_lines(LINES, 1e-3, "mm").decode().splitlines()
    points = np.array([[float(x) for x in line.split()[1:]] for line in text if line.startswith("v ")])
    np.testing.assert_allclose(points, 1e3 * np.concatenate([line.points for line in LINES]), atol=1e-6)
    assert [line for line in text if line[0] in "ol"] == ["o ring", "l 1 2 3 1", "o stroke", "l 4 5"]
    assert any("unit: mm" in line for line in text)


def test_ply_has_vertices_edges_and_says_what_is_bridged() -> None:
    text = ply_lines(LINES, 1.0, "m").decode().splitlines()
    assert text[0] == "ply"
    assert "element vertex 5" in text
    assert "element edge 4" in text
    body = [line.split() for line in text[text.index("end_header") + 1 :]]
    np.testing.assert_allclose([[float(x) for x in row[:3]] for row in body[:5]], np.concatenate([RING, RING[:2] + 1]))
    assert [row[3:] for row in body[:5]] == [["0", "0"], ["0", "1"], ["0", "0"], ["1", "0"], ["1", "0"]]
    assert [row[:2] for row in body[5:]] == [["0", "1"], ["1", "2"], ["2", "0"], ["3", "4"]]
    assert [row[2:] for row in body[5:]] == [["255", "128", "0"]] * 3 + [["16", "16", "16"]]

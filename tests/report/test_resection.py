"""What a closed line encloses: bodies whose volumes are known, the mirrored place, and the report's words."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.blank_pictures import blank_pictures
from helpers.results import result_file

from breastrig.core.identity import UNNAMED
from breastrig.geometry.polyline import Polyline
from breastrig.report.document import Reported, report_document
from breastrig.report.pages.pdf import report_content
from breastrig.report.resections.resection import Columns, resections
from breastrig.report.stance import Stance
from breastrig.rig.parameters import rest_parameters
from breastrig.volume.tetrahedra import chest_wall

AXES = np.array([0.06, 0.07, 0.05])  # m of the half ellipsoid


def dome(axes: np.ndarray, rings: int = 24) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Half an ellipsoid with a flat brim, the plane under it, and triangles, counter-clockwise from outside."""
    angles = np.linspace(0.0, 2.0 * np.pi, 4 * rings, endpoint=False)
    slopes = np.linspace(0.0, 0.5 * np.pi, rings + 1)[1:]
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    ringed = [
        np.column_stack([np.sin(s) * circle * axes[:2], np.full(len(angles), np.cos(s) * axes[2])]) for s in slopes
    ]
    brim = [np.column_stack([scale * circle * axes[:2], np.zeros(len(angles))]) for scale in (1.2, 1.5, 1.9)]
    skin = np.concatenate([[[0.0, 0.0, axes[2]]], *ringed, *brim])
    count = len(angles)
    first, after = np.arange(count), np.roll(np.arange(count), -1)
    faces = [np.stack([np.zeros(count, int), 1 + first, 1 + after], axis=1)]
    for k in range(len(ringed) + len(brim) - 1):
        inner, outer = 1 + k * count, 1 + (k + 1) * count
        faces += [
            np.stack([inner + first, outer + first, outer + after], axis=1),
            np.stack([inner + first, outer + after, inner + after], axis=1),
        ]
    return skin, skin * [1.0, 1.0, 0.0], np.concatenate(faces)


def ellipse(axes: np.ndarray, share: float = 1.0) -> np.ndarray:
    """The line on the dome above `share` times its base."""
    angles = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    circle = share * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.column_stack([circle * axes[:2], np.full(200, axes[2] * np.sqrt(1.0 - share**2))])


def test_down_to_the_wall_it_is_the_ellipsoids_volume_whole_and_under_a_smaller_line() -> None:
    body = Columns(*dome(AXES))
    whole = 2.0 / 3.0 * np.pi * AXES.prod()
    assert body.volume(body.inside(ellipse(AXES))) == pytest.approx(whole, rel=0.01)
    share = 0.5  # the columns are upright: ∫ of the height over the smaller ellipse
    part = 2.0 / 3.0 * np.pi * AXES.prod() * (1.0 - (1.0 - share**2) ** 1.5)
    inside = body.inside(ellipse(AXES, share))
    assert body.volume(inside) == pytest.approx(part, rel=0.01)
    turned = body.inside(ellipse(AXES, share)[::-1])
    assert body.volume(turned) == pytest.approx(part, rel=0.01), "whichever way it was drawn"
    base = np.pi * share**2 * AXES[:2].prod()
    assert body.volume(inside, lowered=0.004) == pytest.approx(part + 0.004 * base, rel=0.01)


@pytest.mark.parametrize("depth", [0.01, 0.03])
def test_a_depth_is_measured_from_the_nearest_skin(depth: float) -> None:
    radius = 0.06
    body = Columns(*dome(np.full(3, radius)))
    found = body.volume(body.inside(ellipse(np.full(3, radius))), depth)
    inner = _under_the_dome(radius, depth)
    assert found == pytest.approx(inner, rel=0.015)


def _under_the_dome(radius: float, depth: float) -> float:
    """m³ within `depth` of a half ball's skin; its flat side is none."""
    return 2.0 / 3.0 * np.pi * (radius**3 - (radius - depth) ** 3)


def test_a_line_on_one_breast_has_its_share_and_the_same_place_on_the_other(
    at_rest: Stance, monkeypatch: pytest.MonkeyPatch
) -> None:
    blank_pictures(monkeypatch)
    rig = at_rest.rig
    shape = next(s for d in rig.drawings for s in d.shapes if s.name == "breast_base_L" or s.name == "breast_L")
    base = shape.points.positions(at_rest.vertices, rig.faces)
    middle = base.mean(axis=0)
    half = middle + 0.5 * (base - middle)
    half = at_rest.search.query(half + np.array([0.0, 0.0, 0.1])).points  # from the front
    lines = [
        Polyline(name, True, "#101010", points, np.zeros(len(points), dtype=bool))
        for name, points in (("cut_L", half), ("areola_L", half), ("all_L", base))
    ]
    open_line = replace(lines[0], name="open_L", closed=False)
    wall = chest_wall(rig, rest_parameters(rig), at_rest.vertices)
    cut, everything = resections(replace(at_rest, lines=(*lines, open_line)), lambda: wall, {"cut_L": 0.025})
    assert (cut.line, cut.side, everything.line) == ("cut_L", "L", "all_L")
    assert everything.rows[-1].share == pytest.approx(1.0, abs=1e-6)
    assert everything.rows[-1].after == pytest.approx(0.0, abs=1e-9)
    assert cut.breast == pytest.approx(cut.other_breast, rel=1e-3), "the model at rest is symmetric"
    volumes = [row.volume for row in cut.rows]
    assert volumes == sorted(volumes)
    for row in cut.rows:
        assert row.other == pytest.approx(row.volume, rel=0.01)
        assert row.after == pytest.approx(cut.breast - row.volume, abs=1e-7)
        assert row.share == pytest.approx(row.volume / cut.breast, rel=1e-3)
    assert [row.depth for row in cut.rows] == [0.01, 0.02, 0.025, 0.03, None], "its own depth is a row"
    assert [row.depth for row in everything.rows] == [0.01, 0.02, 0.03, None]
    assert [row.band is None for row in cut.rows] == [True, True, True, True, False]
    low, high = cut.rows[-1].band or (0.0, 0.0)
    assert low < volumes[-1] < high
    depths = {"cut_L": 0.025}
    shown = Reported("standing", replace(at_rest, lines=lines[:1]), result_file(), (), wall=lambda: wall, depths=depths)
    [written] = report_document([shown])["stances"][0]["resections"]
    assert written["rows"][-1]["ml"] == pytest.approx(1e6 * volumes[-1], abs=0.06)
    assert [row["depth_mm"] for row in written["rows"] if row["planned"]] == [25.0]
    assert written["rows"][-1]["grams"] == pytest.approx(0.94e6 * volumes[-1], abs=0.06)
    assert "resections" not in report_document([shown], with_plan=False)["stances"][0]
    [table] = report_content([shown], UNNAMED)["resections"]
    assert table["title"] == "Cut, left"
    assert [row[0] for row in table["rows"]][1:4] == ["to 20 mm", "to 25 mm, as planned", "to 30 mm"]
    assert table["rows"][-1][:4] == [
        "to the chest wall",
        f"{1e6 * volumes[-1]:.0f} ({1e6 * low:.0f} to {1e6 * high:.0f})",
        f"{0.94e6 * volumes[-1]:.0f}",
        f"{100 * cut.rows[-1].share:.0f} %",
    ]

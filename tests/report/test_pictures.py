"""Lines in the report's pictures: in their own colours, and dark enough to show on the scan."""

import colorsys
import dataclasses

import numpy as np
import pytest

from breastrig.geometry.polyline import Polyline
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.line_bands import EDGE_PIXELS, HATCH_PIXELS, LineBands
from breastrig.report.pictures import INK, SCAN_GREY, _dashes, _lines, line_colour, scan_pictures, views_of
from breastrig.report.stance import Stance
from breastrig.use.reports.report import _banded, _without_own_errors


def luminance(colour: tuple[float, float, float]) -> float:
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour]
    return float(np.dot([0.2126, 0.7152, 0.0722], linear))


@pytest.mark.parametrize(
    "color", ["#c53030", "#2b6cb0", "#ffff00", "#00ff00", "#ff00ff", "#101010", "#f4f4f4", "#888888"]
)
def test_a_line_shows_on_grey_skin_and_keeps_its_hue(color: str) -> None:
    own = tuple(int(color[at : at + 2], 16) / 255 for at in (1, 3, 5))
    shown = line_colour(color)
    assert (luminance(SCAN_GREY) + 0.05) / (luminance(shown) + 0.05) > 3.0
    if max(own) - min(own) < 0.1:
        assert shown == INK
    else:
        assert colorsys.rgb_to_hsv(*shown)[0] == pytest.approx(colorsys.rgb_to_hsv(*own)[0], abs=0.06)
        assert max(shown) > 0.4


def test_a_red_and_a_white_line_are_distinguished_in_the_picture() -> None:
    rig = read_rig(default_rig_path())
    stance = Stance(rig, rig.template, rig.template, rig.faces, "standing")
    nipples = [
        rig.landmark_points().positions(rig.template, rig.faces)[rig.landmark_names.index(f"nipple_{s}")] for s in "LR"
    ]
    around = 0.03 * np.array([[np.cos(a), np.sin(a), 0.0] for a in np.linspace(0.0, 6.2, 24)])
    lines = tuple(
        Polyline(name, True, color, stance.search.query(nipple + around).points, np.zeros(24, dtype=np.bool_))
        for name, color, nipple in zip(("red", "white"), ("#c53030", "#f4f4f4"), nipples, strict=True)
    )
    size = (300, 300)
    cameras = views_of(stance, ["front"], 1.0)
    bare = scan_pictures(stance, cameras, size)[0].astype(int)
    drawn = scan_pictures(dataclasses.replace(stance, lines=lines), cameras, size)[0].astype(int)
    changed = np.abs(drawn - bare).max(axis=2) > 20
    reddish = changed & (drawn[..., 0] > drawn[..., 2] + 60)
    black = changed & (drawn.max(axis=2) < 90)  # INK
    middle = size[0] // 2
    assert reddish[:, middle:].sum() > 50  # her left is to the right of the picture
    assert not reddish[:, :middle].any()
    assert black[:, :middle].sum() > 50
    assert not black[:, middle:].any()


def test_a_band_is_as_wide_as_the_lines_error_and_lesions_are_yellow_with_a_dark_outline() -> None:
    rig = read_rig(default_rig_path())
    grid = 0.3 * np.stack(np.meshgrid(np.linspace(-0.5, 0.5, 301), np.linspace(-0.5, 0.5, 301)), axis=-1).reshape(-1, 2)
    flat = np.column_stack([grid, np.zeros(len(grid))])
    along = np.column_stack([np.linspace(-0.1, 0.1, 101), np.zeros(101), np.zeros(101)])
    seen = np.zeros(101, dtype=np.bool_)
    error = np.where(along[:, 0] > 0.02, np.nan, 0.02)  # not known on the patient's left
    line = Polyline("cut", False, "#101010", along, seen, error=error)
    stance = Stance(rig, rig.template, flat, rig.faces, "standing")
    front = np.tile([0.0, 0.0, 1.0], (len(flat), 1))
    pixel = 0.001
    bands = LineBands([(line, INK)], flat, front)
    shade = bands.paint(np.ones_like(flat), flat, front, flat[:, :2] / pixel, pixel)[:, 0]
    half = 0.71 * 0.02
    beside = (flat[:, 0] > -0.09) & (flat[:, 0] < 0.0)
    dark = beside & (shade < 0.99)
    assert np.abs(flat[dark, 1]).max() == pytest.approx(half, abs=0.0015)
    inside = shade[beside & (np.abs(flat[:, 1]) < half - 0.003)]
    assert inside.max() == inside.min() < 0.7
    edge = beside & (np.abs(np.abs(flat[:, 1]) - half + 0.5 * EDGE_PIXELS * pixel) < 0.5 * pixel)
    assert shade[edge].max() < inside.min() - 0.1
    unknown = (flat[:, 0] > 0.04) & (flat[:, 0] < 0.09)
    stripes = shade[unknown & (np.abs(flat[:, 1]) < 0.009)]
    assert 0.3 < (stripes < 0.99).mean() < 0.55  # hatched, one centimetre to each side
    assert np.all(shade[unknown & (np.abs(flat[:, 1]) > 0.0105)] == 1.0)
    along_hatch = flat + HATCH_PIXELS * pixel * np.array([0.5, -0.5, 0.0])
    again = bands.paint(np.ones_like(flat), flat, front, along_hatch[:, :2] / pixel, pixel)[:, 0]
    assert np.allclose(again, shade)
    away = bands.paint(np.ones_like(flat), flat, -front, flat[:, :2] / pixel, pixel)
    assert np.all(away == 1.0)  # the far side of a fold
    lesion = dataclasses.replace(line, color="#f3c400")
    below, above = _lines(dataclasses.replace(stance, lines=(lesion,)), 300)
    assert below.colour == INK
    assert above.colour == pytest.approx((243 / 255, 196 / 255, 0.0))


def test_where_the_scan_shows_no_skin_a_line_is_dashed_and_all_of_it_on_a_body_that_was_not_scanned() -> None:
    run = np.column_stack([np.linspace(0.0, 0.1, 21), np.zeros(21), np.zeros(21)])
    dashes = _dashes(run)
    assert [round(1e3 * (dash[-1, 0] - dash[0, 0])) for dash in dashes[:-1]] == [5] * (len(dashes) - 1)
    assert np.allclose(np.diff([dash[0, 0] for dash in dashes]), 0.011)
    rig = read_rig(default_rig_path())
    nipple = rig.landmark_points().positions(rig.template, rig.faces)[rig.landmark_names.index("nipple_L")]
    turns = np.linspace(0.0, 6.2, 96)
    around = nipple + 0.04 * np.column_stack([np.cos(turns), np.sin(turns), np.zeros(96)])
    on_skin = Stance(rig, rig.template, rig.template, rig.faces, "standing").search.query(around).points
    line = Polyline("cut", True, "#101010", on_skin, np.zeros(96, dtype=np.bool_))
    stance = Stance(rig, rig.template, rig.template, rig.faces, "standing", lines=(line,))
    view = views_of(stance, ["front"], 1.0)
    whole, dashed = (
        scan_pictures(dataclasses.replace(stance, predicted=predicted), view, (400, 400))[0].max(axis=2) < 60
        for predicted in (False, True)
    )
    assert 0.3 < dashed.sum() / whole.sum() < 0.85


def test_what_a_hand_has_drawn_on_this_scan_has_no_band_and_what_was_carried_here_has() -> None:
    """Also where both are called alike, as the first lines of two scans are."""
    kinds = (("own", None, None), ("Line 1", "line", False), ("Line 1", "line", True), ("wise_L", "pattern", False))
    kinds += (("n", "note", False),)
    points, error = np.zeros((2, 3)), np.full(2, 0.01)
    lines = tuple(
        Polyline(name, False, "#101010", points, np.zeros(2, dtype=np.bool_), error=error) for name, _, _ in kinds
    )
    shapes = [
        {"name": name, "kind": kind, "carried": is_carried, "points": points.tolist()}
        for name, kind, is_carried in kinds[1:]
    ]
    assert _banded(lines, ({"shapes": shapes}, True)) == (lines[0], lines[2], lines[3])
    assert _banded(lines, None) == lines
    without = _without_own_errors(lines, ({"shapes": shapes}, True))
    assert [line.error is None for line in without] == [False, True, False, True, True]

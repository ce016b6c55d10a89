"""Ellipse, periareolar and vertical pattern: their lengths along the skin, their sides, and what is refused."""

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.patterns import asked_drawing
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.polyline import length
from breastrig.geometry.surface_points import SurfacePoints, joined
from breastrig.rig.model import DrawnShape, Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import shaped


@pytest.fixture(scope="module")
def sagging(torso: Rig) -> Array:
    weights = rest_parameters(torso).weights.copy()
    for name, weight in (("ptosis", 1.8), ("volume_large", 1.5), ("nipple_vertical", -1.4)):
        for side in ("_L", "_R"):
            weights[torso.shape_names.index(name + side)] = weight
    return 1.15 * shaped(torso, weights)


def drawn(rig: Rig, vertices: Array, text: str) -> dict[str, DrawnShape]:
    return {shape.name: shape for shape in asked_drawing(rig, text).on_model(rig, vertices).shapes}


def one(points: SurfacePoints, k: int) -> SurfacePoints:
    return SurfacePoints(points.faces[[k]], points.barycentric[[k]])


def from_nipple(rig: Rig, vertices: Array, side: str, points: SurfacePoints) -> Array:
    """mm along the skin."""
    geodesics, nipple = Geodesics(vertices, rig.faces), rig.landmark_points((f"nipple_{side}",))
    starts = joined([nipple] * len(points.faces))
    return np.array([1e3 * length(way) for way in geodesics.paths(starts, points)])


def test_the_ellipse_has_its_axes_along_the_skin_and_rises_towards_the_armpit(torso: Rig) -> None:
    shapes = drawn(torso, torso.template, "ellipse:length_mm=120,width_mm=60,axis_deg=30")
    assert {*shapes} == {"mastectomy_L", "mastectomy_R"}
    for side, outward in (("L", 1.0), ("R", -1.0)):
        rim = shapes[f"mastectomy_{side}"].points
        radii = from_nipple(torso, torso.template, side, rim)
        count = len(radii)
        assert radii[[0, count // 2]] == pytest.approx([60.0, 60.0], abs=0.5)
        assert radii[[count // 4, 3 * count // 4]] == pytest.approx([30.0, 30.0], abs=0.5)
        assert radii.min() > 29.5
        at = rim.positions(torso.template, torso.faces)
        far, near = at[0], at[count // 2]
        assert outward * (far - near)[0] > 0.03  # the long axis leads outwards,
        assert (far - near)[1] > 0.02  # and up


def test_one_side_alone(torso: Rig) -> None:
    assert {*drawn(torso, torso.template, "ellipse:side=R")} == {"mastectomy_R"}
    assert {*drawn(torso, torso.template, "periareolar:side=L")} == {"periareolar_L", "areola_L"}


def test_the_outer_ring_reaches_as_much_higher_as_the_nipple_shall_rise(torso: Rig) -> None:
    shapes = drawn(torso, torso.template, "periareolar:side=L,areola_mm=40,outer_mm=70,lift_mm=20")
    outer = from_nipple(torso, torso.template, "L", shapes["periareolar_L"].points)
    assert outer[0] == pytest.approx(55.0, abs=0.5)  # 12 o'clock
    assert outer[[9, 18, 27]] == pytest.approx([35.0] * 3, abs=0.5)  # 3, 6 and 9
    assert from_nipple(torso, torso.template, "L", shapes["areola_L"].points) == pytest.approx(20.0, abs=0.3)
    with pytest.raises(BadDrawing, match="outer ring must be wider"):
        asked_drawing(torso, "periareolar:areola_mm=50,outer_mm=45")


@pytest.mark.parametrize("side", ["L", "R"])
def test_the_limbs_of_the_vertical_pattern_meet_above_the_fold_and_are_as_wide_as_asked(
    torso: Rig, sagging: Array, side: str
) -> None:
    shapes = drawn(torso, sagging, f"vertical:side={side},width_mm=50,above_fold_mm=30")
    assert {*shapes} == {f"vertical_{side}", f"areola_{side}", f"new_nipple_{side}"}
    cut = shapes[f"vertical_{side}"]
    skin = FittedSkin(torso, sagging)
    at, (start, keyhole, lowest) = skin.at(cut.points), cut.corners
    assert start == 0
    fold = torso.landmark_points((f"inframammary_fold_{side}",))
    (way,) = skin.geodesics.paths(fold, one(cut.points, lowest))
    assert 1e3 * length(way) == pytest.approx(30.0, abs=1.0)
    assert cut.closed
    down, up = at[keyhole : lowest + 1], np.concatenate([at[lowest:], at[:1]])
    assert length(down) == pytest.approx(length(up), rel=0.25)  # they are sewn together
    widest = np.linalg.norm(down[len(down) // 2] - up[len(up) // 2])
    assert 0.030 < widest < 0.055  # straight across what is 50 mm before it is laid on the breast
    assert np.linalg.norm(np.diff(at, axis=0), axis=1).max() < 0.012


def test_a_near_fold_names_the_other_pattern(torso: Rig) -> None:
    with pytest.raises(BadDrawing, match="periareolar"):
        drawn(torso, 0.6 * torso.template, "vertical:above_fold_mm=60")

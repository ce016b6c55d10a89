"""Lines in the report's pictures: in their own colours, and dark enough to show on the scan."""

import colorsys
import dataclasses

import numpy as np
import pytest

from breastrig.geometry.polyline import Polyline
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.pictures import INK, SCAN_GREY, line_colour, scan_pictures, views_of
from breastrig.report.stance import Stance


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
    bluish = changed & (drawn[..., 2] > drawn[..., 0] + 15) & (drawn[..., 0] < 90)  # INK
    middle = size[0] // 2
    assert reddish[:, middle:].sum() > 50  # her left is to the right of the picture
    assert not reddish[:, :middle].any()
    assert bluish[:, :middle].sum() > 50
    assert not bluish[:, middle:].any()

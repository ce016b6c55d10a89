import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from breastrig.core.errors import BadSettings
from breastrig.geometry.rays import HAVE_EMBREE
from breastrig.rendering.picture import (
    VIEWS,
    Layer,
    Line,
    Scene,
    camera,
    diverging_colours,
)

pytestmark = pytest.mark.skipif(not HAVE_EMBREE, reason="embreex has no wheel for this platform")

CHECKOUT = Path(__file__).resolve().parents[2]
SMALL = (64, 64)
RED, BLUE, GREEN = (0.9, 0.1, 0.1), (0.1, 0.1, 0.9), (0.0, 0.9, 0.0)


def box(centre: tuple[float, float, float], half: float = 0.02) -> tuple[np.ndarray, np.ndarray]:
    solid = trimesh.creation.box(extents=[2 * half] * 3)
    return np.array(solid.vertices) + centre, np.array(solid.faces)


def mean_place(picture: np.ndarray, channel: int) -> np.ndarray:
    """(x, y) in pixels of what is mostly of one colour."""
    others = np.delete(picture[..., :3].astype(int), channel, axis=2).max(axis=2)
    rows, columns = np.nonzero(picture[..., channel].astype(int) > others + 40)
    return np.array([columns.mean(), rows.mean()])


@pytest.mark.parametrize(
    ("view", "left_of_body_is", "head_is"),
    [("front", "right", "up"), ("back", "left", "up"), ("top", "right", None), ("left", None, "up")],
)
def test_named_views_show_the_body_from_where_they_say(
    view: str, left_of_body_is: str | None, head_is: str | None
) -> None:
    left, head = box((0.2, 0, 0.05)), box((0, 0.2, 0.05))
    shown = camera(view, np.array([[-0.3, -0.3, -0.3], [0.3, 0.3, 0.3]]))
    picture = Scene([Layer(*left, RED), Layer(*head, BLUE)]).render(shown, SMALL)
    if left_of_body_is:
        assert (mean_place(picture, 0)[0] > 32) == (left_of_body_is == "right")
    if head_is:
        assert mean_place(picture, 2)[1] < 25


def test_a_turned_body_looks_the_same_in_its_own_frame() -> None:
    vertices, faces = box((0.1, 0.02, 0.0))
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    straight = Scene([Layer(vertices, faces)]).render(camera("three_quarter", vertices), SMALL)
    turned = vertices @ turn.T
    again = Scene([Layer(turned, faces)]).render(camera("three_quarter", turned, frame=turn), SMALL)
    assert np.abs(straight.astype(int) - again).mean() < 0.5


@pytest.mark.parametrize("view", list(VIEWS))
def test_the_body_fills_the_picture_and_touches_no_edge(view: str) -> None:
    vertices, faces = box((0.3, -2.0, 1.0), 0.1)
    picture = Scene([Layer(vertices, faces, RED)]).render(camera(view, vertices, aspect=1.5), (96, 64), background=None)
    covered = picture[..., 3] > 0
    assert not covered[0].any()
    assert not covered[:, 0].any()
    assert covered.any(axis=1).sum() >= 50 or covered.any(axis=0).sum() >= 80


def test_nothing_to_show_is_the_background() -> None:
    picture = Scene([]).render(camera("front", np.zeros((1, 3))), SMALL, background=BLUE)
    assert picture.shape == (64, 64, 3)
    assert (picture == [26, 26, 230]).all()


def test_a_line_behind_the_body_is_hidden_and_one_before_it_shown() -> None:
    vertices, faces = box((0, 0, 0), 0.1)
    shown = camera("front", vertices)
    across = np.array([[-0.08, 0.0, 0.0], [0.08, 0.0, 0.0]])
    forward = np.array([0.0, 0.0, 0.11])
    before = Scene([Layer(vertices, faces)]).render(shown, SMALL, [Line(across + forward, GREEN, 3.0)])
    behind = Scene([Layer(vertices, faces)]).render(shown, SMALL, [Line(across - forward, GREEN, 3.0)])
    assert np.abs(mean_place(before, 1) - 31.5).max() < 1.5
    assert (behind == Scene([Layer(vertices, faces)]).render(shown, SMALL)).all()


def test_the_light_comes_from_the_upper_left() -> None:
    solid = trimesh.creation.icosphere(3, 0.1)
    vertices, faces = np.array(solid.vertices), np.array(solid.faces)
    picture = Scene([Layer(vertices, faces)]).render(camera("front", vertices), SMALL).astype(int)
    assert picture[20, 20, 0] > picture[44, 44, 0] + 25


def test_the_inside_of_an_open_surface_is_distinguished_from_the_outside() -> None:
    sheet = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    outside = Scene([Layer(sheet, np.array([[0, 1, 2]]), RED)]).render(camera("front", sheet), SMALL)
    inside = Scene([Layer(sheet, np.array([[0, 2, 1]]), RED)]).render(camera("front", sheet), SMALL)
    assert outside[50, 10, 0] > outside[50, 10, 2] + 100
    assert abs(int(inside[50, 10, 0]) - int(inside[50, 10, 2])) < 40


def test_an_unknown_view_names_the_known_ones() -> None:
    with pytest.raises(BadSettings, match="three_quarter"):
        camera("frontal", np.zeros((1, 3)))


def test_the_distance_colours_are_pale_within_the_noise_darken_to_both_sides_and_stay_apart() -> None:
    colours = diverging_colours(np.linspace(-5, 5, 41))
    grey = colours @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_allclose(colours[12:29], colours[[20]].repeat(17, axis=0))  # -2 to +2 mm
    assert (np.diff(grey[:13]) > 0).all()
    assert (np.diff(grey[28:]) < 0).all()
    assert np.abs(grey - grey[::-1]).max() < 0.12
    assert colours[0, 2] > colours[0, 0] + 0.4
    assert colours[-1, 0] > colours[-1, 2] + 0.4
    np.testing.assert_allclose(diverging_colours(np.array([-50.0, 50.0])), colours[[0, -1]])
    np.testing.assert_allclose(diverging_colours(np.array([np.nan])), 0.55)


def test_the_page_colours_the_same_distances_in_the_same_way() -> None:
    shared = json.loads((CHECKOUT / "web/test/fit/distance_colours.json").read_text())["srgb_by_mm"]
    values = np.array([float(mm) for mm in shared])
    np.testing.assert_allclose(255.0 * diverging_colours(values), list(shared.values()), atol=0.51)  # whole numbers

"""Pictures of the skin: each pixel has the colour and the place of the skin that it shows."""

import io

import numpy as np
import pytest
from PIL import Image

from breastrig.colour.skin_texture import lab, skin_texture
from breastrig.core.errors import BadScan
from breastrig.scan.scan import Scan


def _ball(**colour):
    """A ball of 50 mm with uv in two halves of the atlas, cut at the equator; position is colour."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=5, radius=0.05)
    turned = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    return Scan(ball.vertices @ turned.T + 0.3, ball.faces, "m", 1.0, "", "", **colour)


def _halves(scan):
    """The ball with a chart for each half, its triangles apart, and a picture of red = x, green = y, blue = z."""
    corners = scan.vertices[scan.faces] - 0.3
    upper = corners[:, :, 2].mean(axis=1) > 0
    flat = corners[:, :, :2] / 0.06
    uv = np.where(upper[:, None, None], 0.25 + 0.24 * flat, 0.75 + 0.24 * flat)
    size = 512
    column, row = np.meshgrid((np.arange(size) + 0.5) / size, 1 - (np.arange(size) + 0.5) / size)
    low = column < 0.5
    middle = np.where(low, 0.25, 0.75)
    x, y = (column - middle) / 0.24 * 0.06, (row - middle) / 0.24 * 0.06
    z = np.sqrt(np.maximum(0.05**2 - x**2 - y**2, 0)) * np.where(low, 1, -1)
    image = np.stack([x, y, z], axis=2) / 0.05 * 100 + 128
    stream = io.BytesIO()
    Image.fromarray(np.clip(image, 0, 255).astype(np.uint8)).save(stream, "PNG")
    vertices = scan.vertices[scan.faces].reshape(-1, 3)
    return Scan(
        vertices,
        np.arange(len(vertices)).reshape(-1, 3),
        "m",
        1.0,
        "",
        "",
        uv=uv.reshape(-1, 2),
        texture=stream.getvalue(),
        picture=stream.getvalue(),
    )


@pytest.mark.parametrize("kind", ["texture", "vertex"])
def test_each_pixel_shows_the_colour_of_its_place_on_the_skin(kind):
    plain = _ball()
    scan = (
        _halves(plain)
        if kind == "texture"
        else _ball(colours=np.rint((plain.vertices - 0.3) / 0.05 * 100 + 128).astype(np.uint8))
    )
    texture = skin_texture(scan)
    assert len(texture.pictures) == 6
    area = 0.0
    for picture in texture.pictures:
        rows, columns = np.nonzero(picture.skin)
        places = picture.places(rows, columns) - 0.3
        assert np.abs(np.linalg.norm(places, axis=1) - 0.05).max() < 2e-4
        off = np.abs(picture.pixels[rows, columns] - (places / 0.05 * 100 + 128))
        steep = np.abs(places[:, 2]) < 0.01 if kind == "texture" else np.zeros(len(places), bool)
        assert off[~steep].max() < 4.0
        # the picture's axes turn it the right way round: one column to the right is one pixel along the first axis
        beside = picture.places(rows[:1], columns[:1] + 1.0, picture.faces[rows[:1], columns[:1]].astype(np.int64))
        step = (beside - 0.3 - places[:1])[0]
        assert step @ picture.axes[0] == pytest.approx(picture.texel)
        assert step @ picture.axes[1] == pytest.approx(0.0, abs=1e-12)
        area += len(rows) * picture.texel**2
    assert len(np.unique(np.concatenate([p.faces[p.skin] for p in texture.pictures]))) == len(scan.faces)
    assert area > 2 * np.pi * 0.05**2  # they overlap
    assert np.linalg.det(picture.axes) == pytest.approx(1.0)


def test_skin_behind_other_skin_is_seen_too_and_seams_are_one_skin():
    plain = _ball()
    small = 0.3 + 0.6 * (plain.vertices - 0.3) + [0.004, 0, 0]  # a ball within the ball
    vertices = np.concatenate([plain.vertices, small])
    faces = np.concatenate([plain.faces, plain.faces + len(small)])
    colours = np.full(vertices.shape, 90, np.uint8)
    colours[len(small) :] = 200
    texture = skin_texture(Scan(vertices, faces, "m", 1.0, "", "", colours=colours), texel=2e-4)
    seen = np.unique(np.concatenate([p.faces[p.skin] for p in texture.pictures]))
    assert (seen >= len(plain.faces)).sum() == len(plain.faces)
    apart = skin_texture(_halves(plain))
    assert apart.node.max() + 1 == len(plain.vertices)


def test_a_scan_without_colour_is_one_sentence():
    with pytest.raises(BadScan, match="no colour"):
        skin_texture(_ball())


def test_lab_is_that_of_the_standard():
    red = lab(np.array([[[255, 0, 0]]], np.uint8))
    assert red[0, 0] == pytest.approx([53.24, 80.09, 67.20], abs=0.05)

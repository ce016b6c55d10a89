"""The scan's mesh as links show it: what is visible, with the pixels that belong to it and no others."""

import io

import numpy as np
import pytest
import trimesh
from PIL import Image

from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays
from breastrig.gltf.link_mesh import coloured_mesh, covered_texture, plain_mesh
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.scan.clean import Surface, clean, compact
from breastrig.scan.scan import Scan

VERTICES = np.random.default_rng(3).normal(size=(30, 3))
FACES = np.arange(30).reshape(10, 3)
VISIBLE = np.arange(10) % 3 > 0
COLOURS = np.random.default_rng(4).integers(0, 256, (30, 3)).astype(np.uint8)


def scan(vertices: np.ndarray = VERTICES, faces: np.ndarray = FACES, **more: object) -> Scan:
    return Scan(vertices, faces, "m", 1.0, "", "", **more)


def visible(vertices: np.ndarray = VERTICES, faces: np.ndarray = FACES[VISIBLE]) -> Surface:
    """As a fit keeps it: only the vertices of its triangles, in single precision."""
    return Surface(*compact(vertices.astype(np.float32).astype(np.float64), faces), ())


def read(glb: bytes) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Its attributes and (F, 3) triangles."""
    document, binary = split_glb(glb)
    arrays, primitive = GltfArrays(document, binary), document["meshes"][0]["primitives"][0]
    found = {name: arrays.read(place) for name, place in primitive["attributes"].items()}
    return found, arrays.read(primitive["indices"]).reshape(-1, 3)


@pytest.mark.parametrize("far", [0.0, 3000.0])
def test_what_is_not_visible_has_neither_triangles_nor_vertices(far: float) -> None:
    moved = VERTICES + far
    shown = Surface(*compact(moved, FACES[VISIBLE][:, [1, 2, 0]]), ())  # some scans face inwards and are turned
    found, faces = read(coloured_mesh(scan(moved, colours=COLOURS), shown))
    assert set(found) == {"POSITION", "NORMAL", "COLOR_0"}
    assert len(faces) == np.count_nonzero(VISIBLE)
    assert len(found["POSITION"]) == 3 * len(faces)
    corners, wanted = found["POSITION"][faces], VERTICES[FACES][VISIBLE]
    np.testing.assert_allclose(corners - corners[0, 0], wanted - wanted[0, 0], atol=2e-6)


def test_colours_of_vertices_stay_to_the_last_bit() -> None:
    document, binary = split_glb(coloured_mesh(scan(colours=COLOURS), visible()))
    stored = GltfArrays(document, binary).stored(document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"])
    whole = split_glb(mesh_glb(VERTICES, FACES, colours=COLOURS))
    before = GltfArrays(*whole).stored(whole[0]["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"])
    assert np.array_equal(stored, before[FACES[VISIBLE].ravel()])


def test_a_plain_mesh_has_the_shades_of_its_shape_and_no_seams_where_pieces_of_its_texture_met() -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    split = scan(ball.vertices[ball.faces].reshape(-1, 3), np.arange(3 * len(ball.faces)).reshape(-1, 3))
    found, faces = read(plain_mesh(clean(split)))
    assert set(found) == {"POSITION", "NORMAL", "COLOR_0"}
    grey = found["COLOR_0"][:, 0]
    assert np.array_equal(found["COLOR_0"][:, :3], np.column_stack([grey, grey, grey]))
    assert np.ptp(grey) < 0.01, "a ball bends alike everywhere"
    assert len(found["POSITION"]) == len(ball.vertices)
    np.testing.assert_allclose(found["POSITION"][faces], ball.vertices[ball.faces], atol=1e-7)


def test_a_scan_without_colours_is_shown_plain() -> None:
    assert coloured_mesh(scan(), visible()) == plain_mesh(visible())


def sheet(size: int = 64) -> tuple[np.ndarray, bytes]:
    """The left half of a picture blue, the right half red, and its PNG."""
    pixels = np.zeros((size, size, 3), np.uint8)
    pixels[:, : size // 2, 2] = pixels[:, size // 2 :, 0] = 255
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    return pixels, stream.getvalue()


def pixels_of(glb: bytes) -> np.ndarray:
    document, binary = split_glb(glb)
    view = document["bufferViews"][document["images"][0]["bufferView"]]
    start = view.get("byteOffset", 0)
    with Image.open(io.BytesIO(binary[start : start + view["byteLength"]])) as opened:
        return np.asarray(opened.convert("RGB")).astype(int)


@pytest.mark.parametrize("right", ["cut away", "of no triangle"])
def test_pixels_that_no_visible_triangle_shows_are_not_in_the_texture(right: str) -> None:
    uv = np.array([[0.05, 0.05], [0.45, 0.05], [0.25, 0.95], [0.55, 0.05], [0.95, 0.05], [0.75, 0.95]])
    vertices, faces = np.column_stack((uv, np.zeros(6))), np.arange(6).reshape(2, 3)
    given = faces if right == "cut away" else faces[:1]
    glb = coloured_mesh(scan(vertices, given, uv=uv, texture=sheet()[1]), visible(vertices, faces[:1]))
    left = pixels_of(glb)
    assert left[..., 0].max() < 10, "no red is left"
    assert left[32, 16, 2] > 245, "her own stays"
    found, _ = read(glb)
    np.testing.assert_allclose(found["TEXCOORD_0"] * [1.0, -1.0] + [0.0, 1.0], uv[:3], atol=1e-6)


def test_a_texture_that_repeats_keeps_what_lies_over_its_edge() -> None:
    pixels, png = sheet()
    across = np.array([[[2.7, -0.9], [3.2, -0.9], [2.95, -0.4]]])  # from the right half over the edge into the left one
    with Image.open(io.BytesIO(covered_texture(png, across))) as opened:
        left = np.asarray(opened).astype(int)
    for u, v in ((0.8, 0.15), (0.1, 0.15)):
        row, column = int((1.0 - v) * 64), int(u * 64)
        assert np.abs(left[row, column] - pixels[row, column]).max() < 10, (u, v)
    middle = left[10, 32]
    assert 0 < middle[0] < 245
    assert 0 < middle[2] < 245

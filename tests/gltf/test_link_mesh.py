import io

import numpy as np
import pytest
import trimesh
from helpers.scan_files import picture
from PIL import Image

from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays
from breastrig.gltf.covered_texture import covered_texture
from breastrig.gltf.link_mesh import coloured_mesh, plain_mesh
from breastrig.gltf.mesh_glb import mesh_glb

VERTICES = np.random.default_rng(3).normal(size=(30, 3))
FACES = np.arange(30).reshape(10, 3)
COLOURS = {
    "vertex": {"colours": np.full((30, 3), 200, dtype=np.uint8)},
    "texture": {"uv": np.full((30, 2), 0.5), "texture": picture()},
    "none": {},
}


@pytest.mark.parametrize("kind", COLOURS)
def test_shape_stays_and_colour_goes(kind: str) -> None:
    coloured = mesh_glb(VERTICES, FACES, **COLOURS[kind])
    plain = plain_mesh(coloured)
    documents = [split_glb(glb) for glb in (coloured, plain)]
    before, after = (document["meshes"][0]["primitives"][0] for document, _ in documents)
    assert set(after["attributes"]) == {"POSITION", "NORMAL"}
    assert not documents[1][0].get("images")
    assert not documents[1][0].get("textures")
    arrays = [GltfArrays(*document) for document in documents]
    for place in ("POSITION", "NORMAL"):
        values = [each.read(one["attributes"][place]) for each, one in zip(arrays, (before, after), strict=True)]
        assert np.allclose(*values, atol=1e-7)
    assert np.array_equal(arrays[0].read(before["indices"]), arrays[1].read(after["indices"]))
    assert plain == plain_mesh(mesh_glb(VERTICES, FACES))


def test_a_plain_mesh_has_no_seams_where_pieces_of_its_texture_met() -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    split = ball.faces  # with every corner a vertex of its own
    uv = np.random.default_rng(5).random((3 * len(split), 2))
    glb = mesh_glb(
        ball.vertices[split].reshape(-1, 3), np.arange(3 * len(split)).reshape(-1, 3), uv=uv, texture=picture()
    )
    document, binary = split_glb(plain_mesh(glb))
    arrays, primitive = GltfArrays(document, binary), document["meshes"][0]["primitives"][0]
    vertices, faces = arrays.read(primitive["attributes"]["POSITION"]), arrays.read(primitive["indices"]).reshape(-1, 3)
    assert len(vertices) == len(ball.vertices)
    assert np.allclose(vertices[faces], ball.vertices[split], atol=1e-7)
    normals = arrays.read(primitive["attributes"]["NORMAL"])
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)


def right_half(at: float) -> dict[str, object]:
    """A cut of all that lies to the right of x = `at`."""
    return {"to_picture": np.eye(4).ravel().tolist(), "lasso": [[at, -9.0], [9.0, -9.0], [9.0, 9.0], [at, 9.0]]}


def test_colours_of_vertices_stay_to_the_last_bit_where_nothing_is_cut() -> None:
    colours = np.random.default_rng(4).integers(0, 256, (30, 3)).astype(np.uint8)
    glb = coloured_mesh(mesh_glb(VERTICES, FACES, colours=colours), [right_half(0.2)])
    kept = VERTICES[FACES].mean(axis=1)[:, 0] < 0.2
    assert 0 < np.count_nonzero(kept) < len(kept)
    document, binary = split_glb(glb)
    stored = GltfArrays(document, binary).stored(document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"])
    whole = split_glb(mesh_glb(VERTICES, FACES, colours=colours))
    before = GltfArrays(*whole).stored(whole[0]["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"])
    assert np.array_equal(stored, before[FACES[kept].ravel()])


def sheet(size: int = 64) -> tuple[np.ndarray, bytes]:
    """The left half of a picture blue, the right half red, and its PNG."""
    pixels = np.zeros((size, size, 3), np.uint8)
    pixels[:, : size // 2, 2] = pixels[:, size // 2 :, 0] = 255
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    return pixels, stream.getvalue()


def test_what_was_cut_is_not_in_the_texture_either() -> None:
    uv = np.array([[0.05, 0.05], [0.45, 0.05], [0.25, 0.95], [0.55, 0.05], [0.95, 0.05], [0.75, 0.95]])
    vertices = np.column_stack((uv, np.zeros(6)))
    glb = mesh_glb(vertices, np.arange(6).reshape(2, 3), uv=uv, texture=sheet()[1])
    document, binary = split_glb(coloured_mesh(glb, [right_half(0.5)]))
    view = document["bufferViews"][document["images"][0]["bufferView"]]
    start = view.get("byteOffset", 0)
    with Image.open(io.BytesIO(binary[start : start + view["byteLength"]])) as opened:
        left = np.asarray(opened.convert("RGB")).astype(int)
    assert left[..., 0].max() < 10, "no red is left"
    assert left[32, 16, 2] > 245, "her own stays"
    read = GltfArrays(document, binary).read(document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"])
    np.testing.assert_allclose(read * [1.0, -1.0] + [0.0, 1.0], uv[:3], atol=1e-6)


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

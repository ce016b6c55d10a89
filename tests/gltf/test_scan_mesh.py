"""The mesh that the page shows: the body first, all facing outwards, its rims beside it, shaded where it is grey."""

import numpy as np
import pytest
from helpers.gltf_evaluator import GltfScene
from helpers.surfaces import sphere

from breastrig.core.assets import asset_folder
from breastrig.core.srgb import to_light
from breastrig.fitting.prepare_scan import prepared_scan
from breastrig.geometry.normals import face_crosses
from breastrig.gltf.scan_mesh import scan_mesh
from breastrig.rendering.folds import FLAT
from breastrig.scan.clean import Surface, clean
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan

SUPINE = asset_folder("example") / "supine" / "scan.ply"


def of(vertices: np.ndarray, faces: np.ndarray, colours: np.ndarray | None = None) -> Scan:
    """A grey scan, unless it has colours."""
    return Scan(vertices, faces, "m", 1.0, "", "", colours=colours)


def primitives(glb: bytes) -> list[dict[str, np.ndarray]]:
    """Of each primitive: positions, triangles, colours."""
    scene = GltfScene(glb)
    (mesh,) = scene.document["meshes"]
    found = []
    for each in mesh["primitives"]:
        read = {name: scene.arrays.read(number) for name, number in each["attributes"].items()}
        found.append({**read, "mode": each.get("mode", 4)})
        if "indices" in each:
            found[-1]["faces"] = scene.arrays.read(each["indices"]).reshape(-1, 3)
    return found


def cap() -> tuple[np.ndarray, np.ndarray]:
    """A ball of 10 cm without its lower part."""
    vertices, faces = sphere(0.1, 5)
    return vertices, faces[(vertices[faces][:, :, 2] > -0.03).all(axis=1)]


def test_the_body_of_a_scan_on_a_table_comes_first_as_the_fit_has_it() -> None:
    scan = read_scan(SUPINE, "ply", "m")
    target = prepared_scan(scan, "auto").target
    glb, count = scan_mesh(scan, Surface(target.vertices, target.faces, ()))
    skin, rims = primitives(glb)
    assert count == len(target.faces)
    assert len(skin["faces"]) == len(scan.faces)
    middles = skin["POSITION"][skin["faces"]].mean(axis=1)
    body = target.vertices[target.faces].mean(axis=1)
    assert np.sort(middles[:count].sum(axis=1)) == pytest.approx(np.sort(body.sum(axis=1)), abs=1e-5)
    heights = middles @ target.table.normal - target.table.height
    assert np.median(heights[:count]) > 0.1
    assert np.percentile(np.abs(heights[count:]), 90) < 0.02, "what comes after it is the table"
    assert rims["mode"] == 1
    assert np.abs(rims["POSITION"]).max() <= np.abs(skin["POSITION"]).max()


def test_a_piece_beside_the_body_comes_after_it_and_all_face_outwards_whatever_the_file_says() -> None:
    vertices, faces = cap()
    hand, fingers = sphere(0.02, 3)
    scan = of(
        np.concatenate([hand + np.array([0.4, 0.0, 0.0]), vertices]),
        np.concatenate([fingers, (faces + len(hand))[:, ::-1]]),
    )
    glb, count = scan_mesh(scan, clean(of(vertices, faces)))
    skin, _ = primitives(glb)
    assert count == len(faces)
    middles = skin["POSITION"][skin["faces"]].mean(axis=1)
    assert (middles[:count, 0] < 0.2).all()
    assert (middles[count:, 0] > 0.2).all()
    crosses = face_crosses(skin["POSITION"].astype(float), skin["faces"].astype(np.int64))
    assert (np.einsum("fi,fi->f", crosses[:count], middles[:count]) > 0.0).all()


def test_rims_run_where_one_triangle_ends_and_seams_of_a_texture_are_none() -> None:
    vertices, faces = cap()
    split = of(vertices[faces.ravel()], np.arange(faces.size).reshape(-1, 3))  # each corner for itself
    for scan in (of(vertices, faces), split):
        _, rims = primitives(scan_mesh(scan, clean(of(vertices, faces)))[0])
        ends = rims["POSITION"].reshape(-1, 2, 3)
        assert ends[:, :, 2] == pytest.approx(-0.03, abs=0.01)
        assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum() > 2.0 * np.pi * 0.09
    assert len(primitives(scan_mesh(of(*sphere(0.1, 4)), clean(of(*sphere(0.1, 4))))[0])) == 1, "a ball has none"


def test_a_grey_scan_is_shaded_and_colours_stay_what_they_are() -> None:
    vertices, faces = cap()
    grey = primitives(scan_mesh(of(vertices, faces), clean(of(vertices, faces)))[0])[0]
    assert np.median(grey["COLOR_0"][:, 0]) > FLAT
    red = np.tile(np.array([200, 10, 10], dtype=np.uint8), (len(vertices), 1))
    own = primitives(scan_mesh(of(vertices, faces, red), clean(of(vertices, faces)))[0])[0]
    assert own["COLOR_0"][:, :3] == pytest.approx(np.tile(to_light(red[0] / 255.0), (len(vertices), 1)), abs=1e-3)

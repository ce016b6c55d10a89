"""The painted cohort: colours lie where the truth says, and the same seed paints the same."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
from helpers.painted_body import PaintedBody, painted_body
from PIL import Image
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array
from breastrig.scan.read import read_scan
from breastrig_studies.virtual.painted import painted_patients
from breastrig_studies.virtual.painted.atlas import make_atlas
from breastrig_studies.virtual.painted.files import strokes_elsewhere, write_painted_case, write_shapes
from breastrig_studies.virtual.painted.marks import COVERED, RECONSTRUCTED, draw_marks
from breastrig_studies.virtual.scan import SimulatedScan
from breastrig_studies.virtual.warped.sources import read_sources


@pytest.fixture(scope="module")
def woman() -> PaintedBody:
    return painted_body(plan="lumpectomy", side=768)


def colours_at(woman: PaintedBody, places: Array) -> Array:
    """(M, 3) sRGB 0 to 255 of the texture at the triangles' points that are nearest to the places."""
    scan = woman.scan
    assert scan.texture is not None
    pixels = np.asarray(Image.open(io.BytesIO(scan.texture)).convert("RGB"), dtype=np.float64)
    middles = scan.vertices[scan.faces].mean(axis=1)
    weights = np.random.default_rng(1).dirichlet(np.ones(3), 6)
    dense = np.concatenate([np.einsum("c,fcd->fd", w, scan.vertices[scan.faces]) for w in weights])
    uv = np.concatenate([np.einsum("c,fcd->fd", w, scan.uv[scan.faces]) for w in weights])
    assert len(middles) * 6 == len(dense)
    _, nearest = cKDTree(dense).query(places)
    side = len(pixels)
    at = np.clip((np.stack([1.0 - uv[nearest, 1], uv[nearest, 0]], axis=1) * side).astype(int), 0, side - 1)
    return np.asarray(pixels[at[:, 0], at[:, 1]])


def test_texels_lie_where_their_triangle_is_in_space() -> None:
    vertices = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0], [0.0, 0.1, 0.0], [0.05, 0.05, 0.01]])
    faces = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    atlas = make_atlas(vertices, faces, 128)
    assert atlas.charts == 1
    owner = atlas.owners.ravel()[atlas.owned]
    places = np.einsum("nc,ncd->nd", atlas.weights, vertices[faces[owner]])
    row, column = np.divmod(atlas.owned, 128)
    step = np.stack([column - column[0], row - row[0]], axis=1) * atlas.texel
    np.testing.assert_allclose(np.abs(places[:, :2] - places[0, :2]), np.abs(step), atol=1e-9)


def test_ink_is_where_its_polylines_are(woman: PaintedBody) -> None:
    strokes = {stroke.name: stroke for stroke in woman.painted.marks.ink}
    line = strokes["midline"]
    points = line.points.positions(woman.body.vertices, woman.bodies.faces)
    on = colours_at(woman, points[line.inked])
    beside = colours_at(woman, points[line.inked] + [0.012, 0.0, 0.0])
    assert np.median(np.abs(on - beside).max(axis=1)) > 15.0
    assert {"tumour", "meridian_L", "meridian_R", "imf_L", "imf_R"} <= set(strokes)
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert gaps.max() < 0.002


def test_covered_and_reconstructed_nipples_have_no_areola_in_the_truth(tmp_path: Path, woman: PaintedBody) -> None:
    states = {"L": COVERED, "R": RECONSTRUCTED}
    marks = draw_marks(woman.body, woman.bodies.faces, np.random.default_rng(3), "none", states)
    scan = SimulatedScan(woman.scan.vertices, woman.scan.faces, 0.0)
    picture = woman.picture
    random = np.random.default_rng(4)
    placed = write_painted_case(
        tmp_path,
        woman.body,
        woman.bodies.faces,
        scan,
        picture.atlas,
        picture.picture,
        marks,
        False,
        "mm",
        random,
        {"seed": 1},
    )
    shapes = json.loads((tmp_path / "skin.json").read_text())["shapes"]
    assert not any(shape["name"].startswith("areola") for shape in shapes)
    about = json.loads((tmp_path / "case.json").read_text())
    assert about["nipples"] == {"nipple_L": "covered", "nipple_R": "reconstructed"}
    assert json.loads((tmp_path / "ink.json").read_text())["shapes"] == []
    read = read_scan(tmp_path / "scan.zip", None, "mm")
    assert read.texture is not None
    assert len(read.faces) == len(scan.faces)
    write_shapes(
        tmp_path / "there.json",
        "mm",
        strokes_elsewhere(woman.body, woman.bodies.faces, woman.painted.marks.ink, placed, "mm"),
    )
    there = json.loads((tmp_path / "there.json").read_text())["shapes"]
    away, _ = cKDTree(1e3 * read.vertices).query(np.array(there[0]["points"]))
    assert away.max() < 12.0  # mm: on the scan, whose triangles are up to 10 mm large


def test_the_halves_share_no_woman_and_are_those_of_the_warped_bodies() -> None:
    choose, report = painted_patients("development"), painted_patients("validation")
    assert not set(choose) & set(report)
    assert set(choose) | set(report) == set(painted_patients())
    halves = {source.name: source.half for source in read_sources()}
    assert all(halves[f"cohort_{name}"] == "development" for name in choose)
    assert all(halves[f"cohort_{name}"] == "validation" for name in report)

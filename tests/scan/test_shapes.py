"""Public test shapes: one sentence each, whichever door they come by; no warning, no traceback."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

import breastrig
from breastrig.core.errors import BadScan, BreastRigError, TooLarge
from breastrig.scan import limits
from breastrig.scan.clean import clean
from breastrig.scan.formats import obj, ply
from breastrig.scan.read import read_scan, scan_of_arrays

RNG = np.random.default_rng(0)


def strip() -> trimesh.Trimesh:
    along = np.linspace(0.0, 0.6, 300)
    edge = np.column_stack([along, 0.0 * along, 0.0 * along])
    faces = [[i, i + 1, i + 300] for i in range(299)] + [[i + 1, i + 301, i + 300] for i in range(299)]
    return trimesh.Trimesh(np.concatenate([edge, edge + np.array([0.0, 1e-4, 0.0])]), faces, process=False)


def square(copies: int) -> trimesh.Trimesh:
    """Two triangles, many times nearly where they were."""
    corners = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.5, 0.5, 0.0]])
    vertices = np.tile(corners, (copies, 1)) + np.repeat(1e-3 * RNG.normal(size=(copies, 3)), 4, axis=0)
    faces = np.array([[0, 1, 2], [1, 3, 2]]) + 4 * np.arange(copies)[:, None, None]
    return trimesh.Trimesh(vertices, faces.reshape(-1, 3), process=False)


COARSE = {
    "cylinder": trimesh.creation.cylinder(radius=0.15, height=0.5, sections=100),
    "cylinder in mm": trimesh.creation.cylinder(radius=150.0, height=500.0, sections=300),
    "tube": trimesh.creation.annulus(r_min=0.1, r_max=0.2, height=0.4, sections=200),
    "strip": strip(),
    "square": square(200),
}


@pytest.mark.parametrize("name", COARSE)
def test_a_surface_of_long_triangles_or_none_at_all_is_one_sentence(name: str, tmp_path: Path) -> None:
    file = tmp_path / "shape.stl"
    COARSE[name].export(file)
    for door in (breastrig.fit, breastrig.propose_landmarks, lambda each: clean(read_scan(each))):
        with pytest.raises(BreastRigError, match="too little to show a torso"):
            door(file)


def test_a_large_plane_behind_a_body_of_small_triangles_is_no_reason() -> None:
    body = trimesh.creation.icosphere(subdivisions=4, radius=0.2)
    plane = trimesh.Trimesh([[-2, -2, -0.3], [2, -2, -0.3], [2, 2, -0.3], [-2, 2, -0.3]], [[0, 1, 2], [0, 2, 3]])
    both = trimesh.util.concatenate([body, plane])
    assert len(clean(scan_of_arrays(np.array(both.vertices), np.array(both.faces), None, "m")).faces) >= 5000


@pytest.mark.slow
def test_a_capsule_without_a_vertex_in_its_middle_is_no_torso_and_no_traceback(tmp_path: Path) -> None:
    trimesh.creation.capsule(height=0.4, radius=0.15).export(tmp_path / "capsule.stl")
    with pytest.raises(BreastRigError, match=r"\.$"):
        breastrig.fit(tmp_path / "capsule.stl")


@pytest.mark.parametrize("announced", [400, 0])
def test_random_bytes_as_stl_are_one_sentence(announced: int) -> None:
    content = b"x" * 80 + int(announced).to_bytes(4, "little") + RNG.bytes(50 * 400)
    with pytest.raises(BadScan, match="not finite or beyond 1e30" if announced else "no triangles"):
        read_scan(content, "stl")


def test_many_points_are_called_points(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ply, "VERTICES", 10)
    monkeypatch.setattr(obj, "VERTICES", 10)
    points = "\n".join("0 0 0" for _ in range(11))
    header = (
        "ply\nformat ascii 1.0\nelement vertex 11\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    )
    for content, kind in ((header + points, "ply"), (points.replace("0 0 0", "v 0 0 0"), "obj")):
        with pytest.raises(TooLarge, match=f"{limits.POINTS:,} points allowed"):
            read_scan(content.encode(), kind)


@pytest.mark.slow
def test_a_fit_that_fails_says_what_was_wrong_with_the_file() -> None:
    body = trimesh.creation.box((0.3, 0.5, 0.2)).subdivide().subdivide().subdivide()
    vertices = np.array(body.vertices)
    vertices[body.faces[0, 0]] = np.inf
    scan = scan_of_arrays(vertices, np.array(body.faces), None, "m")
    mesh = trimesh.Trimesh(scan.vertices, scan.faces, process=False)
    assert len(mesh.faces) < len(body.faces)
    with pytest.raises(BreastRigError, match=r"torso.*\. One vertex of this scan is not finite"):
        breastrig.fit(trimesh.Trimesh(vertices, body.faces, process=False), units="m")

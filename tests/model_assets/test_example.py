"""The tracked example patient is what its README says; it is not made again here (that needs the source data)."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from breastrig.core.assets import asset_folder
from breastrig.geometry.boundary import boundary_edges
from breastrig.rig.validation.torso import LANDMARKS

STANCES = ("standing", "supine")


@pytest.fixture(scope="module", params=STANCES)
def stance(request: pytest.FixtureRequest) -> Path:
    return asset_folder("example") / str(request.param)


@pytest.fixture(scope="module")
def scan(stance: Path) -> trimesh.Trimesh:
    return trimesh.load(stance / "scan.ply", process=False)


def places(stance: Path) -> dict[str, np.ndarray]:
    content = json.loads((stance / "landmarks.json").read_text("utf-8"))
    assert content["schema"] == "breastrig/landmarks@1"
    assert content["unit"] == "mm"
    return {name: 1e-3 * np.array(place) for name, place in content["landmarks"].items()}


def test_the_scan_has_the_size_of_a_tablet_scan_in_metres(scan: trimesh.Trimesh) -> None:
    assert 25_000 <= len(scan.faces) <= 60_000
    assert np.isfinite(scan.vertices).all()
    assert 0.4 < np.ptp(scan.vertices, axis=0).max() < 1.0


def test_the_files_are_small_and_binary(stance: Path) -> None:
    data = (stance / "scan.ply").read_bytes()
    assert data.startswith(b"ply\nformat binary_little_endian 1.0\n")
    assert len(data) < 1_500_000


def test_the_scan_has_skin_colours(scan: trimesh.Trimesh) -> None:
    colours = np.asarray(scan.visual.vertex_colors)[:, :3].astype(float)
    assert colours.std(axis=0).min() > 2.0
    red, _, blue = np.median(colours, axis=0)
    assert red > blue + 10


def test_the_scan_is_open_and_has_holes_like_a_real_one(scan: trimesh.Trimesh) -> None:
    assert len(boundary_edges(np.asarray(scan.faces))) > 300
    assert scan.area > 0.25


def test_every_landmark_lies_on_the_skin_that_was_scanned(stance: Path, scan: trimesh.Trimesh) -> None:
    marks = places(stance)
    assert set(marks) == set(LANDMARKS)
    gaps = {name: float(np.linalg.norm(scan.vertices - place, axis=1).min()) for name, place in marks.items()}
    assert max(gaps.values()) < 0.010, gaps
    case = json.loads((stance / "case.json").read_text("utf-8"))
    for name, gap in gaps.items():
        assert case["landmark_gap_mm"][name] == pytest.approx(1e3 * gap, abs=0.11)


def test_left_is_the_patients_left(stance: Path, scan: trimesh.Trimesh) -> None:
    """Seen from the front, head up: the front is where the outward normals near the breastbone look."""
    marks = places(stance)
    head = marks["suprasternal_notch"] - marks["umbilicus"]
    near = np.linalg.norm(scan.triangles_center - marks["mid_sternum"], axis=1) < 0.04
    front = scan.face_normals[near].mean(axis=0)
    left = np.cross(head, front)
    for name in ("nipple", "acromion", "midclavicle", "inframammary_fold"):
        assert (marks[f"{name}_L"] - marks[f"{name}_R"]) @ left > 0


def test_standing_is_upright_to_a_few_degrees_and_supine_looks_up() -> None:
    for stance, front in (("standing", [0.0, 0.0, 1.0]), ("supine", [0.0, 1.0, 0.0])):
        marks = places(asset_folder("example") / stance)
        head = marks["suprasternal_notch"] - marks["xiphoid"]
        across = marks["acromion_L"] - marks["acromion_R"]
        found = np.cross(across, head)
        assert found @ front / np.linalg.norm(found) > 0.8


def test_lying_down_the_breasts_flatten_and_move_apart() -> None:
    """In the frame of the breastbone of each stance."""
    apart, depth = {}, {}
    for stance in STANCES:
        marks = places(asset_folder("example") / stance)
        chest = (marks["suprasternal_notch"] + marks["xiphoid"]) / 2
        across = marks["acromion_L"] - marks["acromion_R"]
        across /= np.linalg.norm(across)
        head = marks["suprasternal_notch"] - marks["xiphoid"]
        front = np.cross(across, head / np.linalg.norm(head))
        apart[stance] = (marks["nipple_L"] - marks["nipple_R"]) @ across
        depth[stance] = ((marks["nipple_L"] + marks["nipple_R"]) / 2 - chest) @ front
    assert apart["supine"] > apart["standing"] + 0.01
    assert depth["supine"] < depth["standing"] - 0.01


def test_the_case_says_what_it_is(stance: Path) -> None:
    case = json.loads((stance / "case.json").read_text("utf-8"))
    assert case["stance"] == stance.name
    assert case["unit"] == "m"
    assert case["license"] == "CC0-1.0"
    assert "Research use only" in case["notice"]
    assert "irtual" in case["patient"]

"""The tracked example patient is what its README says; it is not made again here (that needs the source data)."""

import json
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
import trimesh
from torso_rules import LANDMARKS

import breastrig
from breastrig.core.assets import asset_folder

STANCES = ("standing", "supine")
PEN_MM = (334, 196, 183, 130, 103)  # lengths that were drawn whole: midline, meridians, fold, tumour


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


def test_the_case_says_what_it_is(stance: Path) -> None:
    case = json.loads((stance / "case.json").read_text("utf-8"))
    assert case["stance"] == stance.name
    assert case["unit"] == "m"
    assert case["license"] == "CC0-1.0"
    assert "Research use only" in case["notice"]
    assert "irtual" in case["patient"]


@pytest.mark.parametrize("name", ["marked", "mri"])
def test_landmarks_of_the_further_scans_lie_on_their_skin(name: Literal["marked", "mri"]) -> None:
    example = breastrig.example(name)
    skin = breastrig.read_scan(example.scan).in_metres.vertices
    away = [np.linalg.norm(skin - place, axis=1).min() for place in places(example.scan.parent).values()]
    assert max(away) < 0.010
    case = json.loads(example.scan.with_name("case.json").read_text("utf-8"))
    assert case["license"] == "CC0-1.0"
    assert "Research use only" in case["notice"]


def test_the_lines_of_the_pen_are_found() -> None:
    strokes = breastrig.find_ink(breastrig.example("marked").scan).strokes
    found = sorted((line.length_mm for line in strokes), reverse=True)
    assert found[: len(PEN_MM)] == pytest.approx(PEN_MM, abs=15)


def test_the_label_map_has_two_lesions_inside_the_left_breast() -> None:
    example = breastrig.example("mri")
    scan = breastrig.read_scan(example.scan)
    assert [each.taken_as for each in scan.segments] == ["tissue", "lesion", "lesion"]
    large, small = scan.in_metres.lesions
    assert (1e3 * large.radius, 1e3 * small.radius) == pytest.approx((8.0, 5.0), abs=0.3)

"""Marks in landmark files: named places on the skin that no landmark of the model is."""

import json

import numpy as np
import pytest

from breastrig.core.errors import BadLandmarks
from breastrig.core.picks import Picks
from breastrig.scan.landmarks.landmark_files import landmark_file, landmarks_of_file
from breastrig.scan.landmarks.marks import LISTED, check_mark_names, listed, with_marks

KNOWN = {
    "nipple_L": ("Left nipple", ""),
    "nipple_R": ("Right nipple", ""),
    "mid_sternum": ("Middle of the sternum", ""),
    "umbilicus": ("Umbilicus", ""),
}
PLACES = {"nipple_L": np.array([10.0, 20.0, 30.0])}
MARKS = {"mole 1": np.array([1.5, -2.0, 3.25]), "=tape, end": np.array([4.0, 5.0, 6.0])}


def read(content: bytes) -> Picks:
    return landmarks_of_file(content, lambda: (1e-3, (np.zeros(3), np.full(3, 0.03))))


@pytest.mark.parametrize("kind", ["json", "csv", "pp", "mrk.json"])
def test_marks_come_back_from_each_kind_of_file(kind: str) -> None:
    found = with_marks(read(landmark_file(PLACES, kind, "mm", marks=MARKS)), KNOWN)
    assert found.points_mm == {"nipple_L": [10.0, 20.0, 30.0]}
    first, second = MARKS
    quoted = f"'{second}" if kind == "csv" else second  # which a spreadsheet would run otherwise
    assert found.marks_mm == {first: [1.5, -2.0, 3.25], quoted: [4.0, 5.0, 6.0]}


def test_a_file_may_hold_marks_alone_in_its_own_unit() -> None:
    found = read(json.dumps({"marks": {"mole": [0.1, 0.2, 0.3]}, "unit": "cm"}).encode())
    assert (found.points_mm, found.marks_mm) == ({}, {"mole": pytest.approx([1.0, 2.0, 3.0])})
    bare = read(json.dumps({"nipple_L": [1, 2, 3], "marks": {"mole": [4, 5, 6]}}).encode())
    assert (list(bare.points_mm), list(bare.marks_mm)) == (["nipple_L"], ["mole"])


def test_names_among_the_landmarks_of_our_own_file_stay_landmarks() -> None:
    found = with_marks(read(b'{"landmarks": {"mole": [1, 2, 3]}}'), KNOWN)
    assert (list(found.points_mm), found.marks_mm) == (["mole"], {})


@pytest.mark.parametrize(
    ("name", "near"),
    [
        *[("nipple_L", "nipple_L"), ("nipple_Left", "nipple_L"), ("Nipple L", "nipple_L"), ("nippel_L", "nipple_L")],
        *[("nipple_l2", "nipple_L"), ("nipple", "nipple_"), ("umbilicus 2", "umbilicus")],
    ],
)
def test_a_name_near_that_of_a_landmark_is_asked_about(name: str, near: str) -> None:
    with pytest.raises(BadLandmarks, match=rf'^Is "{name}" the landmark {near}.*; if not, give .* another name\.$'):
        check_mark_names([name], KNOWN)
    if name in ("nippel_L", "nipple_l2", "nipple"):
        with pytest.raises(BadLandmarks, match=f'^Is "{name}"'):
            with_marks(read(f"{name},1,2,3\n".encode()), KNOWN)


def test_names_far_from_all_landmarks_are_marks() -> None:
    check_mark_names(["mole 1", "mid_sternum_dot", "scar below nipple_L", "Leberfleck", "痣"], KNOWN)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b'{"marks": [[1, 2, 3]]}', '"marks" in this landmark file must be places by name'),
        (b'{"marks": {"mole": [1, 2]}}', 'The mark "mole" needs three numbers'),
        (b'{"marks": {"mole": [1, 2, NaN]}}', "not a finite number"),
        (b'{"marks": {"mole": [1, 2, 3], "mole ": [1, 2, 3]}}', 'The mark "mole" stands twice'),
        (b'{"marks": {" ": [1, 2, 3]}}', "A mark in this file has no proper name"),
        (b'{"marks": {}}', "holds no landmarks"),
        (b'{"marks": {"a\\nb": [1, 2, 3]}}', "has no proper name"),
    ],
)
def test_marks_that_cannot_be_used_are_refused_in_one_sentence(content: bytes, says: str) -> None:
    with pytest.raises(BadLandmarks, match=says):
        with_marks(read(content), KNOWN)


def test_a_mark_stands_once() -> None:
    with pytest.raises(BadLandmarks, match='"mole" stands twice'):
        with_marks(Picks({"mole": [1.0, 2.0, 3.0]}, marks_mm={"mole": [1.0, 2.0, 3.0]}, open_names=True), KNOWN)


def test_many_names_are_listed_in_short() -> None:
    names = [f"m{k}" for k in range(LISTED + 2)]
    assert listed(names).endswith(f"m{LISTED - 1}, 2 more")

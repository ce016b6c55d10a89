"""Lesions of further files have names of their own, and none is there twice."""

import numpy as np

from breastrig.scan.images.added_lesions import taken
from breastrig.scan.piece import BallInside, TakenSegment


def ball(name: str, x: float, radius: float = 6.0) -> BallInside:
    return BallInside(name, np.array([x, 20.0, 30.0]), radius)


def test_names_go_on_after_those_that_are_there() -> None:
    found = [ball("Lesion 1", 10.0), ball("Lesion 2, part 1", 20.0), ball("Lesion 2, part 2", 30.0)]
    segments = [TakenSegment(n, name, "lesion", "Its codes say so.") for n, name in ((4, "Lesion 1"), (7, "Lesion 2"))]
    segments.append(TakenSegment(9, "Tissue 1", "tissue", "Its codes say so."))
    named = taken(found, segments, ["A note."], [ball("Lesion 1", 90.0)], ["Lesion 3, part 2", "left upper"])
    assert [each.name for each in named.lesions] == ["Lesion 4", "Lesion 5, part 1", "Lesion 5, part 2"]
    assert [each.name for each in named.segments] == ["Lesion 4", "Lesion 5", "Tissue 1"]
    assert all(each.is_new for each in named.lesions)
    assert named.notes == ("A note.",)


def test_what_is_there_is_not_taken_twice() -> None:
    there = ball("left upper", 10.0)
    found = [ball("Lesion 1", 10.02, 6.05), ball("Lesion 2", 10.0, 6.5), ball("Lesion 3", 10.0, 6.5)]
    named = taken(found, [TakenSegment(1, "Lesion 1", "lesion", "Its codes say so.")], [], [there])
    assert [(each.name, each.is_new) for each in named.lesions] == [
        ("left upper", False), ("Lesion 1", True), ("Lesion 1", False),
    ]  # fmt: skip
    assert named.segments[0].name == "left upper"

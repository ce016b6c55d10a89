"""Crosses that mark a landmark, and crosses that mark something else."""

from typing import Any

import numpy as np
import pytest
from helpers.painted_body import painted_body
from PIL import Image

from breastrig.colour.features import crosses, observe
from breastrig.colour.features.crosses import marked_by_crosses
from breastrig.colour.features.limits import features
from breastrig.colour.features.observation import Expectation, Observation
from breastrig.colour.features.observe import (
    BETWEEN_CROSSES,
    CROSSED,
    observed_landmarks,
)
from breastrig.colour.ink.find_ink import MARKERS, InkLine
from breastrig.colour.ink.kinds import Kind
from breastrig.core.arrays import Array
from breastrig.geometry.polyline import Polyline

LEFT, UP, FRONT = np.eye(3)
NOTCH, XIPHOID = np.array([0.0, 0.5, 0.07]), np.array([0.0, 0.3, 0.15])
EXPECTED = {"suprasternal_notch": NOTCH, "xiphoid": XIPHOID}


def moved(place: Array, *by: float) -> Array:
    return place + np.array(by)


def stroke(middle: Array, kind: Kind) -> InkLine:
    points = middle + 0.006 * np.array([[-1.0, -1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0]])
    line = Polyline("ink", False, "#000000", points, np.zeros(3, dtype=np.bool_))
    return InkLine(line, kind, MARKERS[0], 0.017)


@pytest.mark.parametrize(
    ("strokes", "named"),
    [
        ([(moved(NOTCH, 0.004, -0.015, 0.0), Kind.CROSS)], {"suprasternal_notch"}),
        ([(moved(NOTCH, 0.004, -0.015, 0.0), Kind.LINE)], set()),
        ([(moved(NOTCH, 0.030, 0.0, 0.0), Kind.CROSS)], set()),  # beside the midline
        ([(moved(NOTCH, 0.0, -0.045, 0.0), Kind.CROSS)], set()),  # as far as the form rules out
        ([(moved(XIPHOID, 0.0, 0.02, 0.0), Kind.CROSS), (moved(XIPHOID, 0.0, -0.02, 0.0), Kind.CROSS)], set()),
        ([(XIPHOID, Kind.CROSS), (moved(XIPHOID, 0.002, 0.001, 0.0), Kind.CROSS)], {"xiphoid"}),  # its two arms
    ],
)
def test_a_cross_marks_a_landmark_of_the_midline_where_the_form_has_it(
    strokes: list[tuple[Array, Kind]], named: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(crosses, "find_ink", lambda _, **_more: tuple(stroke(*each) for each in strokes))
    scan = painted_body(side=640).scan
    found = marked_by_crosses(scan, EXPECTED, dict.fromkeys(EXPECTED, 0.015), LEFT, features().crosses)
    assert set(found) == named
    for name, each in found.items():
        assert np.linalg.norm(each.place - EXPECTED[name]) < 0.017


def test_the_picture_is_decoded_once_also_when_crosses_are_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    scan = painted_body(side=640).scan
    opened: list[object] = []
    open_picture = Image.open

    def counted(*arguments: Any, **options: Any) -> Image.Image:
        opened.append(arguments)
        return open_picture(*arguments, **options)

    monkeypatch.setattr(Image, "open", counted)
    place = scan.vertices[scan.vertices[:, 2].argmax()]
    expected = {name: Expectation(place, FRONT, 0.015) for name in (*CROSSED, "nipple_L")}
    observed_landmarks(scan, expected, LEFT, UP)
    assert len(opened) == 1


def middle_of(crossed: dict[str, Observation], form: Array, monkeypatch: pytest.MonkeyPatch) -> Observation | None:
    monkeypatch.setattr(observe, "marked_by_crosses", lambda *_: crossed)
    expected = {name: Expectation(place, FRONT, 0.015) for name, place in EXPECTED.items()}
    expected[BETWEEN_CROSSES] = Expectation(form, FRONT, 0.017)
    return observed_landmarks(painted_body(side=640).scan, expected, LEFT, UP).get(BETWEEN_CROSSES)


def test_the_middle_of_the_breast_bone_is_between_two_crosses_along_the_skin(monkeypatch: pytest.MonkeyPatch) -> None:
    true = painted_body(side=640).body.landmarks
    error = features().crosses.error
    crossed = {name: Observation(true[name], error**2 / 2.0 * np.eye(3), "") for name in CROSSED}
    seen = middle_of(crossed, moved(true[BETWEEN_CROSSES], 0.0, 0.015, 0.0), monkeypatch)
    assert np.linalg.norm(seen.place - true[BETWEEN_CROSSES]) < 0.002
    assert seen.reason == "between two crosses"
    assert features().crosses.between < seen.error < 0.007
    chord = 0.5 * (true[CROSSED[0]] + true[CROSSED[1]])
    assert np.linalg.norm(chord - true[BETWEEN_CROSSES]) > 0.003  # straight through the body it is another place


def test_the_middle_is_left_to_the_form_without_both_crosses_and_where_the_form_rules_it_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    true = painted_body(side=640).body.landmarks
    crossed = {name: Observation(true[name], 1e-5 * np.eye(3), "") for name in CROSSED}
    assert middle_of({"xiphoid": crossed["xiphoid"]}, true[BETWEEN_CROSSES], monkeypatch) is None
    assert middle_of(crossed, moved(true[BETWEEN_CROSSES], 0.0, 0.06, 0.0), monkeypatch) is None
    off = {name: Observation(moved(each.place, 0.5, 0.0, 0.0), each.covariance, "") for name, each in crossed.items()}
    assert middle_of(off, true[BETWEEN_CROSSES], monkeypatch) is None

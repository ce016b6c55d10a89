"""The tape sheet: key points, landmarks that look from different sides, lengths along the skin."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.geometry.polyline import Polyline
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.body_frame import body_frame
from breastrig.report.stance import Stance
from breastrig.report.tape import FOUND, key_points, sharp_turns, tape_points
from breastrig.rig.model import Rig


@pytest.fixture(scope="module")
def torso() -> Rig:
    return read_rig(default_rig_path())


def line(points: np.ndarray, closed: bool = False, error: float | None = None) -> Polyline:
    errors = None if error is None else np.full(len(points), error)
    return Polyline("cut", closed, "#000000", points, np.zeros(len(points), np.bool_), error=errors)


def stance_with(torso: Rig, *lines: Polyline) -> Stance:
    return Stance(torso, torso.template, torso.template, torso.faces, "standing", lines=lines)


def test_a_point_on_the_way_between_two_landmarks_is_as_far_from_both_as_they_are_apart(torso: Rig) -> None:
    rig = torso
    marks = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))
    middle = marks["mid_sternum"]
    (point,) = tape_points(stance_with(torso, line(middle[None], error=0.004)))
    assert (point.line, point.point, point.error_mm) == ("cut", "place", 4.0)
    lengths = dict(point.lengths_mm)
    assert len(lengths) == 3
    assert {*lengths} <= {*FOUND}
    for name, mm in lengths.items():
        straight = 1e3 * np.linalg.norm(marks[name] - middle)
        assert straight <= mm + 1e-6 < 1.25 * straight + 5.0
    assert [mm for _, mm in point.lengths_mm] == sorted(lengths.values())


def test_three_lengths_and_the_skin_say_where_the_point_is(torso: Rig) -> None:
    """Of all vertices only those next to the point have its lengths: the sheet can be drawn from."""
    from breastrig.geometry.geodesic import Geodesics
    from breastrig.geometry.surface_points import SurfacePoints

    rig = torso
    breast = rig.regions["breast_L"]
    there = rig.template[breast[::40]]
    geodesics = Geodesics(rig.template, rig.faces)
    marks = dict(zip(rig.landmark_names, range(len(rig.landmark_names)), strict=True))
    places: SurfacePoints = rig.landmark_points()
    for point, at in zip(tape_points(stance_with(torso, *(line(one[None]) for one in there))), there, strict=True):
        off = np.zeros(len(rig.template))
        for name, mm in point.lengths_mm:
            k = marks[name]
            off += (1e3 * geodesics.distances(int(places.faces[k]), places.barycentric[k]) - mm) ** 2
        front = rig.template[:, 2] > 0.0
        found = rig.template[np.flatnonzero(front)[off[front].argmin()]]
        assert np.linalg.norm(found - at) < 0.012


def test_a_closed_line_has_four_key_points_and_an_open_one_its_ends_and_corners(torso: Rig) -> None:
    frame = body_frame(torso, torso.template)
    centre = torso.template[torso.regions["breast_L"]].mean(axis=0)
    angles = 2.0 * np.pi * np.arange(40) / 40
    ring = centre + 0.02 * (np.cos(angles)[:, None] * frame.axes[:, 0] + np.sin(angles)[:, None] * frame.axes[:, 1])
    named = dict(key_points(line(ring, closed=True), frame))
    assert {name: ring[k].round(6).tolist() for name, k in named.items()} == {
        name: (centre + 0.02 * way).round(6).tolist()
        for name, way in (
            ("upper", frame.axes[:, 1]), ("lower", -frame.axes[:, 1]),
            ("medial", -frame.axes[:, 0]), ("lateral", frame.axes[:, 0]),
        )
    }  # fmt: skip
    way = np.concatenate(
        [np.linspace([0, 0, 0], [0.05, 0, 0], 20), np.linspace([0.05, 0.0025, 0], [0.05, 0.05, 0], 19)]
    )
    assert sharp_turns(way) == [19]
    assert [name for name, _ in key_points(line(way), frame)] == ["start", "end", "corner 1"]
    assert [name for name, _ in key_points(line(way[:15]), frame)] == ["start", "end", "middle"]


def test_a_drawing_of_nothing_and_a_rig_with_few_landmarks_have_no_sheet(torso: Rig, toy_rig: Rig) -> None:
    assert tape_points(stance_with(torso)) == []
    few = replace(toy_rig, landmarks=toy_rig.landmarks[:2])
    assert (
        tape_points(Stance(few, few.template, few.template, few.faces, "standing", lines=(line(few.template[:3]),)))
        == []
    )

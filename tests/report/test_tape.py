"""The tape sheet: key points, landmarks that look from different sides, lengths along the skin."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.blank_pictures import blank_pictures
from scipy.optimize import least_squares

from breastrig.drawings.clock import FittedSkin, circle_around, on_clock
from breastrig.geometry.polyline import Polyline
from breastrig.geometry.rotations import exp_so3
from breastrig.report.body_frame import body_frame
from breastrig.report.pages.names import spoken
from breastrig.report.pages.tape import (
    FOUND,
    LAID,
    NINE_OF_TEN,
    READ,
    _spread,
    key_points,
    sharp_turns,
    tape_points,
)
from breastrig.report.pages.tape_sheet import ROOM, SIZE, tape_sheet
from breastrig.report.stance import Place, Stance
from breastrig.rig.model import Rig


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
    assert (point.line, point.point) == ("cut", "place")
    assert point.error_mm is None, "nobody knows how far off the landmarks are"
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


def known(torso: Rig, radius: float, picked: tuple[str, ...], *lines: Polyline) -> Stance:
    marks = dict(zip(torso.landmark_names, torso.landmark_points().positions(torso.template, torso.faces), strict=True))
    radii = {name: 0.004 if name in picked else radius for name in marks}
    return replace(stance_with(torso, *lines), picked={name: marks[name] for name in picked}, landmark_radii=radii)


def test_the_tape_starts_from_picked_landmarks_and_says_how_far_off_those_of_the_model_may_be(torso: Rig) -> None:
    at = line(torso.template[torso.regions["breast_L"][:1]])
    picked = ("suprasternal_notch", "nipple_R", "umbilicus")
    (point,) = tape_points(known(torso, 0.014, picked, at))
    assert {name for name, _ in point.lengths_mm} == {*picked}, "though others are nearer"
    rough = known(torso, 0.001, picked, at)
    (still,) = tape_points(replace(rough, landmark_radii={**rough.landmark_radii, **dict.fromkeys(picked, 0.02)}))
    assert {name for name, _ in still.lengths_mm} == {*picked}, "though others are said to be surer"
    (by_the_model,) = tape_points(known(torso, 0.014, (), at))
    assert 2.0 < point.error_mm < 8.0 < by_the_model.error_mm


def test_what_carrying_a_line_adds_is_in_the_sheet(torso: Rig) -> None:
    place = torso.template[torso.regions["breast_L"][:1]]
    here, carried = (tape_points(known(torso, 0.01, FOUND, line(place, error=error)))[0] for error in (None, 0.012))
    assert here.error_mm is not None
    assert carried.error_mm == pytest.approx(np.hypot(here.error_mm, 12.0))


def test_the_error_holds_nine_of_ten_points_that_are_found_by_three_arcs() -> None:
    """Flat skin: landmarks are off by as much as their radii say, the tape by what it is read wrongly."""
    random = np.random.default_rng(5)
    marks = np.array([[0.12, 0.02, 0.0], [-0.05, 0.1, 0.0], [0.02, -0.15, 0.0]])
    radii = np.array([0.004, 0.009, 0.006])
    sources = [Place(f"mark {k}", marks[k], "picked", radii[k]) for k in range(3)]
    radius = _spread(np.zeros(3), np.array([0.0, 0.0, 1.0]), sources)
    far = np.linalg.norm(marks, axis=1)
    off = []
    for _ in range(600):
        true = marks[:, :2] + random.normal(size=(3, 2)) * radii[:, None] / NINE_OF_TEN
        tape = far + random.normal(size=3) * (READ + LAID * far) / NINE_OF_TEN
        weights = NINE_OF_TEN / np.hypot(radii, READ + LAID * far)
        found = least_squares(lambda p, m=true, d=tape, w=weights: w * (np.linalg.norm(m - p, axis=1) - d), np.zeros(2))
        off.append(float(np.linalg.norm(found.x)))
    assert np.mean(np.array(off) < radius) == pytest.approx(0.9, abs=0.03)


def test_a_circle_is_one_centre_with_its_radius_and_a_shared_end_is_one_point(torso: Rig) -> None:
    skin = FittedSkin(torso, torso.template, {})
    nipple = skin.landmark("nipple_L")
    aside = on_clock(skin, nipple, 0.05, np.array([1.2]))
    rings = [skin.at(circle_around(skin, centre, 0.02)) for centre in (nipple, aside)]
    ends = skin.at(aside)[0] + np.array([[0.0, 0.03, 0.0], [0.0, 0.05, 0.0], [0.0, 0.07, 0.01]])
    lines = (*(line(ring, closed=True) for ring in rings), line(ends[:2]), line(ends[[0, 2]]))
    kept, moved, *others = tape_points(known(torso, 0.01, FOUND, *lines))
    assert (kept.point, kept.around, kept.lengths_mm) == ("centre", "nipple_L", ())
    assert kept.radius_mm == pytest.approx(20.0, abs=0.5)
    assert (moved.point, moved.around) == ("centre", "")
    assert moved.radius_mm == pytest.approx(20.0, abs=1.0)
    assert np.linalg.norm(moved.at - skin.at(aside)[0]) < 0.003
    assert [point.point for point in others] == ["start", "end", "end"]
    outwards = np.linalg.svd(rings[1] - rings[1].mean(axis=0))[2][2]
    rough = rings[1] + np.outer(np.random.default_rng(3).normal(0.0, 0.0008, len(rings[1])), outwards)  # as scans are
    assert [point.point for point in tape_points(known(torso, 0.01, FOUND, line(rough, closed=True)))] == ["centre"]
    teardrop = rings[1].copy()
    teardrop[:3] += 0.6 * (rings[1][:3] - rings[1].mean(axis=0))
    (*corners,) = tape_points(known(torso, 0.01, FOUND, line(teardrop, closed=True)))
    assert {point.point for point in corners} <= {"upper", "lower", "medial", "lateral"}, "it is no circle"
    mark = skin.at(circle_around(skin, aside, 0.003))
    (one,) = tape_points(known(torso, 0.01, FOUND, line(mark, closed=True)))
    assert (one.point, one.around) == ("centre", ""), "a nipple's new place is one point, however it was carried"


def test_a_drawing_of_nothing_and_a_rig_with_few_landmarks_have_no_sheet(torso: Rig, toy_rig: Rig) -> None:
    assert tape_points(stance_with(torso)) == []
    few = replace(toy_rig, landmarks=toy_rig.landmarks[:2])
    assert (
        tape_points(Stance(few, few.template, few.template, few.faces, "standing", lines=(line(few.template[:3]),)))
        == []
    )


def test_the_picture_has_each_number_where_the_body_has_the_place_and_none_over_another(
    torso: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Her left is to the right and her head up, whatever the scan's own axes are; one scale, as on the scan."""
    blank_pictures(monkeypatch)
    turn = exp_so3(np.array([0.3, -1.1, 0.7]))
    skin = FittedSkin(torso, torso.template, {})
    ring = skin.at(circle_around(skin, skin.landmark("nipple_R"), 0.02))
    places = torso.template[torso.regions["breast_L"][[0, 1, 40]]]
    lines = [replace(line(place[None] @ turn.T), name=f"cut_{k}_L") for k, place in enumerate(places)]
    at_rest = known(torso, 0.01, FOUND, *lines, replace(line(ring @ turn.T, True, 0.005), name="areola_R"))
    stance = replace(
        at_rest,
        vertices=torso.template @ turn.T,
        scan_vertices=torso.template @ turn.T,
        picked={name: place @ turn.T for name, place in at_rest.picked.items()},
    )
    sheet = tape_sheet("standing", stance)
    assert [row["line"] for row in sheet["rows"]] == [
        "Cut 0, left",
        "Cut 1, left",
        "Cut 2, left",
        "Areola to keep, right",
    ]
    assert [row["point"] for row in sheet["rows"][3:]] == ["around the nipple, right, radius 20 mm"]
    assert [bool(row["error"]) for row in sheet["rows"]] == [True, True, True, False]
    letters = {spoken(name): at_rest.picked[name] for name in FOUND}
    nipple = at_rest.picked["nipple_R"]
    shown = np.array([*places, nipple, *(letters[name] for _, name, _, _ in sheet["landmarks"])])
    at = np.array([[dot["x"], dot["y"]] for dot in sheet["dots"]])
    assert [dot["mark"] for dot in sheet["dots"]] == [False] * 4 + [True] * len(sheet["landmarks"])
    frame = body_frame(torso, torso.template)
    from_first = np.stack([frame.lateral(shown), -frame.height(shown)], axis=1)
    from_first -= from_first[0]
    scale = np.ptp(at, axis=0) / np.ptp(from_first, axis=0)
    assert scale[0] == pytest.approx(scale[1], rel=1e-3)
    np.testing.assert_allclose(at - at[0], scale[0] * from_first, atol=0.3)
    assert (at > 0.0).all()
    assert (at < SIZE).all()
    labels = np.array([[dot["lx"], dot["ly"]] for dot in sheet["dots"]])
    gaps = np.abs(labels[:, None] - labels)[~np.eye(len(labels), dtype=bool)]
    assert (gaps > np.array(ROOM) - 0.2).any(axis=1).all()

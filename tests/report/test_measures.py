"""Lengths, ratios and volumes where the answer is known: on the symmetric model, on picks, and in a mirror."""

import csv
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from breastrig.core.stances import OUTWARDS, SIDES
from breastrig.report import volume as volume_module
from breastrig.report.body_frame import body_frame
from breastrig.report.calibration import measure_calibration
from breastrig.report.measures import measures
from breastrig.report.stance import Stance, places
from breastrig.report.table import (
    Row,
    Value,
    contradictions,
    csv_bytes,
    flat_rows,
    less,
    with_margin,
)
from breastrig.report.volume import vertices_within
from breastrig.rig.model import Rig

pytestmark = pytest.mark.long

LENGTHS = ("notch_nipple", "midclavicle_nipple", "nipple_fold", "nipple_midline", "nipple_nipple", "base_width")
NONE = Value(np.nan)
TOLERANCE = {
    "mm": 0.1,
    "ml": 0.5,
    "1": 1e-3,
    "grade": 1e-9,
}  # the mesh is mirrored to the micrometre, shortest ways nearly


def by_name(rows: tuple[Row, ...]) -> dict[tuple[str, str], Row]:
    return {(row.measure, row.kind): row for row in rows}


@pytest.fixture(scope="module")
def of_the_asymmetric(asymmetric: Stance) -> dict[tuple[str, str], Row]:
    return by_name(measures(asymmetric))


@pytest.fixture(scope="module")
def of_at_rest(at_rest: Stance) -> dict[tuple[str, str], Row]:
    return by_name(measures(at_rest))


def test_every_length_is_given_straight_and_along_the_skin_and_says_how(
    of_the_asymmetric: dict[tuple[str, str], Row],
) -> None:
    assert ("base_width", "along the skin") not in of_the_asymmetric  # callipers measure it
    for name in LENGTHS[:-1]:
        straight, tape = of_the_asymmetric[name, "straight"], of_the_asymmetric[name, "along the skin"]
        for row in (straight, tape):
            assert row.landmarks
            assert row.method
        for a, b in ((straight.left, tape.left), (straight.right, tape.right), (straight.value, tape.value)):
            assert (a is None) == (b is None)
            if a is not None and b is not None:
                assert 20.0 < a.value <= b.value + 1e-6 < 400.0


def test_a_symmetric_model_has_ratios_of_1_and_differences_of_0(of_at_rest: dict[tuple[str, str], Row]) -> None:
    rows = of_at_rest.values()
    assert {row.measure for row in rows} == {*LENGTHS, "volume", "M1", "M2", "M3", "M4", "M5", "M6"}, (
        "name a new measure in LENGTHS above, before base_width"
    )
    for row in rows:
        if row.kind == "ratio":
            assert row.value.value == pytest.approx(1.0, abs=1e-3)
        elif row.difference is not None:
            assert row.difference.value == pytest.approx(0.0, abs=TOLERANCE[row.unit])


def test_a_mirrored_patient_exchanges_left_and_right(
    of_the_asymmetric: dict[tuple[str, str], Row], mirrored: Stance
) -> None:
    there = by_name(measures(mirrored))
    assert there.keys() == of_the_asymmetric.keys()
    for key, row in of_the_asymmetric.items():
        for a, b in ((row.left, there[key].right), (row.right, there[key].left), (row.value, there[key].value)):
            assert (a is None) == (b is None)
            if a is not None and b is not None:
                assert a.value == pytest.approx(b.value, abs=TOLERANCE[row.unit]), key


def test_the_larger_breast_has_more_volume_and_a_longer_way_to_the_notch(
    of_the_asymmetric: dict[tuple[str, str], Row],
) -> None:
    volume = of_the_asymmetric["volume", "volume"]
    assert volume.left.value > volume.right.value + 50.0
    for side in (volume.left, volume.right):
        assert 0.0 < side.low < side.value < side.high
    for kind in ("straight", "along the skin"):
        difference = of_the_asymmetric["notch_nipple", kind].difference
        assert difference.value > 3.0
    ratios = [row.value.value for row in of_the_asymmetric.values() if row.kind == "ratio" and row.value]
    assert all(0.0 <= ratio <= 1.0 for ratio in ratios)
    assert min(ratios) < 0.95


def test_a_turned_and_moved_patient_measures_the_same(
    of_the_asymmetric: dict[tuple[str, str], Row], asymmetric: Stance
) -> None:
    angle = 1.1
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    turn = turn @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    moved = replace(
        asymmetric,
        vertices=asymmetric.vertices @ turn.T + [3.0, -2.0, 1.0],
        scan_vertices=asymmetric.scan_vertices @ turn.T + [3.0, -2.0, 1.0],
    )
    there = by_name(measures(moved))
    for key, row in of_the_asymmetric.items():
        for a, b in ((row.left, there[key].left), (row.right, there[key].right), (row.value, there[key].value)):
            if a is not None and b is not None:
                assert a.value == pytest.approx(b.value, abs=0.2 * TOLERANCE[row.unit]), key


def test_picked_landmarks_win_and_every_row_says_so(rig: Rig, asymmetric: Stance) -> None:
    at = dict(zip(rig.landmark_names, rig.landmark_points().positions(asymmetric.vertices, rig.faces), strict=True))
    pick = at["nipple_L"] + [0.0, 0.004, 0.003]
    rows = by_name(measures(replace(asymmetric, picked={"nipple_L": pick})))
    row = rows["notch_nipple", "straight"]
    assert row.left.value == pytest.approx(1e3 * np.linalg.norm(pick - at["suprasternal_notch"]), abs=1e-9)
    assert "nipple_L (picked)" in row.landmarks
    assert "suprasternal_notch (model)" in row.landmarks
    assert "nipple_R (model)" in row.landmarks


def test_a_rig_without_outlines_has_the_lengths_that_its_landmarks_allow(toy_rig: Rig) -> None:
    scan = np.array(toy_rig.template)
    rows = by_name(measures(Stance(toy_rig, scan, scan, toy_rig.faces, "standing")))
    assert set(rows) == {
        *((name, kind) for name in ("notch_nipple", "nipple_nipple") for kind in ("straight", "along the skin")),
        ("M1", "ratio"),
        ("M3", "ratio"),
    }


def test_the_base_is_as_wide_as_callipers_held_in_front_of_the_chest_find_it(
    of_at_rest: dict[tuple[str, str], Row], at_rest: Stance
) -> None:
    width = of_at_rest["base_width", "straight"].left
    outline = at_rest.shape("breast_base_L")
    line = outline.points.positions(at_rest.vertices, at_rest.rig.faces)
    assert width.value == pytest.approx(1e3 * np.ptp(line[:, 0]), abs=0.5)  # not 147 mm, the way through the chest


def test_a_lying_patient_has_no_base_width(at_rest: Stance) -> None:
    assert "base_width" not in {row.measure for row in measures(replace(at_rest, name="supine"))}


def test_what_a_fits_outline_is_off_is_taken_off_and_its_error_grows_with_the_radii(
    of_at_rest: dict[tuple[str, str], Row], at_rest: Stance
) -> None:
    """As much at the width's two ends as all around the volume; where no radii are known raters' 5 mm stay."""
    known = measure_calibration(at_rest.rig)
    plain = of_at_rest
    sure, unsure = (
        by_name(measures(replace(at_rest, radii=np.full(len(at_rest.vertices), radius)))) for radius in (0.004, 0.012)
    )
    width, volume = ("base_width", "straight"), ("volume", "volume")
    for rows in (sure, unsure):
        assert (rows[width].left or NONE).value - (plain[width].left or NONE).value == pytest.approx(
            2e3 * known.standing.outwards, abs=1e-6
        )
        left = body_frame(at_rest.rig, at_rest.vertices).axes[:, 0]
        for side in ("left", "right"):
            grown, before = (found[width].paths[side] @ left for found in (rows, plain))
            assert grown - before == pytest.approx(known.standing.outwards * np.array([-1.0, 1.0]), abs=1e-9)
    half = 1e3 * known.base_width.of(0.012 * np.sqrt(2.0))
    assert (unsure[width].left or NONE).high == pytest.approx((unsure[width].left or NONE).value + half)
    bands = [rows[volume].left or NONE for rows in (plain, sure, unsure)]
    assert bands[1].value == pytest.approx(bands[2].value)
    assert bands[1].value > bands[0].value
    spans = [(each.high or 0.0) - (each.low or 0.0) for each in bands]
    assert spans[1] < spans[2]
    assert spans[2] / spans[1] == pytest.approx(known.standing.of(0.012) / known.standing.of(0.004), rel=0.1)


def test_bands_are_as_wide_as_the_radii_of_the_ends_say(
    of_at_rest: dict[tuple[str, str], Row], at_rest: Stance
) -> None:
    radii = dict.fromkeys(at_rest.rig.landmark_names, 0.003) | {"nipple_L": 0.004}
    known = replace(at_rest, landmark_radii=radii, radii=np.full(len(at_rest.vertices), 0.006))
    rows = by_name(measures(known))
    notch = rows["notch_nipple", "straight"].left
    assert notch.high - notch.value == pytest.approx(5.0)
    assert notch.value - notch.low == pytest.approx(5.0)
    for row in rows.values():
        for value in (row.left, row.right, row.value):
            assert value is None or (value.low is not None and value.low <= value.value <= (value.high or 0.0))
    assert rows["M1", "ratio"].value.high == 1.0  # a ratio cannot be more
    for row in of_at_rest.values():
        assert row.kind == "volume" or all(value is None or value.low is None for value in (row.left, row.value))


def test_every_row_has_the_lines_that_were_measured_and_they_are_as_long_as_it_says(
    of_the_asymmetric: dict[tuple[str, str], Row],
) -> None:
    rows = tuple(of_the_asymmetric.values())
    for row in rows:
        sides = {"left": row.left, "right": row.right, "value": row.value}
        if row.unit == "mm":
            assert set(row.paths) == {name for name, value in sides.items() if value is not None}
            for name, line in row.paths.items():
                value = sides[name]
                walked = 1e3 * np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
                assert walked == pytest.approx(abs(value.value), abs=1e-6), (row.measure, row.kind)
        elif row.measure == "M1":
            assert set(row.paths) == {"value"}
        else:
            assert set(row.paths) == {"left", "right"}


def test_a_straight_line_has_two_ends_and_a_tape_lies_on_the_fitted_skin(
    of_the_asymmetric: dict[tuple[str, str], Row], asymmetric: Stance
) -> None:
    for row in of_the_asymmetric.values():
        for line in row.paths.values():
            if row.kind == "straight":
                assert line.shape == (2, 3)
            if row.kind == "along the skin":
                on = asymmetric.on_model(line).positions(asymmetric.vertices, asymmetric.rig.faces)
                assert np.abs(on - line).max() < 1e-6
            if row.kind == "volume":
                assert np.array_equal(line[0], line[-1])


def test_lines_leave_in_millimetres_with_the_row_and_not_with_the_table_or_a_change(
    of_the_asymmetric: dict[tuple[str, str], Row],
) -> None:
    rows = tuple(of_the_asymmetric.values())
    flat = flat_rows([("standing", rows), ("supine", rows)])
    for row, cells in zip(rows, flat, strict=False):
        paths = cells["paths"]
        assert isinstance(paths, dict)
        for name, line in row.paths.items():
            assert np.allclose(paths[name], 1e3 * line, atol=0.051)
    assert [cells["paths"] for cells in flat if cells["stance"] == "supine - standing"] == [None] * len(
        [row for row in rows if row.unit != "grade"]
    )
    text = csv_bytes(flat, {"standing": "good", "supine": "check"}).decode()
    assert "paths" not in text
    verdicts = {(row["stance"], row["verdict"]) for row in csv.DictReader(text.splitlines())}
    assert verdicts == {("standing", "good"), ("supine", "check"), ("supine - standing", "check")}


def test_a_number_is_written_as_finely_as_its_band_allows() -> None:
    assert with_margin(Value(201.34), "mm") == "201.3"
    assert with_margin(Value(201.34, 200.7, 201.9), "mm") == "201.3 ±0.6"
    assert with_margin(Value(201.34, 196.2, 206.5), "mm") == "201 ±5"
    assert with_margin(Value(268.7, 240.1, 297.0), "ml") == "270 ±30"
    assert with_margin(Value(0.9831, 0.93, 1.0), "1") == "0.98 ±0.05"
    change = less(Value(200.0, 197.0, 203.0), Value(210.0, 206.0, 214.0))
    assert change == Value(10.0, 5.0, 15.0)
    assert with_margin(change, "mm", signed=True) == "+10 ±5"
    assert less(Value(1.0), Value(2.0, 1.0, 3.0)) == Value(1.0)


def test_volumes_of_one_breast_that_differ_by_more_than_their_bands_are_said() -> None:
    def volumes(left: float, right: float) -> list[Row]:
        sides = (Value(mean, mean - 20.0, mean + 20.0) for mean in (left, right))
        return [Row("volume", "Volume", "volume", "ml", *sides, None, (), "")]

    standing, alike, less_of_one = volumes(269.0, 262.0), volumes(250.0, 240.0), volumes(245.0, 181.0)
    assert contradictions([("standing", standing)]) == ()
    assert contradictions([("standing", standing), ("supine", alike)]) == ()
    assert contradictions([("standing", standing), ("supine", less_of_one)]) == (
        "The right breast measures 260 ±20 ml standing and 180 ±20 ml supine: one breast differs by less, "
        "nine times of ten; check both fits.",
    )


def test_ratios_compare_the_lowest_and_the_most_lateral_point_of_each_breast(
    asymmetric: Stance, of_the_asymmetric: dict[tuple[str, str], Row]
) -> None:
    frame, rows = body_frame(asymmetric.rig, asymmetric.vertices), of_the_asymmetric
    apart: dict[str, list[float]] = {"M2": [], "M4": [], "M5": [], "M6": []}
    known = places(asymmetric)
    for side, word in SIDES.items():
        skin = asymmetric.vertices[vertices_within(asymmetric.rig, side)]
        low, far = skin[frame.height(skin).argmin()], skin[(OUTWARDS[side] * frame.lateral(skin)).argmax()]
        ends = {"M2": (1, low), "M4": (1, far), "M5": (0, low), "M6": (0, far)}
        for name, (end, place) in ends.items():
            np.testing.assert_array_equal(rows[name, "ratio"].paths[word][end], place)
        nipple, notch = known[f"nipple_{side}"].point, known["suprasternal_notch"].point
        apart["M2"].append(abs(float(frame.height(nipple) - frame.height(low))))
        apart["M4"].append(abs(float(frame.lateral(nipple) - frame.lateral(far))))
        apart["M5"].append(float(frame.height(notch) - frame.height(low)))
        apart["M6"].append(abs(float(frame.lateral(far))))
    for name, pair in apart.items():
        value = rows[name, "ratio"].value
        assert value.value == pytest.approx(min(pair) / max(pair))
        assert value.value < 0.995


def test_the_band_of_a_volume_is_smaller_inwards_and_larger_outwards(
    at_rest: Stance, monkeypatch: pytest.MonkeyPatch
) -> None:
    def above(*words: Any) -> tuple[float, float]:
        level = float(words[-1])
        return 1e-3 - 0.1 * level + 4.0 * level**2, 0.01

    monkeypatch.setattr(volume_module, "volume_above", above)
    found = volume_module.breast_volume(at_rest, "R")
    gap = 0.01 * abs(float(np.nanmean(at_rest.distances[vertices_within(at_rest.rig, "R")])))
    assert found.value == pytest.approx(1e-3)
    assert (found.low, found.high) == pytest.approx((1e-3 - np.hypot(4e-4, gap), 1e-3 + np.hypot(6e-4, gap)))

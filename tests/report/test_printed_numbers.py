"""The numbers of the table as they leave: they agree with each other, and none is of a breast that nobody scanned."""

import csv
import io
import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.results import result_file

from breastrig.core.identity import UNNAMED
from breastrig.report.bands import margin_text, margins_text
from breastrig.report.document import Reported, report_document
from breastrig.report.measures import measures
from breastrig.report.pages.pdf import report_content
from breastrig.report.stance import Stance
from breastrig.report.table import Row, Value, changes, csv_bytes, flat_rows

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")


def row(rng: np.random.Generator, name: str) -> Row:
    def value() -> Value:
        centre, half = rng.uniform(100.0, 300.0), rng.uniform(0.5, 45.0)
        return Value(centre, centre - half, centre + half)

    return Row(name, name, "straight", "mm", value(), value(), None, (), "")


def printed(cell: str) -> float:
    found = NUMBER.match(cell)
    assert found is not None, cell
    return float(found[0])


def test_left_right_and_their_difference_agree_as_they_are_printed(at_rest: Stance, rng: np.random.Generator) -> None:
    stances = [
        Reported(name, at_rest, result_file(), tuple(row(rng, f"measure {k}") for k in range(60)))
        for name in ("standing", "supine")
    ]
    (group,) = report_content(stances, UNNAMED)["measures"]["groups"]
    for label, (first, second, change) in group["rows"]:
        for left, right, difference in (first, second, change):
            assert printed(left) - printed(right) == pytest.approx(printed(difference), abs=1e-9), (label, first)
        for before, after, moved in zip(first[:2], second[:2], change[:2], strict=True):
            assert printed(after) - printed(before) == pytest.approx(printed(moved), abs=1e-9), label


def test_they_agree_in_files_to_the_last_digit(rng: np.random.Generator) -> None:
    before, after = ([row(rng, f"measure {k}") for k in range(60)] for _ in range(2))
    flat = flat_rows([("standing", before), ("supine", after)])
    for one in flat:
        assert round(one["left"] - one["right"], 2) == one["difference"]
    count = len(before)
    for a, b, change in zip(flat[:count], flat[count : 2 * count], flat[2 * count :], strict=True):
        assert round(b["left"] - a["left"], 2) == change["left"]


def test_they_agree_as_they_are_said(rng: np.random.Generator) -> None:
    before, after = ([row(rng, f"measure {k}") for k in range(60)] for _ in range(2))
    said = [one["said"] for one in flat_rows([("standing", before), ("supine", after)])]
    count = len(before)
    for first, second, change in zip(said[:count], said[count : 2 * count], said[2 * count :], strict=True):
        for cells in (first, second, change):
            moved = printed(cells["left"]) - printed(cells["right"])
            assert moved == pytest.approx(printed(cells["difference"]), abs=1e-9)
        assert printed(second["left"]) - printed(first["left"]) == pytest.approx(printed(change["left"]), abs=1e-9)


def test_a_number_is_said_as_finely_as_its_band_allows_and_signed_where_a_direction_is_meant() -> None:
    sides = Row("a", "a", "straight", "mm", Value(201.34), Value(198.1), None, (), "")
    volume = Row("v", "v", "volume", "ml", Value(268.7, 240.1, 297.3), None, None, (), "", not_seen=("right",))
    ratio = Row("r", "r", "ratio", "1", None, None, Value(0.956), (), "")
    grade = Row("p", "p", "grade", "grade", Value(2.0), Value(4.0), None, (), "")
    said = [one["said"] for one in flat_rows([("standing", [sides, volume, ratio, grade])])]
    assert said[0] == {"left": "201.3", "right": "198.1", "difference": "+3.2"}
    assert said[1] == {"left": "270 ±30"}
    assert said[2] == {"value": "0.96"}
    assert said[3] == {"left": "II", "right": "glandular"}


def half_scan(stance: Stance) -> Stance:
    """The same body of which the scan shows the left side and a little beyond."""
    centres = stance.scan_vertices[stance.scan_faces].mean(axis=1)
    return replace(stance, scan_faces=stance.scan_faces[centres[:, 0] > -0.01])


def test_a_breast_that_the_scan_does_not_show_has_no_numbers_at_any_door(asymmetric: Stance) -> None:
    half = half_scan(asymmetric)
    whole = {each.key: each for each in measures(asymmetric)}
    rows = {each.key: each for each in measures(half)}
    assert rows.keys() == whole.keys()
    for key, each in rows.items():
        if each.right is None and each.value is None:
            assert set(each.not_seen) & {"right", "value"}, key
        assert each.right is None, key
        assert each.difference is None
        if whole[key].left is not None:
            assert each.left == whole[key].left, key
        if each.not_seen:
            assert "the scan shows 0 % of the right breast: not seen" in each.method
            assert not set(each.not_seen) & set(each.paths)
    assert rows["volume", "volume"].not_seen == ("right",)
    assert rows["nipple_nipple", "straight"].not_seen == ("value",)
    reported = Reported("standing", half, result_file(), tuple(rows.values()))
    table = csv.DictReader(io.StringIO(csv_bytes(flat_rows([("standing", reported.rows)]), {}).decode()))
    volume = next(each for each in table if each["measure"] == "volume")
    assert (volume["right"], volume["difference"], volume["not_seen"]) == ("", "", "right")
    document = report_document([reported])
    (found,) = (each for each in document["measures"] if each["measure"] == "volume")
    assert (found["right"], found["right_low"], found["not_seen"]) == (None, None, "right")
    groups = report_content([reported], UNNAMED)["measures"]["groups"]
    cells = {label: cells for group in groups for label, (cells,) in group["rows"]}
    assert cells["Volume"][1:] == ["not seen", ""]
    assert cells["Nipple to nipple"] == ["not seen"]


def test_what_was_picked_there_is_measured_and_a_change_says_what_is_missing(asymmetric: Stance) -> None:
    """Whoever picks a nipple has seen it."""
    rig = asymmetric.rig
    names = ("suprasternal_notch", "nipple_R")
    points = rig.landmark_points(names).positions(asymmetric.vertices, rig.faces)
    half = replace(half_scan(asymmetric), picked=dict(zip(names, points, strict=True)))
    rows = {each.key: each for each in measures(half)}
    assert rows["notch_nipple", "straight"].right is not None
    assert rows["volume", "volume"].right is None
    change = {each.key: each for each in changes(measures(asymmetric), tuple(rows.values()))}
    assert change["volume", "volume"].not_seen == ("right",)
    assert change["volume", "volume"].left is not None


def test_half_a_millimetre_is_rounded_up_as_the_page_does() -> None:
    assert [margin_text(mm) for mm in (22.5, 23.5, 22.49)] == ["± 23 mm", "± 24 mm", "± 22 mm"]
    assert margins_text([2.5, 4.5, 61.0]) == "± 3 to 5 mm, 1 not known"

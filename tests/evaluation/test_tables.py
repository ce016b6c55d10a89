"""Tables: families and stances apart, means without what failed or is not known, the same numbers in file and page."""

import csv
from pathlib import Path
from typing import Any

import pytest

from breastrig.evaluation.cohort import Case
from breastrig.evaluation.studies.plan import counts, first_shapes, shape_effects
from breastrig.evaluation.studies.result_cache import Record, Unit
from breastrig.evaluation.tables.accuracy import groups, turn_numbers, turns_table
from breastrig.evaluation.tables.table import Column, Row, Table, mean_row
from breastrig.fitting.recipe import load_recipe
from breastrig.rig.model import Rig


def record(
    family: str, name: str, answer: dict[str, Any], failed: str | None = None, question: str = "random_turns"
) -> Record:
    stance = name.partition("_")[0]
    case = Case("p", name, stance, family, "m", Path(f"/{family}/{name}"))
    return Record(Unit((case,), question, load_recipe("default"), Path("rig.glb")), answer, failed)


def test_families_and_kinds_of_lying_stay_apart() -> None:
    records = [
        record("makehuman", "standing", {}),
        record("makehuman", "supine", {}),
        record("independent", "supine_physics", {}),
        record("independent", "supine", {}),
    ]
    assert [(family, setting) for family, setting, _ in groups(records)] == [
        ("independent", "supine"),
        ("independent", "supine_physics"),
        ("makehuman", "standing"),
        ("makehuman", "supine"),
    ]


def test_a_mean_leaves_out_what_failed_and_what_is_not_known() -> None:
    rows = [Row(("a", 1.0, None)), Row(("b", 3.0, 5.0)), Row(("c", None, None), note="It failed.")]
    assert mean_row(("mean",), rows).cells == ("mean", 2.0, 5.0)
    table = Table("t", "", (Column("who", key=True), Column("x", digits=1), Column("y")), rows)
    written = list(csv.reader(table.csv().splitlines()))
    assert written[1:] == [["a", "1", "", ""], ["b", "3", "5", ""], ["c", "", "", "It failed."]]
    assert table.shown(rows[0]) == [("a", False), ("1.0", True), ("–", True)]


def test_wrong_turns_are_counted_one_by_one() -> None:
    def trial(**wrong: bool) -> dict[str, Any]:
        right = {"up": False, "facing": False, "sides": False}
        numbers = {"surface_mm": 1.0, "truth_mm": None, "landmarks_mm": 10.0}
        return right | wrong | numbers | {"variant": "as_scanned", "failed": None, "stance": "standing"}

    failed = {"variant": "as_scanned", "failed": "No skin."}
    trials = [trial(), trial(up=True, sides=True), trial(facing=True), failed]
    assert turn_numbers(trials, "supine") == [4, 1, 1, 1, 1, 3, 1.0, None, 10.0]
    table = turns_table(
        [record("independent", "supine", {"trials": trials}), record("makehuman", "standing", {}, "Bad.")]
    )
    assert [row.note for row in table.rows] == ["", "", "Bad.", ""]
    assert table.rows[1].mean
    assert table.rows[1].cells[4:] == table.rows[0].cells[4:]


def test_useful_shapes_come_first_and_every_count_has_as_many(rig: Rig) -> None:
    names = rig.shape_names
    effect = {name: float(k % 7) for k, name in enumerate(names)}
    other = dict.fromkeys(names, 0.0) | {names[3]: 14.0}
    fits = [
        record("makehuman", "supine", {"shape_effect_mm": effects}, None, "accuracy") for effects in (effect, other)
    ]
    useful = shape_effects(fits, rig)["supine"]
    assert next(iter(useful)) == names[3]
    assert useful[names[3]] == pytest.approx((3.0 + 14.0) / 2)
    for count in counts(len(names)):
        for order in ("usefulness", "rig"):
            assert len(first_shapes(rig, list(useful), order, count)) == count
    assert first_shapes(rig, list(useful), "rig", 5) == names[:5]
    assert first_shapes(rig, list(useful), "usefulness", 1) == (names[3],)

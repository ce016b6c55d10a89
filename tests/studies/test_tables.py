"""Tables: families and stances apart, means without what failed or is not known, the same numbers in every file."""

import csv
from pathlib import Path
from typing import Any

import pytest

from breastrig.fitting.recipe import load_recipe
from breastrig.rig.model import Rig
from breastrig_studies.cohort import Case
from breastrig_studies.studies.plan import counts, first_shapes, shape_effects
from breastrig_studies.studies.result_cache import Record, Unit
from breastrig_studies.tables.accuracy import groups, turn_numbers, turns_table
from breastrig_studies.tables.breasts import by_breasts, of_all
from breastrig_studies.tables.certainty import believed_table, certainty_table
from breastrig_studies.tables.prone import prone_table
from breastrig_studies.tables.table import Column, Row, Table, mean_row


def record(
    family: str,
    name: str,
    answer: dict[str, Any],
    failed: str | None = None,
    question: str = "random_turns",
    hanging: bool | None = None,
) -> Record:
    stance = name.partition("_")[0]
    case = Case("p", name, stance, family, "m", Path(f"/{family}/{name}"), hanging)
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
    written = list(csv.reader(table.csv().decode().splitlines()))
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


def test_tables_are_split_by_whether_breasts_hang() -> None:
    def believed(picks: int, unusual: int) -> dict[str, Any]:
        places: dict[str, Any] = {"landmarks": {"nipple": [1, 2]}, "skin": {}, "lines": {}}
        return {"exact": {"picks": picks, "dropped": 0, "unusual": unusual} | places}

    def of(hanging: bool | None, *numbers: int, failed: str | None = None) -> Record:
        return record("makehuman", "standing", believed(*numbers), failed, "certainty", hanging)

    records = [of(True, 10, 3), of(False, 20, 1), of(False, 5, 0), of(True, 7, 7, failed="No skin."), of(None, 1, 0)]
    split = by_breasts(believed_table, records)
    assert [column.name for column in split.columns] == ["breasts", "family", "kind", "picks", "dropped", "unusual"]
    numbers = [(row.cells[0], *row.cells[3:]) for row in split.rows]
    assert numbers == [("all", 36, 0, 4), ("hanging", 10, 0, 3), ("not hanging", 25, 0, 1)]
    assert of_all(split) == believed_table(records)
    assert [row.cells[:4] for row in by_breasts(certainty_table, records).rows] == [
        *(
            (breasts, "landmark", place, n)
            for breasts, n in (("all", 8), ("hanging", 2), ("not hanging", 4))
            for place in ("all", "nipple")
        ),
    ]


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


def test_prone_fits_have_medians_worst_and_shares_by_what_was_given() -> None:
    def fit(nipples: float | None, level: str) -> dict[str, Any]:
        return {"surface_mm": 1.0, "nipples_mm": nipples, "error_mm": 4.0, "level": level}

    kinds = ("given", "half", "none", "head_down")
    first = {"stance": "prone", "fits": {kind: fit(2.0, "good") for kind in kinds}}
    second = {"stance": "standing", "fits": {kind: fit(None, "check") for kind in kinds}}
    records = [record("independent", "prone", each, question="prone") for each in (first, second)]
    table = prone_table(records)
    assert [row.cells[1] for row in table.rows] == ["given", "half given", "none given", "head down"]
    by_name = dict(zip((column.name for column in table.columns), table.rows[0].cells, strict=True))
    assert (by_name["n"], by_name["surface_mm"], by_name["nipples_mm"], by_name["nipples_worst_mm"]) == (
        2,
        1.0,
        2.0,
        2.0,
    )
    assert (by_name["good"], by_name["check"], by_name["unusable"], by_name["found"]) == (50.0, 50.0, 0.0, 50.0)

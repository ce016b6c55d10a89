"""A plan is replaced by who has seen it; its versions are kept; items of scans that are not here are not shown."""

import errno
import json
import os
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from helpers.cases import new_scan, note

from breastrig.cases import plans
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.documents import NOTHING
from breastrig.cases.layout import PLAN, PLANS, new_id
from breastrig.cases.plans import add_lesions, get_plan, plan_versions, put_items_of_scan, put_plan
from breastrig.cases.writing import Changed
from breastrig.core.errors import BadInput, Conflict, NotFound
from breastrig.drawings.plan_schema import ITEMS, PlanLesion
from breastrig.scan.piece import BallInside


def texts(case: CaseFolder, version: int | None = None) -> list[str]:
    return [item.text for item in get_plan(case, version).document.items if item.kind == "note"]


def test_the_first_plan_needs_the_etag_of_nothing(case: CaseFolder, scan: str) -> None:
    assert (get_plan(case).etag, get_plan(case).document.version, get_plan(case).document.whole) == (NOTHING, 0, False)
    plan = put_plan(case, [note(scan)], NOTHING)
    assert (plan.document.version, plan.document.whole, texts(case)) == (1, True, ["a note"])
    with pytest.raises(Changed) as refused:
        put_plan(case, [], NOTHING)
    assert refused.value.etag == plan.etag == get_plan(case).etag


def test_a_plan_that_was_edited_by_hand_or_put_back_is_another_one(case: CaseFolder, scan: str) -> None:
    put_plan(case, [note(scan, "one")])
    kept = (case.path / PLAN).read_bytes()
    seen = put_plan(case, [note(scan, "two")]).etag
    (case.path / PLAN).write_bytes(kept)  # a copy is put back: version 1 again
    with pytest.raises(Changed):
        put_plan(case, [], seen)
    document = json.loads(kept)
    document["items"][0]["text"] = "by hand"
    (case.path / PLAN).write_text(json.dumps(document))
    assert texts(case) == ["by hand"]
    plan = put_plan(case, [note(scan, "three")], get_plan(case).etag)
    assert plan.document.version > 2
    assert {text for number in plan_versions(case) for text in texts(case, number)} >= {"one", "by hand", "three"}


def test_fifty_versions_are_kept_and_the_links_cost_nothing(case: CaseFolder, scan: str) -> None:
    for k in range(55):
        put_plan(case, [note(scan, f"note {k}")])
    assert plan_versions(case) == list(range(6, 56))
    assert texts(case, 6) == ["note 5"]
    assert texts(case, 55) == ["note 54"]
    with pytest.raises(NotFound, match="not kept any more"):
        get_plan(case, 5)
    before = os.stat(case.path / PLAN).st_ino
    put_plan(case, [])
    assert os.stat(case.path / PLANS / "000055.json").st_ino == before


def test_where_there_are_no_hard_links_versions_are_copies(case: CaseFolder, scan: str, monkeypatch) -> None:
    def refused(*_given: object) -> None:
        raise OSError(errno.EPERM, "no links here")

    monkeypatch.setattr(plans.os, "link", refused)
    for k in range(3):
        put_plan(case, [note(scan, f"note {k}")])
    assert [texts(case, number) for number in plan_versions(case)] == [["note 0"], ["note 1"], ["note 2"]]


def test_items_of_a_scan_that_is_not_here_are_refused_and_not_shown(case: CaseFolder, scan: str) -> None:
    other = new_scan(case)
    put_plan(case, [note(scan, "stays"), note(other, "goes")])
    for strange in (new_id(), ""):
        with pytest.raises(Conflict, match="was deleted or moved meanwhile"):
            put_plan(case, [note(strange)])
    shutil.rmtree(case.scan_folder(other))
    assert texts(case) == ["stays"]
    assert texts(case, 1) == ["stays"]
    with pytest.raises(Conflict):
        put_plan(case, [note(other)], get_plan(case).etag)


def test_items_of_one_kind_are_replaced_under_ids_of_their_own(case: CaseFolder, scan: str) -> None:
    put_plan(case, [note(scan, "mine", "one")])
    for name in ("A", "B"):
        lesion = PlanLesion(id="one", scan=scan, name=name, center=[1, 2, 3], radius_mm=5)
        put_items_of_scan(case, scan, "lesion", [lesion])
    items = get_plan(case).document.items
    assert [(item.id, item.kind) for item in items] == [("one", "note"), ("one-2", "lesion")]
    with pytest.raises(NotFound):
        put_items_of_scan(case, new_id(), "lesion", [])


def test_a_damaged_plan_is_one_sentence(case: CaseFolder) -> None:
    (case.path / PLAN).write_text('{"items": [{"kind": "what"}]}')
    with pytest.raises(BadInput, match=r"plan\.json of this case is damaged"):
        get_plan(case)


@pytest.mark.parametrize("call", ["fsync", "replace", "write"])
def test_on_a_full_disk_the_plan_stays_as_it_was(case: CaseFolder, scan: str, monkeypatch, call: str) -> None:
    seen = put_plan(case, [note(scan, "one")])

    def full(*_given: object, **_more: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    if call == "write":
        monkeypatch.setattr("breastrig.cases.writing.tempfile.mkstemp", full)
    else:
        monkeypatch.setattr(f"breastrig.cases.writing.os.{call}", full)
    with pytest.raises(OSError, match="No space"):
        put_plan(case, [note(scan, "two")], seen.etag)
    monkeypatch.undo()
    assert get_plan(case) == seen
    assert put_plan(case, [note(scan, "three")], seen.etag).document.version == 2
    assert not [path for path in case.path.iterdir() if path.name.startswith(".part-")]


def test_a_plan_is_on_the_disk_before_the_call_returns(case: CaseFolder, scan: str, monkeypatch) -> None:
    calls: list[str] = []

    def noted(name: str, real: Callable[..., None], *given: object) -> None:
        calls.append(name)
        real(*given)

    for name in ("fsync", "replace"):
        monkeypatch.setattr(f"breastrig.cases.writing.os.{name}", partial(noted, name, getattr(os, name)))
    put_plan(case, [note(scan)])
    assert calls == ["fsync", "replace", "fsync"]  # the file, its name, the folder


def test_the_case_has_no_copy_of_whose_it_is_in_its_plan(case: CaseFolder, scan: str) -> None:
    put_plan(case, [note(scan)])
    assert case.document().code not in (case.path / PLAN).read_text()


def test_a_file_beside_the_versions_is_left(case: CaseFolder, scan: str) -> None:
    put_plan(case, [note(scan)])
    put_plan(case, [])
    (Path(case.path) / PLANS / "notes.txt").write_text("mine")
    put_plan(case, [])
    assert plan_versions(case) == [1, 2, 3]


def ball(x: float, name: str = "Lesion 1") -> BallInside:
    return BallInside(name, np.array([x, 0.0, 0.0]), 5.0)


def test_lesions_of_a_file_are_added_and_never_replace(case: CaseFolder, scan: str) -> None:
    before = put_plan(case, [note(scan, "stays")])
    add_lesions(case, scan, [ball(1.0)], [], [])
    other = new_scan(case)
    found = add_lesions(case, other, [ball(1.0), ball(2.0, "Lesion 2")], [], ["Said."])
    assert [(each.name, each.is_new) for each in found.lesions] == [("Lesion 2", True), ("Lesion 3", True)]
    assert found.notes == ("Said.",)
    plan = get_plan(case)
    assert [(item.kind, item.scan) for item in plan.document.items] == [
        ("note", scan), ("lesion", scan), ("lesion", other), ("lesion", other),
    ]  # fmt: skip
    assert plan.document.version == before.document.version + 2
    add_lesions(case, scan, [ball(1.0)], [], [])
    assert get_plan(case) == plan  # nothing is written for what is there


def test_a_full_plan_takes_no_lesion_and_no_scan_that_is_gone(case: CaseFolder, scan: str) -> None:
    put_plan(case, [note(scan) for _ in range(ITEMS - 1)])
    with pytest.raises(Conflict, match="take some out"):
        add_lesions(case, scan, [ball(1.0), ball(2.0)], [], [])
    assert len(get_plan(case).document.items) == ITEMS - 1
    add_lesions(case, scan, [ball(1.0)], [], [])
    with pytest.raises(NotFound):
        add_lesions(case, "A" * 22, [ball(1.0)], [], [])

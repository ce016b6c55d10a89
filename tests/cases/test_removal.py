"""One rename decides about deleting and moving; what was interrupted is finished, and nothing of the deleted stays."""

import errno
import os
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers.cases import new_case, new_fit, new_scan, note, say

from breastrig.cases import fits, layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.fits import claimed
from breastrig.cases.layout import new_id
from breastrig.cases.of_scans import get_answers, said_same
from breastrig.cases.plans import get_plan, plan_versions, put_plan
from breastrig.cases.removal import delete_case, delete_scan, finish, move_scan, sweep
from breastrig.core.errors import Conflict, NeedsYes, NotFound


def texts(case: CaseFolder) -> set[str]:
    return {item.text for item in get_plan(case).document.items if item.kind == "note"}


def test_deleting_a_scan_leaves_nothing_of_it(case: CaseFolder, tmp_path: Path) -> None:
    scan, other = new_scan(case, b"her skin"), new_scan(case)
    new_fit(case, scan)
    for k in range(3):
        put_plan(case, [note(scan, f"her words {k}"), note(other, "stays")])
    seen = get_plan(case)
    assert delete_scan(case, scan) == []
    assert case.scan_ids() == {other}
    kept = b"".join(path.read_bytes() for path in tmp_path.rglob("*") if path.is_file())
    for word in (b"her skin", b"her words", scan.encode()):
        assert word not in kept
    assert texts(case) == {"stays"}
    assert get_plan(case).document.version == seen.document.version + 1
    assert len(plan_versions(case)) == 4
    with pytest.raises(NotFound):
        delete_scan(case, scan)


def test_scans_that_a_person_has_said_to_be_one_patients_stay_so_until_whose_they_are_is_said_anew(
    cases: Path,
) -> None:
    case, other = new_case(cases), new_case(cases)
    one, two, three = new_scan(case), new_scan(case), new_scan(other)
    with pytest.raises(NotFound, match="none of this patient's"):
        move_scan(other, three, case, again=True, same_as=[one, three])
    assert other.scan_ids() == {three}
    move_scan(other, three, case, again=True, same_as=[one])
    assert [said_same(case, each) for each in (one, two, three)] == [{three}, set(), {one}]
    move_scan(case, two, case, same_as=[one, one])
    say(case, one, visit="before")
    assert said_same(case, one) == {two, three}
    other = new_case(cases)
    move_scan(case, one, other)
    assert said_same(other, one) == set()
    assert get_answers(other, one).visit == "before"
    move_scan(other, one, case, again=True)
    assert [said_same(case, each) for each in (one, two, three)] == [set(), set(), set()]


def test_what_was_said_of_a_deleted_scan_leaves_no_trace_of_its_name(case: CaseFolder, tmp_path: Path) -> None:
    one, two = new_scan(case), new_scan(case, b"another")
    move_scan(case, one, case, same_as=[two])
    move_scan(case, two, case, same_as=[one])
    delete_scan(case, two)
    assert two.encode() not in b"".join(path.read_bytes() for path in tmp_path.rglob("*") if path.is_file())


def test_a_case_goes_with_its_last_scan(case: CaseFolder, scan: str, cases: Path) -> None:
    put_plan(case, [note(scan)])
    assert delete_scan(case, scan) == []
    assert not case.path.exists()
    assert delete_case(case) == []
    with pytest.raises(NotFound):
        delete_scan(case, scan)
    assert cases.is_dir()


def test_deleting_what_is_not_there_writes_nothing(case: CaseFolder, scan: str) -> None:
    put_plan(case, [note(scan)])
    before = sorted(case.path.parent.parent.rglob("*"))
    for unknown in (new_id(), "..", ""):
        with pytest.raises(NotFound):
            delete_scan(case, unknown)
    assert sorted(case.path.parent.parent.rglob("*")) == before


def test_a_case_is_deleted_whole(case: CaseFolder, scan: str, cases: Path) -> None:
    other = new_case(cases)
    assert delete_case(case) == []
    assert not case.path.exists()
    assert other.path.is_dir()
    with pytest.raises(NotFound):
        CaseFolder(case.path)


def test_what_cannot_be_removed_is_named_until_it_is_gone(case: CaseFolder, monkeypatch) -> None:
    scan = new_scan(case, b"her skin")
    new_scan(case)
    put_plan(case, [note(scan)])
    real = os.unlink

    def refused(path: object, *given: object, **more: object) -> None:
        if str(path).endswith(layout.STORED):
            raise PermissionError(errno.EPERM, "Operation not permitted", path)
        real(path, *given, **more)

    monkeypatch.setattr(os, "unlink", refused)
    [left] = delete_scan(case, scan)
    assert left.reason == "Operation not permitted"
    assert scan not in case.scan_ids()
    assert texts(case) == set()
    assert finish(case) != []
    monkeypatch.undo()
    assert finish(case) == []
    assert not list(case.path.parent.parent.rglob(layout.STORED + "x"))
    assert case.around.marks() == {}


def test_where_the_folder_cannot_be_renamed_an_empty_one_says_that_it_is_deleted(case: CaseFolder, monkeypatch) -> None:
    scan, other = new_scan(case), new_scan(case)
    put_plan(case, [note(scan, "hers"), note(other, "stays")])

    def busy(*_given: object) -> None:
        raise OSError(errno.EBUSY, "Device or resource busy")

    def kept(path: Path) -> None:
        raise OSError(errno.EBUSY, "Device or resource busy")

    with monkeypatch.context() as patch:
        patch.setattr("breastrig.cases.removal.os.rename", busy)
        patch.setattr("breastrig.cases.removal.remove_tree", kept)  # it is mounted: it stays
        [left] = delete_scan(case, scan)
    assert left.where.endswith(scan)
    assert case.scan_folder(scan).is_dir()
    assert case.scan_ids() == {other}
    assert texts(case) == {"stays"}
    with pytest.raises(NotFound):
        case.scan(scan)
    assert finish(case) == []
    assert not case.scan_folder(scan).exists()


def test_where_the_plan_cannot_be_written_the_scan_is_deleted_and_the_next_sweep_does_the_rest(
    cases: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = new_case(cases)
    scan, other = new_scan(case, b"her skin"), new_scan(case)
    put_plan(case, [note(scan, "hers"), note(other, "stays")])

    def full(*_given: object, **_more: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("breastrig.cases.writing.tempfile.mkstemp", full)
        assert delete_scan(case, scan) == []
        assert (case.scan_ids(), texts(case)) == ({other}, {"stays"})
        assert b"her skin" not in b"".join(path.read_bytes() for path in cases.parent.rglob("*") if path.is_file())
        assert case.around.marks() == {scan: True}
    assert sweep(cases.parent) == []
    assert case.around.marks() == {}
    assert scan.encode() not in b"".join(path.read_bytes() for path in cases.parent.rglob("*") if path.is_file())


def test_a_scan_moves_with_all_that_was_planned_on_it(cases: Path) -> None:
    source, target = new_case(cases), new_case(cases)
    scan, stays, there = new_scan(source), new_scan(source), new_scan(target)
    put_plan(source, [note(scan, "moves", "one"), note(stays, "stays")])
    put_plan(target, [note(there, "was there", "one")])
    move_scan(source, scan, target)
    assert (source.scan_ids(), target.scan_ids()) == ({stays}, {scan, there})
    assert (texts(source), texts(target)) == ({"stays"}, {"was there", "moves"})
    assert [item.id for item in get_plan(target).document.items] == ["one", "one-2"]
    assert source.around.marks() == target.around.marks() == {}
    move_scan(source, stays, target)
    assert not source.path.exists()
    assert target.scan_ids() == {scan, stays, there}


def test_a_scan_moves_between_cases_that_stand_alone(tmp_path: Path) -> None:
    source, target = (CaseFolder.create(tmp_path / name) for name in ("one", "other.case"))
    scan, _ = new_scan(source), new_scan(source)
    put_plan(source, [note(scan, "moves")])
    move_scan(source, scan, target)
    assert texts(target) == {"moves"}
    assert texts(source) == set()


def test_a_scan_whose_fit_runs_stays(cases: Path) -> None:
    source, target = new_case(cases), new_case(cases)
    scan = new_scan(source)
    with claimed(source, scan, new_fit(source, scan)), pytest.raises(Conflict, match="A fit of this scan is running"):
        move_scan(source, scan, target)
    move_scan(source, scan, target)


def test_a_scan_whose_fit_has_just_ended_moves_when_its_worker_leaves_it(cases: Path, monkeypatch) -> None:
    source, target = new_case(cases), new_case(cases)
    scan = new_scan(source)
    with ExitStack() as worker:
        claim = worker.enter_context(claimed(source, scan, new_fit(source, scan)))
        assert claim is not None
        claim.end({"kind": "done", "result": {}})
        monkeypatch.setattr(fits.time, "sleep", lambda _: worker.close())
        move_scan(source, scan, target)
    assert target.scan_ids() == {scan}


def test_the_same_file_is_not_moved_beside_itself(cases: Path) -> None:
    source, target = new_case(cases), new_case(cases)
    with source.incoming() as made:
        (made / layout.STORED).write_bytes(b"skin")
        known = target.add_scan(made, source.scan(new_scan(source)))
    [scan] = [one.id for one in source.scans() if one.document == target.scan(known)]
    with pytest.raises(NeedsYes):
        move_scan(source, scan, target)
    move_scan(source, scan, target, again=True)
    assert target.scan_ids() == {known, scan}
    with pytest.raises(NotFound):
        move_scan(target, new_id(), new_case(cases))


def test_the_sweep_touches_only_what_is_ours(case: CaseFolder, scan: str, cases: Path) -> None:
    root = cases.parent
    strange = [root / "rubbish" / "letters", root / "rubbish" / f"{new_id()}.tar", cases / "notes", cases / new_id()]
    for folder in strange:
        folder.mkdir(parents=True)
        (folder / "mine.txt").write_text("text")
    assert sweep(root) == []
    assert all((folder / "mine.txt").is_file() for folder in strange)
    assert case.scan_ids() == {scan}


def test_an_empty_case_survives_a_move_to_it_that_was_interrupted(cases: Path, monkeypatch) -> None:
    source, target = new_case(cases), new_case(cases)
    scan = new_scan(source)

    def killed(*_given: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("breastrig.cases.removal.os.rename", killed)
        with pytest.raises(KeyboardInterrupt):
            move_scan(source, scan, target)
    assert sweep(cases.parent) == []
    assert source.scan_ids() == {scan}
    assert target.document().code


@pytest.mark.parametrize("action", ["delete", "move", "part", "arrive"])
def test_an_action_that_is_killed_at_each_step_is_undone_or_finished(action: str, tmp_path: Path) -> None:
    program = [sys.executable, "-m", "helpers.stopped_writers", action, str(tmp_path)]
    done = subprocess.run(
        program, capture_output=True, text=True, check=False, env=os.environ | {"PYTHONPATH": "tests"}
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 10

"""Deleting a scan: nothing of it is left in any file of the data folder, also where it was interrupted."""

from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.cases import new_case, new_fit, new_link, new_scan, note
from helpers.on_disk import kept_below
from helpers.stored_fits import fit_ids, scan_ids

from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.layout import new_id
from breastrig.cases.plans import put_plan
from breastrig.cases.removal import delete_case, move_scan
from breastrig.core.errors import NotFound
from breastrig.core.picks import Picks
from breastrig.index import questions
from breastrig.index.questions import LinkSecret
from breastrig.storage.deletion import delete_scan, finish_deletions, look, remove_left
from breastrig.storage.documents.scans import get_landmarks, put_landmarks
from breastrig.storage.documents.shares import end_snapshots, get_share
from breastrig.storage.storage import Storage, Unremoved

LONG_AGO = "2026-01-01T00:00:00.000Z"
TRACES = ("skin of hers", "a_landmark", "words of hers", "CODE-OF-HERS", "seen through", "scrypt", "visit-of")


@pytest.fixture
def other(storage: Storage) -> str:
    """A scan of another patient, which stays."""
    return new_scan(new_case(storage.root / "cases"))


@pytest.fixture
def case(storage: Storage, other: str) -> CaseFolder:
    """A patient with one scan, with landmarks, a plan, a fit, and a link to it that was opened."""
    case = new_case(storage.root / "cases", "CODE-OF-HERS")
    scan = new_scan(case, b"skin of hers")
    new_fit(case, scan)
    link = new_link(case)
    put_plan(case, [note(scan, "words of hers")])
    put_plan(case, [note(scan, "more words of hers")])
    storage.index.look()
    with storage.index.writing() as rows:
        questions.put_secret(rows, LinkSecret(link, "ab" * 32, "scrypt$of$a$passcode"))
        questions.note_opening(rows, link, LONG_AGO, "visit-of-hers")
    put_landmarks(storage, scan, Picks({"a_landmark": [1.0, 2.0, 3.0]}))
    return case


def names_of(case: CaseFolder) -> list[str]:
    """Ids of all that is in the case, and its own."""
    return [case.id, *(part for path in case.path.rglob("*") for part in path.name.split(".") if len(part) == 22)]


def assert_gone(storage: Storage, other: str, names: list[str]) -> None:
    storage.close()
    left = kept_below(storage.root)
    assert [trace for trace in (*TRACES, *names) if trace.encode() in left] == []
    assert (scan_ids(storage), fit_ids(storage)) == ({other}, set())


def test_deleting_a_scan_leaves_no_name_and_no_byte_of_it(storage: Storage, case: CaseFolder, other: str) -> None:
    names, [scan] = names_of(case), case.scan_ids()
    left = kept_below(storage.root)
    assert [trace for trace in (*TRACES, *names) if trace.encode() not in left] == []  # as it is looked for below
    assert len(names) == 4
    assert delete_scan(storage, scan) == delete_scan(storage, scan) == []
    assert_gone(storage, other, names)


def started(storage: Storage) -> list[Unremoved]:
    """What a server does at its start."""
    left = finish_deletions(storage)
    storage.prepare()
    return left


@pytest.mark.parametrize("finish", [started, remove_left])
@pytest.mark.parametrize("killed", ["before the index", "before the secrets"])
def test_what_was_deleted_before_a_server_was_killed_is_forgotten_by_the_next(
    storage: Storage, case: CaseFolder, other: str, killed: str, finish: Callable[[Storage], object]
) -> None:
    names = names_of(case)
    assert delete_case(case) == []  # as another program does it, too
    if killed == "before the secrets":
        storage.index.refresh(case.id)
    again = Storage(storage.root)
    assert finish(again) == []
    again.prepare()
    look(again)
    again.close()
    assert_gone(storage, other, names)


def test_a_scan_that_is_not_there_leaves_no_trace_of_its_name(storage: Storage, case: CaseFolder) -> None:
    unknown = new_id()
    assert delete_scan(storage, unknown) == []
    assert put_landmarks_of_nobody(storage, unknown)
    assert get_landmarks(storage, unknown) == Picks({})
    storage.close()
    assert unknown.encode() not in kept_below(storage.root)


def put_landmarks_of_nobody(storage: Storage, scan: str) -> bool:
    with pytest.raises(NotFound):
        put_landmarks(storage, scan, Picks({"nipple_L": [1.0, 2.0, 3.0]}))
    return True


def test_a_scan_that_another_program_has_moved_is_deleted_where_it_is(
    storage: Storage, case: CaseFolder, other: str
) -> None:
    names, [scan] = names_of(case), case.scan_ids()
    target = new_case(storage.root / "cases")
    stays = new_scan(target)
    move_scan(case, scan, target)
    assert delete_scan(storage, scan) == []
    assert target.scan_ids() == {stays}
    storage.index.look()
    assert scan_ids(storage) == {other, stays}
    delete_scan(storage, stays)
    assert_gone(storage, other, names)


def test_what_links_show_stays_through_a_restart_and_goes_when_they_are_over(
    storage: Storage, case: CaseFolder
) -> None:
    [shown] = case.path.rglob("shown-1")
    link, fit = shown.parent.name, shown.parents[2].name
    for _ in range(2):
        assert finish_deletions(storage) == []
    end_snapshots(storage, "2998-12-31T00:00:00.000Z")
    assert (shown / "plan.json").is_file()
    end_snapshots(storage, "2999-01-01T00:00:00.000Z")
    assert not shown.exists()
    assert get_share(storage, fit, link).snapshot is None


def test_what_a_killed_server_was_making_goes_at_the_next_start(storage: Storage, case: CaseFolder) -> None:
    made = [storage.files.made(place) for place in (f"scans/{new_id()}", f"fits/{new_id()}", f"shares/{new_id()}.1")]
    for folder in made:
        folder.mkdir()
        (folder / "result.json").write_text("half of a result")
    strange = storage.root / "incoming" / "letters"
    strange.write_text("text")
    assert finish_deletions(storage) == []
    assert not any(folder.exists() for folder in made)
    assert strange.is_file()


def test_a_lost_index_empties_nothing(storage: Storage, case: CaseFolder) -> None:
    before = sorted(path for path in storage.root.rglob("*") if not path.name.startswith("index"))
    storage.close()
    for file in storage.root.glob("index*"):
        file.unlink()
    again = Storage(storage.root)
    again.prepare()
    assert finish_deletions(again) == []
    assert len(scan_ids(again)) == 2
    again.close()
    assert sorted(path for path in storage.root.rglob("*") if not path.name.startswith("index")) == before


def test_a_place_that_is_gone_is_noticed(storage: Storage, tmp_path: Path) -> None:
    assert storage.has_files()
    storage.root.rename(tmp_path / "elsewhere")
    assert not storage.has_files()
    (tmp_path / "elsewhere").rename(storage.root)
    assert storage.has_files()

"""Another program works at cases beside the service: each sees what the other has written, and neither undoes it."""

from pathlib import Path

import pytest
from helpers import fake_fit
from helpers.cases import new_case, new_fit, new_link, new_scan, note
from helpers.stored_fits import fit_ids, scan_ids
from helpers.waiting import ask_for_fit, ended, stored_events, until

from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.fits import claimed, get_fit
from breastrig.cases.plans import put_plan
from breastrig.cases.removal import delete_case, delete_scan, move_scan
from breastrig.cases.writing import Changed
from breastrig.core.errors import NotFound
from breastrig.service import sweep
from breastrig.service.fits.queue import STARTS
from breastrig.storage import deletion
from breastrig.storage.documents import patients
from breastrig.storage.documents.scans import get_scan
from breastrig.storage.storage import Storage


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """The service looks for news all the time."""
    monkeypatch.setattr(sweep, "NEWS_EVERY_S", 0.01)
    monkeypatch.setattr(sweep, "NEWS_SHARE", 1)


def test_a_fit_that_another_program_runs_is_followed_and_neither_started_nor_ended(serving, storage: Storage) -> None:
    case = new_case(storage.root / "cases")
    scan = new_scan(case)
    fit = new_fit(case, scan)
    with claimed(case, scan, fit) as claim, serving(fake_fit.quick) as service:
        assert claim is not None
        until(lambda: fit in fit_ids(service.storage), "the other program's fit")
        for _ in range(STARTS + 1):  # the service had time enough to take it for one that dies each time
            assert ended(service, ask_for_fit(service, scan)).state == "done"
        assert claim.append({"kind": "started", "stance": "standing"})
        assert claim.append({"kind": "done", "result": {"verdict": {"level": "good"}}})
        assert [event.kind for event in stored_events(service, fit)] == ["started", "done"]
        assert ended(service, fit).verdict == "good"


def test_of_a_service_and_another_program_each_sees_the_others_plan(serving, storage: Storage) -> None:
    case = new_case(storage.root / "cases")
    scan = new_scan(case)
    with serving(fake_fit.quick) as service:
        until(lambda: scan in scan_ids(service.storage), "the other program's scan")
        first = patients.put_plan(service.storage, case.id, [note(scan, "the service's").model_dump()], "0")
        with pytest.raises(Changed):
            put_plan(case, [], "0")
        put_plan(case, [note(scan, "the other's")], first.etag)
        with pytest.raises(Changed):
            patients.put_plan(service.storage, case.id, [], first.etag)
        assert [item["text"] for item in patients.get_plan(service.storage, case.id).items] == ["the other's"]


def test_a_patient_is_deleted_without_scans_that_are_another_patients_by_now(serving, storage: Storage) -> None:
    case, empty, other = (new_case(storage.root / "cases") for _ in range(3))
    scans = [new_scan(case) for _ in range(2)]
    with serving(fake_fit.quick) as service:
        storage.index.look()
        deleted = service.delete_scan

        def delete_and_move(scan: str) -> None:
            deleted(scan)
            move_scan(case, next(each for each in scans if each != scan), other)

        service.delete_scan = delete_and_move
        service.delete_patient(case.id)
        service.delete_patient(empty.id)
        assert not case.path.exists()
        assert not empty.path.exists()
        assert len(other.scan_ids()) == 1


def test_what_another_program_deletes_is_gone_at_once(serving, storage: Storage) -> None:
    case = new_case(storage.root / "cases")
    scan = new_scan(case)
    with serving(fake_fit.quick) as service:
        until(lambda: scan in scan_ids(service.storage), "the other program's scan")
        fit = ask_for_fit(service, scan)
        ended(service, fit)
        assert get_fit(case, scan, fit).state == "done"
        delete_case(case)
        with pytest.raises(NotFound):
            get_scan(service.storage, scan)
        assert stored_events(service, fit) == []
        until(lambda: not scan_ids(service.storage), "the look that forgets it")


def test_the_worklist_shows_at_once_what_another_program_has_done(storage: Storage) -> None:
    """No look comes between: what has changed is read when the list is asked for."""
    storage.prepare()
    cases = [new_case(storage.root / "cases") for _ in range(3)]
    scans = [new_scan(case) for case in cases]
    deletion.look(storage)
    seen, waits, goes = cases
    fit = new_fit(seen, scans[0])
    assert states(storage) == {seen.id: ["queued"], waits.id: [None], goes.id: [None]}
    with claimed(seen, scans[0], fit) as claim:
        assert claim is not None
        claim.append({"kind": "started", "stance": "supine"})
        assert states(storage)[seen.id] == ["running"]
        claim.append({"kind": "done", "result": {"verdict": {"level": "good"}}})
    seen.rename("by another program")
    another = new_scan(waits)
    delete_case(goes)
    assert states(storage) == {seen.id: ["done"], waits.id: [None, None]}
    line = patients.listed_patient(storage, seen.id)
    assert (line.code, line.scans[0].fit.verdict, line.scans[0].fit.stance) == ("by another program", "good", "supine")
    delete_scan(waits, another)
    with waits.writing():  # nobody waits for who writes there, and nobody is shown what is deleted
        assert states(storage)[waits.id] == [None]
    delete_case(seen)
    with pytest.raises(NotFound):
        patients.listed_patient(storage, seen.id)


def test_a_page_of_the_worklist_opens_no_document(storage: Storage, monkeypatch: pytest.MonkeyPatch) -> None:
    storage.prepare()
    case = new_case(storage.root / "cases")
    scan = new_scan(case)
    new_fit(case, scan)
    new_link(case)  # to that fit, which is done by then
    deletion.look(storage)
    opened: list[str] = []
    monkeypatch.setattr(CaseFolder, "content", lambda _case, name: opened.append(name))
    monkeypatch.setattr(Path, "open", lambda path, *_more: opened.append(path.name))
    assert states(storage) == {case.id: ["done"]}
    assert opened == []


def states(storage: Storage) -> dict[str, list[str | None]]:
    """{case of the worklist: the state of each scan's newest fit}"""
    page, _ = patients.listed_page(storage, 50, None)
    return {row.id: [None if scan.fit is None else scan.fit.state for scan in row.scans] for row in page}

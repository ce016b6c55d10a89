"""A fit is asked for, claimed by one, told line by line, and ends once."""

import errno
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from helpers.cases import new_fit, new_scan

from breastrig.cases import fits, layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.documents import FitDocument
from breastrig.cases.fits import (
    added,
    cancel_fit,
    claimed,
    end_abandoned,
    events_after,
    find_fit,
    fits_of_scan,
    get_fit,
    is_at_work,
)
from breastrig.cases.layout import fit_part, new_id
from breastrig.cases.writing import locked
from breastrig.core.errors import Conflict, NotFound

STARTED, STEP, DONE = {"kind": "started"}, {"kind": "iterated", "iteration": 0}, {"kind": "done", "result": {}}


@pytest.fixture
def fit(case: CaseFolder, scan: str) -> str:
    return new_fit(case, scan)


@pytest.fixture
def log(case: CaseFolder, scan: str, fit: str) -> Path:
    return case.path / fit_part(scan, fit) / layout.LOG


def kinds(case: CaseFolder, scan: str, fit: str) -> list[str]:
    import json

    return [json.loads(line)["kind"] for _, line in events_after(case.path / fit_part(scan, fit))]


def test_its_state_is_the_last_line(case: CaseFolder, scan: str, fit: str) -> None:
    assert get_fit(case, scan, fit).state == "queued"
    with claimed(case, scan, fit) as claim:
        assert claim is not None
        for event, state in ((STARTED, "running"), (STEP, "running"), (DONE, "done")):
            assert claim.append(event)
            assert get_fit(case, scan, fit).state == state
        assert not claim.append(STEP)
        assert not claim.append(DONE)
    assert kinds(case, scan, fit) == ["started", "iterated", "done"]
    with claimed(case, scan, fit) as claim:
        assert claim is None
    assert find_fit(case, fit).last == DONE


def test_one_alone_works_at_it(case: CaseFolder, scan: str, fit: str) -> None:
    with claimed(case, scan, fit) as claim:
        assert claim is not None
        assert is_at_work(case, scan)
        with claimed(case, scan, fit) as other:
            assert other is None
        assert not end_abandoned(case, scan, fit, DONE)
    assert not is_at_work(case, scan)


def test_the_one_who_comes_after_a_killed_worker_tells_on_where_the_lines_end(
    case: CaseFolder, scan: str, fit: str, log: Path
) -> None:
    with claimed(case, scan, fit) as claim:
        assert claim is not None
        claim.append(STARTED)
    with log.open("ab") as file:
        file.write(b'{"kind": "iterat')  # killed in the middle of a line
    assert get_fit(case, scan, fit).state == "running"
    assert kinds(case, scan, fit) == ["started"]
    with claimed(case, scan, fit) as claim:
        assert claim is not None
        for event in (STARTED, STEP, DONE):
            claim.append(event)
    assert kinds(case, scan, fit) == ["started", "iterated", "done"]


def test_the_fourth_start_is_an_honest_failure(case: CaseFolder, scan: str, fit: str) -> None:
    for _ in range(fits.ATTEMPTS):
        with claimed(case, scan, fit) as claim:
            assert claim is not None
    with claimed(case, scan, fit) as claim:
        assert claim is None
    found = get_fit(case, scan, fit)
    assert found.state == "failed"
    assert found.last is not None
    assert "started 3 times" in found.last["reason"]


def test_a_cancelled_fit_is_not_started_and_a_running_one_stops_at_the_next_event(
    case: CaseFolder, scan: str, fit: str
) -> None:
    waiting = new_fit(case, scan)
    assert cancel_fit(case, scan, waiting).state == "cancelled"
    assert kinds(case, scan, waiting) == ["cancelled"]
    with claimed(case, scan, fit) as claim:
        assert claim is not None
        claim.append(STARTED)
        assert cancel_fit(case, scan, fit).state == "cancelled"
        assert not claim.append(STEP)
    assert kinds(case, scan, fit) == ["started", "cancelled"]
    assert cancel_fit(case, scan, fit).state == "cancelled"
    done = new_fit(case, scan)
    with claimed(case, scan, done) as claim:
        assert claim is not None
        claim.append(DONE)
    with pytest.raises(Conflict, match="it is done"):
        cancel_fit(case, scan, done)


def test_a_fit_ends_once_however_many_end_it(case: CaseFolder, scan: str, fit: str) -> None:
    def end(kind: str) -> bool:
        return end_abandoned(case, scan, fit, {"kind": kind, "reason": "enough"})

    with ThreadPoolExecutor(8) as threads:
        ended = list(threads.map(end, ["failed", "cancelled"] * 8))
    assert ended.count(True) == 1
    assert len(kinds(case, scan, fit)) == 1


def test_a_fit_that_is_not_there_is_nobodys(case: CaseFolder, scan: str, fit: str) -> None:
    for of_scan, of_fit in ((scan, new_id()), (new_id(), fit), (scan, "..")):
        with pytest.raises(NotFound), claimed(case, of_scan, of_fit):
            pass
        with pytest.raises(NotFound):
            end_abandoned(case, of_scan, of_fit, DONE)
    assert kinds(case, scan, fit) == []


def test_a_cancellation_whose_writer_was_killed_is_written_by_the_next(case: CaseFolder, scan: str, fit: str) -> None:
    (case.path / fit_part(scan, fit) / layout.CANCEL).touch()
    assert get_fit(case, scan, fit).state == "cancelled"
    with claimed(case, scan, fit) as claim:
        assert claim is None
    assert kinds(case, scan, fit) == ["cancelled"]


def test_no_number_that_is_none_is_stored(case: CaseFolder, scan: str, fit: str, log: Path) -> None:
    with claimed(case, scan, fit) as claim:
        assert claim is not None
        with pytest.raises(ValueError, match="Out of range"):
            claim.append({"kind": "iterated", "energy": float("nan")})
    assert not log.exists()


def test_on_a_full_disk_no_half_line_is_left(case: CaseFolder, scan: str, fit: str, log: Path, monkeypatch) -> None:
    real = os.write

    def half(descriptor: int, content: memoryview) -> int:
        if len(content) < 8:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(descriptor, content[: len(content) // 2])

    with claimed(case, scan, fit) as claim:
        assert claim is not None
        claim.append(STARTED)
        before = log.read_bytes()
        monkeypatch.setattr("breastrig.cases.fits.os.write", half)
        with pytest.raises(OSError, match="No space"):
            claim.append(STEP)
        monkeypatch.undo()
        assert log.read_bytes() == before
        assert claim.append(DONE)
    assert kinds(case, scan, fit) == ["started", "done"]


def test_the_end_waits_for_who_writes_into_the_case(case: CaseFolder, scan: str, fit: str) -> None:
    import threading

    with claimed(case, scan, fit) as claim:
        assert claim is not None
        with locked(case.path):
            ending = threading.Thread(target=claim.append, args=(DONE,))
            ending.start()
            time.sleep(0.2)
            assert get_fit(case, scan, fit).state == "queued"
        ending.join(timeout=30)
    assert get_fit(case, scan, fit).state == "done"


def test_a_fit_of_a_scan_that_is_gone_leaves_nothing(case: CaseFolder, scan: str) -> None:
    with pytest.raises(NotFound), added(case, new_id(), FitDocument(asked_at="2026")):
        pass
    assert fits_of_scan(case, scan) == []
    with pytest.raises(NotFound):
        get_fit(case, scan, new_id())
    with pytest.raises(NotFound):
        get_fit(case, scan, "..")


def test_a_long_last_line_is_read_whole(case: CaseFolder, scan: str, fit: str) -> None:
    with claimed(case, scan, fit) as claim:
        assert claim is not None
        claim.append(STARTED)
        claim.append({"kind": "done", "result": {"text": "x" * 10 * fits.TAIL}})
    last = get_fit(case, scan, fit).last
    assert last is not None
    assert len(last["result"]["text"]) == 10 * fits.TAIL


WRITER = """
import sys
from pathlib import Path
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.fits import claimed
case = CaseFolder(Path(sys.argv[1]))
with claimed(case, sys.argv[2], sys.argv[3]) as claim:
    print("claimed", flush=True)
    for k in range(10**9):
        claim.append({"kind": "iterated", "iteration": k, "text": "x" * 5000})
"""


def test_the_kernel_frees_the_claim_of_a_killed_process(case: CaseFolder, fit: str, scan: str) -> None:
    writer = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(case.path), scan, fit], stdout=subprocess.PIPE, text=True
    )
    assert writer.stdout is not None
    assert writer.stdout.readline() == "claimed\n"
    assert is_at_work(case, scan)
    while len(events_after(case.path / fit_part(scan, fit))) < 3:
        assert writer.poll() is None
    writer.kill()
    writer.wait()
    writer.stdout.close()
    assert end_abandoned(case, scan, fit, {"kind": "failed", "reason": "The process died."})
    assert get_fit(case, scan, fit).state == "failed"
    new_scan(case)


def test_who_asks_for_a_fit_to_run_it_has_it_before_anyone_sees_it(case: CaseFolder, scan: str, monkeypatch) -> None:
    """Whoever waits for the case to be free finds the fit claimed."""
    taken = []
    put_folder = CaseFolder.put_folder

    def put_and_look(self: CaseFolder, made: Path, part: str) -> None:
        put_folder(self, made, part)
        with claimed(case, scan, Path(part).name) as claim:  # a service that looks in this moment
            taken.append(claim)

    monkeypatch.setattr(CaseFolder, "put_folder", put_and_look)
    with added(case, scan, FitDocument(asked_at="2026")) as claim:
        assert taken == [None]
        assert get_fit(case, scan, claim.fit_id).state == "queued"
        with claimed(case, scan, claim.fit_id) as other:
            assert other is None
        assert claim.append(STARTED)
        assert claim.append(DONE)
    assert get_fit(case, scan, claim.fit_id).state == "done"
    assert not is_at_work(case, scan)

"""The log holds what was written, in order, whoever writes at once, and shows each kind of damage in one sentence."""

import errno
import hashlib
import json
import multiprocessing
import os
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path

import pytest
from helpers.cases import data_folder, new_case, new_link, new_scan
from helpers.cases import new_fit as add_fit

from breastrig.audit import log as audit_log
from breastrig.audit.deletions import deletion
from breastrig.audit.log import FIRST, AuditLog, Entry, Mark, log_files
from breastrig.audit.read import check, lines_from, read_mark
from breastrig.cases.removal import delete_case, delete_scan
from breastrig.core import wall_clock
from breastrig.core.errors import BadInput


@pytest.fixture
def data(tmp_path: Path) -> Path:
    data_folder(tmp_path / "data")
    return tmp_path / "data"


def entry(number: int = 0, who: str = "token") -> Entry:
    return Entry(who, "open", "scans.show_scan", {"scan": f"{number:022}"})


def written(data: Path) -> list[bytes]:
    return [line for file in log_files(data / "audit") for line in file.read_bytes().splitlines()]


def test_each_line_has_the_hash_of_the_line_before(data: Path) -> None:
    log = AuditLog(data)
    log.later(entry(1))
    [mark] = log.append(entry(2))
    lines = written(data)
    assert [json.loads(line)["what"] for line in lines] == ["begin", "open", "open"]
    assert json.loads(lines[0])["before"] == FIRST
    assert json.loads(lines[0])["installation"] == (data / "installation").read_text()
    assert all(json.loads(b)["before"] == hashlib.sha256(a).hexdigest() for a, b in pairwise(lines))
    assert mark == log.end() == Mark(3, hashlib.sha256(lines[2]).hexdigest())
    found = check(data, read_mark(str(mark)))
    assert (found.lines, found.end, found.fault) == (3, mark, "")
    assert (data / "audit").stat().st_mode & 0o777 == 0o700
    assert all(file.stat().st_mode & 0o077 == 0 for file in (data / "audit").iterdir())


def append_many(data: Path, who: str, number: int) -> None:
    log = AuditLog(data)
    for each in range(number):
        log.append(entry(each, who))


def test_lines_of_several_processes_are_in_one_chain(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(audit_log, "ROTATE_BYTES", 2000)  # of this process; the others find its files
    context = multiprocessing.get_context("fork")
    others = [context.Process(target=append_many, args=(data, f"shell:{k}", 60)) for k in range(3)]
    for other in others:
        other.start()
    append_many(data, "token", 60)
    for other in others:
        other.join()
    assert check(data).fault == ""
    lines = [json.loads(line) for line in written(data)]
    assert len(lines) == 1 + 4 * 60
    for who in ("token", "shell:0", "shell:1", "shell:2"):
        assert [int(line["of"]["scan"]) for line in lines if line["who"] == who] == list(range(60))
    assert len(log_files(data / "audit")) > 5
    assert log_files(data / "audit")[0].name == "0000000001.jsonl"


def damaged(data: Path, line: int, content: bytes | None) -> None:
    """The log with another line in the place of one; None: without it."""
    [file] = log_files(data / "audit")
    lines = file.read_bytes().splitlines(keepends=True)
    lines[line - 1 : line] = [] if content is None else [content + b"\n"]
    file.write_bytes(b"".join(lines))


@pytest.mark.parametrize(
    ("line", "content", "said"),
    [
        (4, b'{"n":4,"before":"%b","at":"never"}', "Line 4 was changed: line 5 names another one"),
        (4, None, "Line 4 is missing."),
        (6, None, "Line 6 is missing."),
        (4, b"\0\xff{", "Line 4 (in 0000000001.jsonl) is damaged."),
        (1, None, "Line 1 is missing."),
        (6, b'{"n":6,"before":"%b","at":"never"}', "Line 6 is not the one that audit/end notes"),
    ],
)
def test_the_first_broken_line_is_named(data: Path, line: int, content: bytes | None, said: str) -> None:
    append_many(data, "token", 5)
    before = json.loads(written(data)[line - 1])["before"]
    damaged(data, line, content and content.replace(b"%b", before.encode()))
    assert check(data).fault.startswith(said)
    AuditLog(data).append(entry())  # whoever goes on does not heal it
    assert check(data).fault


def test_a_cut_at_the_end_shows_also_after_more_was_written(data: Path) -> None:
    append_many(data, "token", 5)
    [file] = log_files(data / "audit")
    kept = file.read_bytes().splitlines(keepends=True)[:3]
    file.write_bytes(b"".join(kept))
    assert check(data).fault == "Lines 4 to 6 are missing."
    AuditLog(data).append(entry())
    assert check(data).fault == "Lines 4 to 6 are missing."
    assert json.loads(written(data)[-1])["n"] == 7


def test_a_chain_written_anew_is_shown_by_an_anchor_alone(data: Path) -> None:
    append_many(data, "token", 5)
    anchor = AuditLog(data).end()
    for file in (data / "audit").iterdir():
        file.unlink()
    append_many(data, "shell:0", 7)
    assert check(data).fault == ""  # who may write into the folder may write a whole log
    assert check(data, anchor).fault.startswith("Line 6 is not the one that the anchor says")
    assert check(data, Mark(30, anchor.sha256)).fault == "Lines 9 to 30 are missing."
    with pytest.raises(BadInput, match="An anchor is"):
        read_mark("30")


def test_the_log_of_another_folder_is_refused(data: Path) -> None:
    append_many(data, "token", 1)
    (data / "installation").write_text("x" * 22)
    assert check(data).fault.startswith("Line 1 names another data folder")


def test_half_a_line_of_a_killed_writer_is_cut_off_and_said(data: Path) -> None:
    append_many(data, "token", 2)
    [file] = log_files(data / "audit")
    with file.open("ab") as stream:
        stream.write(b'{"n":4,"befo')
    assert check(data).lines == 3
    assert not check(data).fault
    AuditLog(data).append(entry())
    assert [json.loads(line)["what"] for line in written(data)][3:] == ["mended", "open"]
    assert json.loads(written(data)[3])["half_line_bytes"] == 12
    assert not check(data).fault


def test_a_full_disk_refuses_changes_keeps_openings_and_lets_deletions_pass(
    data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    append_many(data, "token", 1)
    log, write, room = AuditLog(data), os.write, 0

    def full(descriptor: int, content: bytes) -> int:
        if not content.startswith(b"{") or room:
            return write(descriptor, content)
        write(descriptor, content[:9])  # as a disk does with a page left
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(OSError, match="No space left"):
        log.append(entry())
    assert check(data).lines == 2
    log.later(entry(7))
    log.flush()
    assert log.append_deletion(Entry("token", "delete", of={"patient": "p" * 22})) is None
    assert not (data / "audit" / "reserve").exists()  # it was given up
    room = 1
    log.append_deletion(Entry("token", "done", of={"patient": "p" * 22}))
    assert [json.loads(line)["what"] for line in written(data)][2:] == ["open", "delete", "done"]
    assert not check(data).fault
    assert (data / "audit" / "reserve").stat().st_size == 65_536


def test_a_clock_that_is_set_back_changes_no_order(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    append_many(data, "token", 1)
    monkeypatch.setattr(wall_clock, "now", lambda: datetime(2001, 1, 1, tzinfo=UTC))
    append_many(data, "token", 1)
    assert [line["n"] for line in lines_from(data)] == [3, 2, 1]
    assert [line["n"] for line in lines_from(data, since="2002")] == [2, 1]
    assert not check(data).fault


def test_pages_and_ids(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(audit_log, "ROTATE_BYTES", 500)
    append_many(data, "token", 20)
    assert [line["n"] for line in lines_from(data, before=9)] == [8, 7, 6, 5, 4, 3, 2, 1]
    [found] = lines_from(data, of=f"{7:022}")
    assert (found["n"], found["sha256"]) == (9, hashlib.sha256(written(data)[8]).hexdigest())


def test_a_deletion_says_what_there_was_and_what_is_left_and_no_code(data: Path) -> None:
    log, case = AuditLog(data), new_case(data / "cases", "Maria M.")
    scans = sorted([new_scan(case), new_scan(case, b"other")])
    for scan in scans:
        add_fit(case, scan)
    new_link(case)
    with deletion(log, "shell:7", "case delete", case.path, scans[1]):
        delete_scan(case, scans[1])
    with deletion(log, "shell:7", "case delete", case.path):
        delete_case(case)
    lines = [json.loads(line) for line in written(data)][1:]
    assert [line["what"] for line in lines] == ["delete", "done", "delete", "done"]
    assert {"case": False, "scans": 1, "fits": 1, "scan_ids": [scans[1]]}.items() <= lines[0]["removes"].items()
    last = lines[2]["removes"]
    assert {"case": True, "scans": 1, "fits": 1, "links": 1, "scan_ids": [scans[0]]}.items() <= last.items()
    assert last["bytes"] > 3 * len(b"skin")
    assert [(line["line"], line["left"]) for line in lines if line["what"] == "done"] == [(2, 0), (4, 0)]
    assert b"Maria" not in b"".join(written(data))

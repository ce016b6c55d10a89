"""The index says what the folders say, keeps up with them, and is made again whatever happens to its file."""

import os
import sqlite3
import subprocess
import sys
import threading
from contextlib import closing
from pathlib import Path

import pytest
from helpers.cases import new_case, new_fit, new_link, new_scan, note
from helpers.on_disk import overwrite

from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.fits import claimed
from breastrig.cases.plans import put_plan
from breastrig.cases.removal import delete_case, delete_scan, move_scan
from breastrig.cases.writing import locked
from breastrig.index import ballast
from breastrig.index import file as files
from breastrig.index.index import Index
from breastrig.index.questions import (
    LinkSecret,
    aged_scans,
    case_of_fit,
    case_of_scan,
    cases_page,
    count_by_state,
    end_session,
    forget_link,
    is_session_over,
    next_waiting,
    note_opening,
    openings_of,
    put_secret,
    queue_positions,
    secret_of_link,
    secret_of_token,
)

Cases = dict[str, CaseFolder]
SECRET = LinkSecret("link-1", "aa" * 32, "scrypt$of$a$passcode", 2, "2026-01-01T00:00:00.000Z", 1)


def content(index: Index) -> list[object]:
    """All rows that repeat the folders, without the places in which they arrived."""
    of_case = "id, code, code_key, code_search, created_at, first_scan, plan, stamp"
    tables = (
        f"SELECT {of_case} FROM cases",
        "SELECT * FROM scans",
        "SELECT id, patient, scan, asked_at, state FROM fits",
    )
    return [index.asked(lambda rows, table=table: sorted(rows.execute(table).fetchall())) for table in tables]


def codes(index: Index, **more: object) -> list[str]:
    return [row.code for row in index.asked(cases_page, 50, **more)[0]]


def made_anew(root: Path) -> list[object]:
    """The content of another index of the same folder."""
    other = Index(root, root.parent / "other")
    other.folder.mkdir(exist_ok=True)
    other.rebuild()
    found = content(other)
    other.close()
    return found


def test_it_says_whose_a_scan_and_a_fit_are(index: Index, cases: Cases) -> None:
    for case in cases.values():
        [scan] = case.scan_ids()
        [fit] = os.listdir(case.scan_folder(scan) / "fits")
        assert index.asked(lambda rows, scan=scan: case_of_scan(rows, scan)) == case.id
        assert index.asked(lambda rows, fit=fit: case_of_fit(rows, fit)) == (case.id, scan)
    assert index.asked(case_of_scan, "nobody") is None
    assert index.asked(case_of_fit, "nobody") is None
    assert index.asked(count_by_state) == {"queued": 3}
    assert len(index.asked(aged_scans, "2026-01-02")) == 3
    assert index.asked(aged_scans, "2025") == []


def test_the_worklist_is_sorted_searched_and_paged(index: Index) -> None:
    assert codes(index) == ["Ärztin", "P 10", "P 2"]
    assert codes(index, sort="code") == ["P 2", "P 10", "Ärztin"]
    assert codes(index, search="ÄRZ") == ["Ärztin"]
    assert codes(index, search="%") == []
    for sort in ("newest", "code", "deletion"):
        found, last = [], None
        while True:
            page, last = index.asked(lambda rows, last=last, sort=sort: cases_page(rows, 1, last, sort=sort))
            found += [row.code for row in page]
            if last is None:
                break
        assert found == codes(index, sort=sort)


@pytest.mark.parametrize("sort", ["newest", "code", "deletion"])
def test_a_page_is_read_from_an_index_and_not_sorted(index: Index, sort: str) -> None:
    order = {"newest": "place DESC", "code": "code_key, place DESC", "deletion": "first_scan, place DESC"}[sort]
    plan = index.asked(
        lambda rows: rows.execute(f"EXPLAIN QUERY PLAN SELECT * FROM cases ORDER BY {order} LIMIT 50").fetchall()
    )
    assert not any("TEMP B-TREE" in row[3] for row in plan)


def test_a_look_sees_what_other_programs_have_written(index: Index, cases: Cases, root: Path) -> None:
    assert index.look() == 0
    one, two, three = cases.values()
    new = new_case(root / "cases", "new")
    new_scan(new)
    one.rename("other")
    move_scan(two, next(iter(two.scan_ids())), three)
    assert index.look() == 4
    assert sorted(codes(index)) == ["new", "other", "Ärztin"]
    delete_case(new)
    assert index.look() == 1
    assert content(index) == made_anew(root)


def test_a_case_that_is_being_written_waits_for_the_next_look(index: Index, cases: Cases) -> None:
    case = cases["P 2"]
    with case.writing():
        index.look()
    assert index.look() in (0, 1)
    case.rename("after")
    held = threading.Event()
    done = threading.Event()

    def hold() -> None:
        with locked(case.path):
            held.set()
            done.wait(30)

    holder = threading.Thread(target=hold)
    holder.start()
    held.wait(30)
    assert index.look() == 0
    assert "P 2" in codes(index)
    done.set()
    holder.join()
    assert index.look() == 1
    assert "after" in codes(index)


def test_the_end_of_a_fit_is_seen_and_the_queue_keeps_its_order(index: Index, cases: Cases) -> None:
    case = cases["P 2"]
    [scan] = case.scan_ids()
    more = [new_fit(case, scan) for _ in range(3)]
    index.refresh(case.id)
    first = index.asked(next_waiting)
    assert first is not None
    order = index.asked(queue_positions, [first[2], *more])
    assert order[first[2]] == 1
    with claimed(CaseFolder(index.root / "cases" / first[0]), first[1], first[2]) as claim:
        assert claim is not None
        claim.append({"kind": "done", "result": {"verdict": {"level": "good"}}})
    index.look()
    assert index.asked(count_by_state) == {"queued": 5, "done": 1}
    after = index.asked(queue_positions, [first[2], *more])
    assert first[2] not in after
    assert after == {fit: order[fit] - 1 for fit in more}
    taken = index.asked(next_waiting)
    assert taken is not None
    assert index.asked(next_waiting, [taken[2]]) not in (None, taken)


def test_a_copy_that_was_put_back_with_an_older_stamp_is_read(index: Index, cases: Cases) -> None:
    case = cases["P 2"]
    [scan] = case.scan_ids()
    put_plan(case, [note(scan, "later")])
    index.look()
    os.utime(case.path, ns=(1, 1))
    assert index.look() == 1
    assert index.look() == 0


def test_a_case_with_a_damaged_document_is_named_once_and_listed_again_when_it_is_mended(
    index: Index, cases: Cases, caplog: pytest.LogCaptureFixture
) -> None:
    case = cases["P 2"]
    kept = (case.path / "case.json").read_bytes()
    with case.writing():
        (case.path / "case.json").write_text("{")
    for _ in range(3):
        index.look()
    assert "P 2" not in codes(index)
    assert [record.getMessage()[:9] for record in caplog.records] == ["the case "]
    assert index.rebuild().unreadable == [case.id]
    with case.writing():
        (case.path / "case.json").write_bytes(kept)
    index.look()
    assert "P 2" in codes(index)


def test_what_is_no_case_of_ours_is_not_listed(index: Index, root: Path) -> None:
    for name in ("notes", "x" * 22, ".coming-1"):
        (root / "cases" / name).mkdir()
    CaseFolder.create(root / "cases" / "by another name", "strange")
    index.rebuild()
    assert "strange" not in codes(index)
    assert len(codes(index)) == 3


def damage(file: Path, how: str) -> None:
    size = file.stat().st_size
    match how:
        case "gone":
            file.unlink()
        case "empty":
            os.truncate(file, 0)
        case "cut":
            os.truncate(file, size // 2)
        case "overwritten":
            file.write_bytes(b"no database" * 1000)
        case "holes":
            with file.open("r+b") as opened:
                opened.seek(4096)
                opened.write(b"\xa5" * (size - 4096))
        case "another version":
            with closing(sqlite3.connect(file)) as rows:
                rows.execute("PRAGMA user_version = 99")
        case "another folder's":
            with closing(sqlite3.connect(file)) as rows, rows:
                rows.execute("UPDATE meta SET value = 'another' WHERE key = 'installation'")


@pytest.mark.parametrize("how", ["gone", "empty", "cut", "overwritten", "holes", "another version", "another folder's"])
def test_whatever_happens_to_its_file_it_is_made_again_at_the_start(index: Index, root: Path, how: str) -> None:
    with index.writing() as rows:
        put_secret(rows, SECRET)
    before = content(index)
    index.forget_deleted()
    index.close()
    file = files.current(root)
    assert file is not None
    damage(file, how)
    again = Index(root)
    found = again.prepare()
    assert found is not None
    assert (found.cases, found.scans, found.fits) == (3, 3, 3)
    assert content(again) == before
    known = again.asked(secret_of_token, SECRET.token_sha256)
    assert known == (SECRET if how == "another version" else None)  # the secrets of another folder open nothing here
    assert found.links_kept == (how == "another version")
    assert again.prepare() is None
    again.close()
    assert len(list(root.glob("index-*.sqlite3"))) == 1


def test_a_file_that_goes_while_it_is_used_is_made_again_and_nothing_is_missed(index: Index, root: Path) -> None:
    before = content(index)
    for _ in range(3):
        for file in root.glob("index-*"):
            file.unlink()
        assert content(index) == before
        with index.writing() as rows:
            put_secret(rows, SECRET)
        assert index.asked(secret_of_token, SECRET.token_sha256) == SECRET


def test_damage_in_its_place_is_noticed_while_it_is_used(index: Index, root: Path) -> None:
    """Whoever has it open still answers out of the pages that it remembers, so a fresh connection looks."""
    before = content(index)
    assert index.check()
    index.forget_deleted()
    file = files.current(root)
    assert file is not None
    overwrite(file, 4096, file.stat().st_size)
    assert not index.check()
    assert files.current(root) != file
    assert content(index) == before == made_anew(root)
    assert index.check()


def test_damage_that_a_writer_meets_is_mended_and_nothing_is_missed(index: Index, cases: Cases, root: Path) -> None:
    case = cases["P 2"]
    case.rename("after")
    index.forget_deleted()
    index.close()
    file = files.current(root)
    assert file is not None
    overwrite(file, 4096, file.stat().st_size)
    index.refresh(case.id)
    assert "after" in codes(index)
    assert content(index) == made_anew(root)
    index.forget_deleted()
    index.close()
    file = files.current(root)
    assert file is not None
    overwrite(file, 4096, file.stat().st_size)
    with pytest.raises(sqlite3.DatabaseError), index.writing() as rows:
        put_secret(rows, SECRET)
    with index.writing() as rows:
        put_secret(rows, SECRET)
    assert content(index) == made_anew(root)


def test_on_a_full_disk_room_that_was_kept_is_given_up_for_it(index: Index, root: Path, monkeypatch) -> None:
    def kept() -> int:
        return len(list(root.glob("index-ballast-*")))

    assert kept() == ballast.PIECES
    full = [2]

    def looked() -> int:
        if full[0]:
            full[0] -= 1
            raise OSError(28, "No space left on device")
        return 0

    monkeypatch.setattr(index, "look", looked)
    monkeypatch.setattr("breastrig.index.index.ballast.keep", lambda _folder: None)
    index.prepare()
    assert kept() == ballast.PIECES - 2
    full[0] = 3
    with pytest.raises(OSError, match="No space"):
        index.prepare()
    assert kept() == 0
    monkeypatch.undo()
    index.keep_room()
    assert kept() == ballast.PIECES


def test_a_rebuild_while_others_write_and_read_loses_no_secret(index: Index) -> None:
    stop, written, failed = threading.Event(), list[str](), list[BaseException]()

    def write() -> None:
        try:
            while not stop.is_set():
                token = f"{len(written):064}"
                with index.writing() as rows:
                    put_secret(rows, LinkSecret(f"link-{len(written)}", token))
                written.append(token)
                assert len(codes(index)) == 3
        except BaseException as error:
            failed.append(error)

    writer = threading.Thread(target=write)
    writer.start()
    for _ in range(5):
        assert index.rebuild().links_kept
    stop.set()
    writer.join()
    assert failed == []
    kept = index.asked(lambda rows: {row[0] for row in rows.execute("SELECT token_sha256 FROM link_secrets")})
    assert kept == set(written)


def test_a_file_that_is_exchanged_before_a_reader_has_opened_it_is_not_missed(index: Index, root: Path, monkeypatch):
    index.close()
    connected = files.connected

    def exchanged_first(file: Path) -> sqlite3.Connection:
        monkeypatch.setattr(files, "connected", connected)
        Index(root).rebuild()
        return connected(file)

    monkeypatch.setattr(files, "connected", exchanged_first)
    assert codes(index) == ["Ärztin", "P 10", "P 2"]
    index.close()
    monkeypatch.setattr(files, "connected", lambda file: connected(file.with_name("not there")))
    with pytest.raises(sqlite3.OperationalError):
        codes(index)


def test_two_programs_that_make_it_at_once_leave_one(index: Index, root: Path) -> None:
    others = [Index(root) for _ in range(3)]
    threads = [threading.Thread(target=other.rebuild) for other in others]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(list(root.glob("index-*.sqlite3"))) == 1
    assert list(root.glob("*.new*")) == []
    assert {tuple(codes(each)) for each in (index, *others)} == {("Ärztin", "P 10", "P 2")}
    for other in others:
        other.close()


def test_a_full_disk_leaves_the_index_that_is_there(index: Index, root: Path, monkeypatch) -> None:
    before, file = content(index), files.current(root)

    def full(*_given: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("breastrig.index.file.os.replace", full)
        with pytest.raises(OSError, match="No space"):
            index.rebuild()
    assert files.current(root) == file
    assert content(index) == before
    assert list(root.glob("*.new*")) == []
    with index.writing() as rows:  # nobody holds it
        put_secret(rows, SECRET)


def test_only_its_owner_can_read_it(index: Index, root: Path) -> None:
    assert {file.stat().st_mode & 0o077 for file in root.glob("index*")} == {0}


def test_no_case_holds_what_opens_a_link(index: Index, root: Path) -> None:
    with index.writing() as rows:
        put_secret(rows, SECRET)
        note_opening(rows, SECRET.link, "2026-01-01T00:00:00.000Z", "bb" * 32)
    assert index.asked(openings_of, SECRET.link) == ["2026-01-01T00:00:00.000Z"]
    kept = b"".join(file.read_bytes() for file in (root / "cases").rglob("*") if file.is_file())
    for word in ("scrypt", SECRET.token_sha256):
        assert word.encode() not in kept
    with index.writing() as rows:
        forget_link(rows, SECRET.link)
    assert index.forget_deleted()
    index.close()
    assert b"scrypt" not in b"".join(file.read_bytes() for file in root.glob("index-*"))


def test_links_that_another_program_deleted_are_forgotten_and_no_others(index: Index, cases: Cases) -> None:
    links = {code: new_link(case) for code, case in cases.items()}
    index.look()
    with index.writing() as rows:
        for code, link in links.items():
            put_secret(rows, LinkSecret(link, code, "scrypt"))
            note_opening(rows, link, "2026-01-01T00:00:00.000Z", "bb" * 32)
    damaged = (cases["P 2"].path / "case.json").read_bytes()
    with cases["P 2"].writing():
        (cases["P 2"].path / "case.json").write_text("{")
    [scan] = cases["Ärztin"].scan_ids()
    moved_to = new_case(index.root / "cases")
    move_scan(cases["Ärztin"], scan, moved_to)
    delete_case(cases["P 10"])
    for _ in range(3):
        index.look()
    with cases["P 2"].writing():
        (cases["P 2"].path / "case.json").write_bytes(damaged)
    assert [index.look() for _ in range(3)] == [1, 1, 0]
    known = {code: index.asked(lambda rows, code=code: secret_of_token(rows, code)) for code in links}
    assert {code for code, secret in known.items() if secret is not None} == {"P 2", "Ärztin"}
    assert index.asked(openings_of, links["P 10"]) == []


def test_an_error_undoes_all_that_was_written(index: Index) -> None:
    def write_and_fail() -> None:
        with index.writing() as rows:
            put_secret(rows, SECRET)
            raise RuntimeError

    with pytest.raises(RuntimeError):
        write_and_fail()
    assert index.asked(secret_of_link, SECRET.link) is None


def test_a_reader_does_not_wait_for_a_writer_and_sees_what_was_before(index: Index) -> None:
    with index.writing() as rows:
        put_secret(rows, SECRET)
        assert index.asked(secret_of_link, SECRET.link) is None
    assert index.asked(secret_of_link, SECRET.link) == SECRET


def test_writers_wait_for_each_other(index: Index, root: Path) -> None:
    steps: list[str] = []
    other, inside = Index(root), threading.Event()

    def second() -> None:
        inside.wait()
        with other.writing():
            steps.append("second")

    thread = threading.Thread(target=second)
    thread.start()
    with index.writing():
        inside.set()
        thread.join(timeout=0.1)
        steps.append("first")
    thread.join()
    other.close()
    assert steps == ["first", "second"]


def test_a_look_for_damage_takes_no_lock_away(index: Index, root: Path) -> None:
    """Else another process that closes the file would remove the log, and with it what was written last."""
    with index.writing() as rows:
        put_secret(rows, SECRET)
    look = "import sqlite3, sys; rows = sqlite3.connect(sys.argv[1]); rows.execute('SELECT * FROM scans'); rows.close()"
    file = files.current(root)
    assert index.check()
    subprocess.run([sys.executable, "-c", look, str(file)], check=True)
    assert Path(f"{file}-wal").stat().st_size > 0
    assert index.asked(secret_of_link, SECRET.link) == SECRET


def test_sessions_of_before_a_lost_index_are_over(index: Index, root: Path) -> None:
    first = "2026-01-01T00:00:00.000Z"
    with index.writing() as rows:
        rows.execute("DELETE FROM meta WHERE key = 'sessions_from'")
        end_session(rows, "cc" * 32, first)
    assert index.asked(is_session_over, "cc" * 32, first)
    assert not index.asked(is_session_over, "dd" * 32, first)
    index.rebuild()
    assert index.asked(is_session_over, "cc" * 32, first)
    assert not index.asked(is_session_over, "dd" * 32, first)
    for file in root.glob("index-*"):
        file.unlink()
    assert index.asked(is_session_over, "dd" * 32, first)
    assert not index.asked(is_session_over, "dd" * 32, "2999-01-01T00:00:00.000Z")


def test_a_deleted_scan_leaves_no_row(index: Index, cases: Cases, root: Path) -> None:
    case = cases["P 2"]
    [scan] = case.scan_ids()
    new_scan(case)
    delete_scan(case, scan)
    index.refresh(case.id)
    delete_case(cases["P 10"])
    index.refresh(cases["P 10"].id)
    index.forget_deleted()
    index.close()
    kept = b"".join(file.read_bytes() for file in root.glob("index-*"))
    for word in (scan, cases["P 10"].id, "P 10"):
        assert word.encode() not in kept

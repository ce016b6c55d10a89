"""The index: made again from the folders where it is lost, kept up with them by their stamps, asked.

`look` compares the stamps of the folders with those that were read, so it sees what other programs write.  No case is
lost with an index, but links are closed (their secrets are nowhere else), and sessions that began before are refused,
as those that were ended would live again.
"""

import logging
import os
import sqlite3
import threading
from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Concatenate, ParamSpec, TypeVar

from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder, utc_now
from breastrig.cases.writing import locked, stamp_of
from breastrig.core.errors import BadInput, Conflict, NotFound
from breastrig.index import ballast, questions
from breastrig.index import file as files
from breastrig.index.read_case import CaseRows, Row, read_case
from breastrig.index.schema import ONLY_HERE, TABLES

WRITER_S = 30.0  # so long a refresh waits for who writes into the case

Answer = TypeVar("Answer")
Given = ParamSpec("Given")
log = logging.getLogger(__name__)


@dataclass
class Rebuilt:
    """Counts of what was found in the folders."""

    cases: int = 0
    scans: int = 0
    fits: int = 0
    busy: int = 0  # cases into which somebody was writing: the next `look` reads them
    unreadable: list[str] = field(default_factory=list)  # ids of cases with a damaged document
    links_kept: bool = True  # else the links of all cases are closed, and older sessions are over


class Index:
    """The index of one data folder. May be used from any thread, and by several processes."""

    def __init__(self, root: Path, folder: Path | None = None) -> None:
        """`folder` for the index on a local disk, where the data folder is on none."""
        self.root, self.folder = root, folder or root
        self._idle: list[sqlite3.Connection] = []  # to the file of `_identity`
        self._identity: files.Identity | None = None
        self._lock = threading.Lock()  # of these two
        self._writer = threading.RLock()  # what is written is not lost in a file that is being exchanged
        self._unreadable: dict[str, int] = {}  # {case: stamp} that the log has named
        self.changes = 0  # grows when this process has changed it

    def prepare(self) -> Rebuilt | None:
        """Makes the index again where that is needed, and takes up what other programs have written since.

        What was found in the folders; None where the index was sound.
        """
        found = self.making_room(self._prepare)
        ballast.keep(self.folder)
        return found

    def making_room(self, action: Callable[[], Answer]) -> Answer:
        """The action's result; where the disk is full, reserved space is given up for it. Raises as the action does."""
        while True:
            try:
                return action()
            except (sqlite3.Error, OSError) as error:
                if not files.is_full(error) or not ballast.give_up(self.folder):
                    raise
                log.error("the disk is full; room that was kept for the index is given up")

    def keep_room(self) -> None:
        """Keeps reserve files for times when the disk is full, as far as there is room."""
        ballast.keep(self.folder)

    def _prepare(self) -> Rebuilt | None:
        there = files.current(self.folder)
        fault = files.fault_of(there, self._installation())
        if fault is None:
            if self.look():
                self.forget_deleted()
            return None
        if there is not None:
            log.error("the index %s; it is made again from the folders", fault)
        return self.rebuild()

    def rebuild(self) -> Rebuilt:
        """Makes the index again from the folders, in a new file that then takes the place of the old one.

        What is nowhere else is copied if it can be read.
        """
        with ExitStack() as exchanged, files.made(self.folder) as (rows, before):
            rows.executescript(TABLES)
            found = self._fill(rows)
            exchanged.enter_context(self._writer)  # others wait until the new file is in force
            with files.transaction(rows):
                found.links_kept = self._copy_what_is_only_here(before, rows)
                rows.execute("INSERT INTO meta VALUES ('installation', ?)", (self._installation(),))
        self.close()
        for case_id in found.unreadable:
            log.error("a document of the case %s is damaged; the case is not listed", case_id)
        return found

    def look(self) -> int:
        """Reads the cases again whose stamps have changed, forgets those that are gone; how many they were.

        One into which somebody is writing waits for the next time.  Where nothing has changed, links are forgotten that
        are in no case any more.
        """
        before, found = self.changes, dict(self._stamps())
        known = self.asked(lambda rows: dict(rows.execute("SELECT id, stamp FROM cases").fetchall()))
        changed = 0
        for case_id in known.keys() - found.keys():
            self._forget(case_id)
            changed += 1
        for case_id, stamp in found.items():
            if stamp != known.get(case_id) and self._unreadable.get(case_id) != stamp:
                with suppress(Conflict):
                    self._take(case_id, 0.0)
                    changed += 1
        return changed or (self._forget_links(before) if found == known else 0)

    def refresh(self, case_id: str) -> None:
        """Reads a case again, after it was written or deleted.  Raises Conflict when somebody goes on writing there."""
        try:
            self._take(case_id, WRITER_S)
        except sqlite3.DatabaseError as error:
            if not files.is_damage(error):
                raise
            self._take(case_id, WRITER_S)  # into the new file

    def catch_up(self, case_ids: Collection[str]) -> set[str]:
        """Reads those of the cases again whose stamps have changed.

        Returns those that are still behind, as somebody is writing into them or the disk is full.
        """
        behind = set()
        known = self.asked(questions.stamps, case_ids)
        for case_id in case_ids:
            try:
                if stamp_of(self._folder(case_id)) == known.get(case_id):
                    continue
            except FileNotFoundError:
                pass  # it is gone
            try:
                self._take(case_id, 0.0)
            except Conflict:
                behind.add(case_id)
            except sqlite3.OperationalError as error:
                if not files.is_full(error):
                    raise
                behind.add(case_id)
        return behind

    def asked(
        self,
        question: Callable[Concatenate[sqlite3.Connection, Given], Answer],
        *given: Given.args,
        **named: Given.kwargs,
    ) -> Answer:
        """The answer to a question that reads one state; a damaged file is made again, and asked once more."""
        try:
            with self._connection() as rows:
                return _answer(rows, question, *given, **named)
        except sqlite3.DatabaseError as error:
            if not files.is_damage(error):
                raise
        self._rebuild_damaged()
        with self._connection() as rows:
            return _answer(rows, question, *given, **named)

    @contextmanager
    def writing(self) -> Iterator[sqlite3.Connection]:
        """A transaction that holds the write lock from its start, and undoes all on an error.

        A damaged file is made again, and the error raised: what was to be written may be sent again.
        """
        try:
            with self._writer, self._connection() as rows, files.transaction(rows):
                yield rows
        except sqlite3.DatabaseError as error:
            if files.is_damage(error):
                self._rebuild_damaged()
            raise
        self.changes += 1

    def _rebuild_damaged(self) -> None:
        log.error("the index is damaged; it is made again from the folders")
        self.rebuild()

    def forget_deleted(self) -> bool:
        """Empties SQLite's log, so that no deleted row is left in any file; False: to be done later."""
        with self._connection() as rows:
            busy, *_ = rows.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()
        return not busy

    def check(self) -> bool:
        """Whether the file is sound as far as some seconds show; one that is not is made again."""
        fault = files.fault_of(files.current(self.folder), self._installation())
        if fault is not None:
            log.error("the index %s; it is made again from the folders", fault)
            self.rebuild()
        return fault is None

    def close(self) -> None:
        """Closes the idle connections."""
        with self._lock:
            idle, self._idle = self._idle, []
        for rows in idle:
            rows.close()

    @contextmanager
    def _connection(self) -> Iterator[sqlite3.Connection]:
        """A connection to the file in force; where that is gone, it is made again first."""
        now = files.identity(self.folder)
        if now is None:
            log.error("the index is gone; it is made again from the folders")
            self.rebuild()
            now = files.identity(self.folder)
        with self._lock:
            stale = self._idle if now != self._identity else []
            if stale:
                self._idle = []
            self._identity = now
            rows = self._idle.pop() if self._idle else None
        for each in stale:
            each.close()
        if rows is None:
            assert now is not None
            try:
                rows = files.connected(self.folder / now[0])
            except sqlite3.OperationalError:
                if files.identity(self.folder) == now:
                    raise
                with self._connection() as rows:  # of the file that has taken its place meanwhile
                    yield rows
                return
        try:
            yield rows
        finally:
            if rows.in_transaction:
                rows.rollback()
            with self._lock:
                kept = now == self._identity
                if kept:
                    self._idle.append(rows)
            if not kept:
                rows.close()

    def _installation(self) -> str:
        try:
            return (self.root / layout.MARK).read_text("ascii", "replace")
        except FileNotFoundError:
            return ""

    def _copy_what_is_only_here(self, before: Path | None, rows: sqlite3.Connection) -> bool:
        """Copies from the file that was in force; False where it cannot be read: links and sessions are closed."""
        try:
            if before is None:
                if not any(self._stamps()):
                    return True  # a new data folder, where nothing was ended yet
                raise sqlite3.DatabaseError("there is none")
            with closing(files.opened(before)) as old:  # as it is: others may hold it
                if files.installation_of(old) != self._installation():
                    raise sqlite3.DatabaseError("it is of another data folder")
                copied = {table: _content(old, table) for table in ONLY_HERE}
                since = old.execute("SELECT value FROM meta WHERE key = 'sessions_from'").fetchone()
        except sqlite3.Error as error:
            if files.is_full(error):
                raise
            rows.execute(
                "INSERT INTO meta VALUES ('sessions_from', ?)", (f"{utc_now()[:19]}.000Z",)
            )  # cookies know seconds
            return False
        for table, (columns, content) in copied.items():
            marks = ", ".join("?" for _ in columns)
            rows.executemany(f"INSERT INTO {table} ({', '.join(columns)}) VALUES ({marks})", content)
        if since is not None:
            rows.execute("INSERT INTO meta VALUES ('sessions_from', ?)", since)
        return True

    def _fill(self, rows: sqlite3.Connection) -> Rebuilt:
        found, fits = Rebuilt(), list[Row]()
        with files.transaction(rows):
            for case_id, stamp in sorted(self._stamps(), key=self._arrival):
                try:
                    case = CaseFolder(self._folder(case_id))
                    with locked(case.path, 0.0):
                        read = read_case(case)
                except NotFound:
                    continue
                except Conflict:
                    found.busy += 1
                    continue
                except BadInput:
                    found.unreadable.append(case_id)
                    self._unreadable[case_id] = stamp
                    continue
                _put(rows, CaseRows(read.case, read.scans, (), read.links))
                fits += read.fits
                found.cases, found.scans = found.cases + 1, found.scans + len(read.scans)
            fits.sort(key=lambda fit: (str(fit[3]), str(fit[0])))  # as they were asked for
            for fit in fits:
                _put_fit(rows, fit)
        found.fits = len(fits)
        return found

    def _arrival(self, one: tuple[str, int]) -> tuple[str, str]:
        """The arrival time of a case, as its document states it; a damaged one first."""
        with suppress(BadInput):
            return CaseFolder(self._folder(one[0])).document().created_at, one[0]
        return "", one[0]

    def _stamps(self) -> Iterator[tuple[str, int]]:
        """(case, its stamp) of all that are in the data folder."""
        try:
            names = os.listdir(self.root / layout.CASES)
        except FileNotFoundError:
            return
        for name in names:
            if layout.ID.fullmatch(name):
                with suppress(FileNotFoundError):
                    yield name, stamp_of(self._folder(name))

    def _folder(self, case_id: str) -> Path:
        return self.root / layout.CASES / case_id

    def _take(self, case_id: str, wait_s: float) -> None:
        """Reads a case into the index. Raises Conflict when somebody goes on writing into the case."""
        try:
            case = CaseFolder(self._folder(case_id))
            with locked(case.path, wait_s):  # so that what is put is not older than what another has put
                read = read_case(case)
                with self.writing() as rows:
                    _put(rows, read)
        except NotFound:
            self._forget(case_id)
        except Conflict:
            raise
        except BadInput as error:
            log.error("the case %s is not listed: %s", case_id, error)
            with suppress(FileNotFoundError):
                self._unreadable[case_id] = stamp_of(self._folder(case_id))
            self._forget(case_id)

    def _forget(self, case_id: str) -> None:
        with self.writing() as rows:
            for table, column in (("cases", "id"), ("scans", "patient"), ("fits", "patient"), ("links", "patient")):
                rows.execute(f"DELETE FROM {table} WHERE {column} = ?", (case_id,))

    def _forget_links(self, changes: int) -> int:
        """Links that other programs have deleted, or this one before it was killed; how many they were.

        None where something has changed since: a scan that moves may be in neither case as they were read.
        """
        if not self.asked(questions.links_gone):
            return 0
        with self.writing() as rows:
            gone = questions.links_gone(rows) if self.changes == changes else []
            for link in gone:
                questions.forget_link(rows, link)
        return len(gone)


def _answer(
    rows: sqlite3.Connection,
    question: Callable[Concatenate[sqlite3.Connection, Given], Answer],
    *given: Given.args,
    **named: Given.kwargs,
) -> Answer:
    rows.execute("BEGIN")
    try:
        return question(rows, *given, **named)
    finally:
        rows.rollback()


def _put(rows: sqlite3.Connection, read: CaseRows) -> None:
    """The rows of one case in place of those that are there; fits that are there keep their places."""
    case_id = read.case[0]
    rows.execute(
        "INSERT INTO cases (id, code, code_key, code_search, created_at, first_scan, plan, planned, owner, stamp) "
        "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT (id) DO UPDATE SET code = excluded.code, "
        "code_key = excluded.code_key, code_search = excluded.code_search, created_at = excluded.created_at, "
        "first_scan = excluded.first_scan, plan = excluded.plan, planned = excluded.planned, owner = excluded.owner, "
        "stamp = excluded.stamp",
        read.case,
    )
    for table in ("scans", "links"):
        rows.execute(f"DELETE FROM {table} WHERE patient = ?", (case_id,))
    rows.executemany("INSERT OR REPLACE INTO scans VALUES (?, ?, ?, ?, ?, ?, ?)", read.scans)
    rows.executemany("INSERT OR REPLACE INTO links VALUES (?, ?, ?, ?, ?, ?)", read.links)
    here = {fit[0] for fit in read.fits}
    before = {row[0] for row in rows.execute("SELECT id FROM fits WHERE patient = ?", (case_id,))}
    rows.executemany("DELETE FROM fits WHERE id = ?", [(gone,) for gone in before - here])
    for fit in sorted(read.fits, key=lambda fit: (str(fit[3]), str(fit[0]))):
        _put_fit(rows, fit)


def _put_fit(rows: sqlite3.Connection, fit: tuple[object, ...]) -> None:
    rows.execute(
        "INSERT INTO fits (id, patient, scan, asked_at, state, verdict, line_error_mm, predicted_from, asked_stance, "
        "key_sha256, request_sha256, stance) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) "
        "ON CONFLICT (id) DO UPDATE SET patient = excluded.patient, scan = excluded.scan, verdict = excluded.verdict, "
        "line_error_mm = excluded.line_error_mm, asked_at = excluded.asked_at, predicted_from = "
        "excluded.predicted_from, asked_stance = excluded.asked_stance, key_sha256 = excluded.key_sha256, "
        "request_sha256 = excluded.request_sha256, stance = excluded.stance, "
        # one that was taken up has no line yet, and does not wait any more
        "state = CASE WHEN fits.state = 'running' AND excluded.state = 'queued' THEN 'running' ELSE excluded.state END",
        fit,
    )


def _content(rows: sqlite3.Connection, table: str) -> tuple[list[str], list[tuple[object, ...]]]:
    found = rows.execute(f"SELECT * FROM {table}")
    return [column[0] for column in found.description], found.fetchall()

"""Appends to the audit log: one JSON line an entry, each with the hash of the line before it.

audit/0000000001.jsonl   lines, named by the number of its first one; another file follows beyond 4 MB
audit/end                number and SHA-256 of the last line, so that a cut at the end shows
audit/reserve            room for deletions on a full disk
audit/.lock              held by whoever appends

`before` of a line is the SHA-256 of the bytes of the line before it, without its line break.  All that `append` has
returned is on the disk.
"""

import hashlib
import json
import os
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from filelock import lock_descriptor

from breastrig.cases.case_folder import utc_now
from breastrig.cases.layout import MARK, data_folder_of
from breastrig.cases.writing import FULL, LOCK, LOOK_S, sync_folder
from breastrig.core.private_files import private_folder

FOLDER, END, RESERVE = "audit", "end", "reserve"
FIRST = "0" * 64  # what the first line names as the hash of the line before it
ROTATE_BYTES = 4_000_000
LINE_BYTES = 16_384
RESERVE_BYTES = 65_536  # no disk can store random bytes in less
LATER = 100  # openings that wait to be written together
LATER_MOST = 100_000  # on a disk that stays full; of more, the oldest are lost, and their number is written
LATER_S = 2.0

Fields = Mapping[str, object]


@dataclass(frozen=True)
class Entry:
    """What was done.  `of`: ids by kind, patient, scan, fit, link.  Never a code, a name of a patient or a content."""

    who: str
    what: str  # open, change, export, link, delete; done, refused: of an earlier line; service, mended, lost, begin
    how: str = ""  # the call or command
    of: Mapping[str, str] = field(default_factory=dict)
    more: Fields = field(default_factory=dict)
    at: str = field(default_factory=utc_now)


@dataclass(frozen=True)
class Mark:
    """A line by its number and the SHA-256 of its bytes; number 0 before the first."""

    line: int = 0
    sha256: str = FIRST

    def __str__(self) -> str:
        return f"{self.line}:{self.sha256}"


class AuditLog:
    """The log of one data folder. May be used from any thread and process."""

    def __init__(self, root: Path) -> None:
        self.folder = root / FOLDER
        self.root = root
        self._lock = threading.Lock()
        self._waiting: list[Entry] = []
        self._since = time.monotonic()
        self._lost = 0

    def append(self, *entries: Entry) -> list[Mark]:
        """Writes entries, after those that wait; the marks of their lines.  Raises OSError: then none is written."""
        with self._lock, self._alone():
            return self._write(entries)

    def append_deletion(self, entry: Entry) -> Mark | None:
        """As `append`, with the room that is reserved for it; on a disk that is full even so, None: it is later."""
        for spare in (True, False):
            try:
                return self.append(entry)[0]
            except OSError as error:
                if error.errno not in FULL:
                    raise
                if spare:
                    (self.folder / RESERVE).unlink(missing_ok=True)
        self.later(entry)
        return None

    def later(self, entry: Entry) -> None:
        """Writes an entry with the next ones, in some seconds at most; where nothing can be written, when it can."""
        with self._lock:
            if not self._waiting:
                self._since = time.monotonic()
            self._waiting.append(entry)
            if len(self._waiting) > LATER_MOST:
                self._lost += 1
                del self._waiting[0]
            due = len(self._waiting) % LATER == 0 or time.monotonic() - self._since > LATER_S
        if due:
            self.flush()

    def flush(self) -> None:
        """Writes what waits, as far as there is room."""
        if self._waiting:
            with suppress(OSError):
                self.append()

    def end(self) -> Mark:
        """The last line. Raises OSError, ValueError."""
        with self._lock, self._alone():
            return self._last()[1]

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Holds the log. Raises OSError where it cannot be written."""
        private_folder(self.folder)
        lock = os.open(self.folder / LOCK, os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
        try:
            lock_descriptor(lock, poll_interval=LOOK_S)
            yield
        finally:
            os.close(lock)

    def _write(self, entries: tuple[Entry, ...]) -> list[Mark]:
        file, last, half = self._last()
        extra = [Entry("service", "lost", more={"openings": self._lost})] if self._lost else []
        if half:
            extra.append(Entry("service", "mended", more={"half_line_bytes": half}))
        if last == Mark():
            extra.append(Entry("service", "begin", more={"installation": installation_of(self.root)}))
        marks, lines = [], []
        for entry in (*extra, *self._waiting, *entries):
            content = _line(entry, last)
            last = Mark(last.line + 1, hashlib.sha256(content).hexdigest())
            marks.append(last)
            lines.append(content + b"\n")
        if not lines:
            return []
        if file is None or file.stat().st_size > ROTATE_BYTES:
            file = self.folder / f"{marks[0].line:010}.jsonl"
        _appended(file, b"".join(lines))
        self._waiting, self._lost = [], 0
        with suppress(OSError):  # a mark that lies behind is true, too
            _put_end(self.folder / END, last)
        self._keep_reserve()
        return marks[len(marks) - len(entries) :]

    def _last(self) -> tuple[Path | None, Mark, int]:
        """The newest file, its last line, and the bytes of half a line of a killed writer, which is cut off.

        Where lines that were noted are missing or are others, the chain goes on from what was noted: so that shows.
        """
        files = log_files(self.folder)
        found, half = Mark(), 0
        for file in reversed(files):
            with file.open("r+b") as stream:
                size = stream.seek(0, os.SEEK_END)
                stream.seek(max(0, size - 2 * LINE_BYTES))
                content = stream.read()
                whole, _, rest = content.rpartition(b"\n")
                if rest:
                    half += len(rest)
                    stream.truncate(size - len(rest))
            if whole:
                line = whole.rpartition(b"\n")[2]
                found = Mark(number_of(line), hashlib.sha256(line).hexdigest())
                break
        noted = noted_end(self.folder)
        return files[-1] if files else None, found if found.line > noted.line else noted, half

    def _keep_reserve(self) -> None:
        reserve = self.folder / RESERVE
        if not reserve.exists():
            try:
                reserve.touch(mode=0o600)
                reserve.write_bytes(os.urandom(RESERVE_BYTES))
            except OSError:
                reserve.unlink(missing_ok=True)


def log_files(folder: Path) -> list[Path]:
    """The files of the log, oldest first."""
    return sorted(folder.glob("[0-9]" * 10 + ".jsonl"))


def number_of(line: bytes) -> int:
    """The number of a line. Raises ValueError for what is none."""
    head, comma, _ = line[:32].partition(b",")
    if not head.startswith(b'{"n":') or not comma:
        raise ValueError("a line of the audit log has no number")
    return int(head[5:])


def noted_end(folder: Path) -> Mark:
    """The last line as it was noted beside the lines."""
    try:
        number, _, sha256 = (folder / END).read_text("ascii", "replace").strip().partition(":")
        return Mark(int(number), sha256)
    except (FileNotFoundError, ValueError):
        return Mark()


def installation_of(root: Path) -> str:
    try:
        return (root / MARK).read_text("ascii", "replace")
    except FileNotFoundError:
        return ""


def log_of_case(case: Path) -> AuditLog | None:
    """The log of the data folder that a case is in; None: it stands alone, and no log is kept."""
    root = data_folder_of(case.absolute())
    return None if root is None else AuditLog(root)


def _line(entry: Entry, last: Mark) -> bytes:
    document = {"n": last.line + 1, "before": last.sha256, "at": entry.at, "who": entry.who, "what": entry.what}
    document |= {"how": entry.how} if entry.how else {}
    document |= {"of": dict(entry.of)} if entry.of else {}
    content = json.dumps(document | dict(entry.more), separators=(",", ":")).encode()
    if len(content) > LINE_BYTES:
        raise ValueError("an entry of the audit log is too long")
    return content


def _appended(file: Path, content: bytes) -> None:
    """All of it, on the disk, or nothing. Raises OSError."""
    is_new = not file.exists()
    descriptor = os.open(file, os.O_WRONLY | os.O_APPEND | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
    try:
        size = os.fstat(descriptor).st_size
        try:
            written = 0
            while written < len(content):
                written += os.write(descriptor, content[written:])
            os.fsync(descriptor)
        except BaseException:
            os.ftruncate(descriptor, size)
            raise
    finally:
        os.close(descriptor)
    if is_new:
        sync_folder(file.parent)


def _put_end(file: Path, mark: Mark) -> None:
    """In place, in one write of always the same length."""
    descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
    try:
        os.write(descriptor, f"{mark.line:012}:{mark.sha256}\n".encode())
    finally:
        os.close(descriptor)

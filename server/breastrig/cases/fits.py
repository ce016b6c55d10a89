"""Fits of a scan: asked for, run by the one who holds their claim, one event a line.

`fit.log.jsonl` is the stream of events: line N is event N, and a line counts with its newline.  Only the holder of
`.claim`, a lock of the kernel, appends; so a fit has one end, whoever dies.  The end is appended under the case's lock.
"""

import json
import os
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from filelock import lock_descriptor

from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.documents import FitDocument, content_of
from breastrig.cases.layout import fit_part, new_id, scan_part
from breastrig.cases.writing import LOOK_S, put, sync_folder
from breastrig.core.errors import Conflict, FitFailed, NotFound
from breastrig.scan.true_size import kept_factor

STATES = ("queued", "running", "done", "failed", "cancelled")
ENDED = frozenset(STATES[2:])
ATTEMPTS = 3  # one that takes its machine down with it must not do so for ever
LEAVES_S = 5.0  # from the end of a fit until its worker has tidied up
TAIL = 2**16  # bytes of the log's end that are read first; an iteration takes 2.5 kB, a result some ten
NO_FIT = "There is no such fit; it may have been deleted."
OTHER_SIZE = "The scan got another size after this fit was asked for; fit it again."
CANCELLED = {"kind": "cancelled", "reason": "The fit was cancelled."}
OTHER_MODEL = "The model was exchanged after this fit had started; start the fit again."
TOO_OFTEN = "This fit was started {} times without an end, as its server or worker ended first; start the fit again."


@dataclass(frozen=True)
class FitEntry:
    """One fit of a scan, with its progress."""

    id: str
    scan: str
    document: FitDocument
    state: str  # queued, running, done, failed, cancelled
    last: dict[str, Any] | None  # the last event; None before the first

    @property
    def verdict(self) -> str | None:
        """good, uncalibrated, check or unusable; None before the end."""
        level: str | None = ((self.last or {}).get("result", {}).get("verdict") or {}).get("level")
        return level

    @property
    def line_error_mm(self) -> float | None:
        """90 % line error on the breasts; None before the end, and where it is not known."""
        error: float | None = (self.last or {}).get("result", {}).get("line_error_mm")
        return error


def fit_ids(case: CaseFolder, scan_id: str) -> list[str]:
    """The ids of the scan's fits. Raises NotFound."""
    case.check_scan(scan_id)
    try:
        names = os.listdir(case.scan_folder(scan_id) / layout.FITS)
    except FileNotFoundError:
        return []
    return [name for name in names if layout.ID.fullmatch(name)]


def fits_of_scan(case: CaseFolder, scan_id: str) -> list[FitEntry]:
    """The scan's fits, oldest first. Raises NotFound."""
    found = [get_fit(case, scan_id, fit_id) for fit_id in fit_ids(case, scan_id)]
    return sorted(found, key=lambda fit: (fit.document.asked_at, fit.id))


def get_fit(case: CaseFolder, scan_id: str, fit_id: str) -> FitEntry:
    """The fit's entry. Raises NotFound."""
    case.check_scan(scan_id)
    part = fit_part(scan_id, fit_id)
    document = case.read(f"{part}/{layout.FIT}", FitDocument)
    if document is None:
        raise NotFound(NO_FIT)
    last = last_event(case.path / part)
    return FitEntry(fit_id, scan_id, document, state_of(case.path / part, document, last), last)


def reason_of(folder: Path, document: FitDocument, last: dict[str, Any] | None) -> str | None:
    """Why the fit failed or was cancelled."""
    reason: str | None = (last or {}).get("reason")
    return OTHER_SIZE if is_of_other_size(folder, document) else reason


def is_of_other_size(folder: Path, document: FitDocument) -> bool:
    """Whether the scan has another size by now than the fit has."""
    return document.scale != kept_factor(folder.parent.parent)


def state_of(folder: Path, document: FitDocument, last: dict[str, Any] | None) -> str:
    """The fit's state: cancelled in another size, else the end in its log, else cancelled, else queued or running."""
    if is_of_other_size(folder, document):
        return "cancelled"
    if last is not None and last["kind"] in ENDED:
        return str(last["kind"])
    if (folder / layout.CANCEL).exists():
        return "cancelled"
    return "queued" if last is None else "running"


def last_event(folder: Path) -> dict[str, Any] | None:
    """The last whole line of a fit's log; None before the first."""
    try:
        with (folder / layout.LOG).open("rb") as log:
            size = log.seek(0, os.SEEK_END)
            reach = TAIL
            while True:
                start = max(0, size - reach)
                log.seek(start)
                lines = log.read(size - start).split(b"\n")[:-1]  # what is behind the last newline counts for nothing
                if len(lines) > 1 or (lines and start == 0):
                    found: dict[str, Any] = json.loads(lines[-1])
                    return found
                if start == 0:
                    return None
                reach *= 8
    except FileNotFoundError:
        return None


def first_event(folder: Path) -> dict[str, Any] | None:
    """The first whole line of a fit's log; None while there is none."""
    try:
        with (folder / layout.LOG).open("rb") as log:
            line = log.readline()
    except FileNotFoundError:
        return None
    found: dict[str, Any] | None = json.loads(line) if line.endswith(b"\n") else None
    return found


def events_after(folder: Path, after: int = 0) -> list[tuple[int, bytes]]:
    """(number, line) of each whole line above a number, in order."""
    try:
        lines = (folder / layout.LOG).read_bytes().split(b"\n")[:-1]
    except FileNotFoundError:
        return []
    return [(number, line) for number, line in enumerate(lines, start=1) if number > after]


class Claim:
    """A fit in the hands of its one worker."""

    def __init__(self, case: CaseFolder, scan_id: str, fit_id: str) -> None:
        self.case, self.scan_id, self.fit_id = case, scan_id, fit_id
        self.folder = case.path / fit_part(scan_id, fit_id)
        self.document = get_fit(case, scan_id, fit_id).document
        self._cut_half_line()
        self.stored = len(events_after(self.folder))
        self._counted = 0
        self._model = (first_event(self.folder) or {}).get("model_sha256")
        last = last_event(self.folder)
        self._ended = last is not None and last["kind"] in ENDED

    @property
    def has_ended(self) -> bool:
        return self._ended

    def append(self, event: dict[str, Any]) -> bool:
        """Stores the event if no earlier attempt has; False when the fit is cancelled or over: then stop.

        Fits are deterministic: an attempt that follows a lost one tells the same again.  Raises OSError for a full
        disk, ValueError for numbers that are not finite, NotFound when the fit was deleted.
        """
        self._counted += 1
        is_end = event["kind"] in ENDED
        if not is_end and self._counted <= self.stored:
            if event["kind"] == "started" and event.get("model_sha256") != self._model:
                raise FitFailed(OTHER_MODEL)
            return True
        if self._ended:
            return False
        if (self.folder / layout.CANCEL).exists():
            self.end(CANCELLED)
            return False
        line = json.dumps(event, separators=(",", ":"), allow_nan=False).encode() + b"\n"
        if is_end:
            self._end(line)
        else:
            self._write(line, durable=False)
        return True

    def end(self, event: dict[str, Any]) -> bool:
        """Appends an end, also a cancellation, unless there is one."""
        if self._ended:
            return False
        self._end(json.dumps(event, separators=(",", ":"), allow_nan=False).encode() + b"\n")
        return True

    def _end(self, line: bytes) -> None:
        """Under the case's lock, so that whoever looks at its stamp sees it."""
        with self.case.writing():
            self.case.check_scan(self.scan_id)
            self._write(line, durable=True)
        self._ended = True

    def _write(self, line: bytes, durable: bool) -> None:
        try:
            descriptor = os.open(self.folder / layout.LOG, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
        except FileNotFoundError as error:
            raise NotFound(NO_FIT) from error
        try:
            size = os.fstat(descriptor).st_size
            try:
                rest = memoryview(line)
                while rest:
                    rest = rest[os.write(descriptor, rest) :]
                if durable:
                    os.fsync(descriptor)
            except OSError:
                os.ftruncate(descriptor, size)  # half a line is nobody's
                raise
        finally:
            os.close(descriptor)
        if durable:
            sync_folder(self.folder)

    def _cut_half_line(self) -> None:
        """Removes what a killed worker has left behind the last newline."""
        file = self.folder / layout.LOG
        if not file.exists():
            return
        content = file.read_bytes()
        whole = content.rfind(b"\n") + 1
        if whole < len(content):
            os.truncate(file, whole)


@contextmanager
def claimed(case: CaseFolder, scan_id: str, fit_id: str) -> Iterator[Claim | None]:
    """The fit to be worked at; None when it has ended, or somebody else is at it.  Raises NotFound.

    Each call counts as a start; the fourth one fails the fit.
    """
    with _held(case, scan_id, fit_id) as held:
        if not held:
            yield None
            return
        claim = Claim(case, scan_id, fit_id)
        if (claim.folder / layout.CANCEL).exists():
            claim.end(CANCELLED)
        if claim.has_ended:
            yield None
            return
        if _count_start(claim.folder) > ATTEMPTS:
            claim.end({"kind": "failed", "reason": TOO_OFTEN.format(ATTEMPTS)})
            yield None
            return
        yield claim


@contextmanager
def added(case: CaseFolder, scan_id: str, asked: FitDocument) -> Iterator[Claim]:
    """Keeps a fit as it is asked for, in the hands of the block from before anyone else can see it.  Raises NotFound.

    The claim is of the file, not of its place, so it holds through the rename.  Windows renames no folder in which a
    file is open: there the claim follows, while the case is held, as no service runs there.
    """
    fit_id = new_id()
    with ExitStack() as held:
        with case.incoming() as made:
            put(made, layout.FIT, content_of(asked))
            if os.name != "nt":
                held.enter_context(_locked(made / layout.CLAIM))
            with case.writing():
                case.check_scan(scan_id)
                case.put_folder(made, fit_part(scan_id, fit_id))
                if os.name == "nt":
                    held.enter_context(_held(case, scan_id, fit_id))
        claim = Claim(case, scan_id, fit_id)
        _count_start(claim.folder)
        yield claim


def end_abandoned(case: CaseFolder, scan_id: str, fit_id: str, event: dict[str, Any]) -> bool:
    """Ends a fit at which nobody is at work (its process died, or it is cancelled); False when somebody is.

    Raises NotFound.
    """
    with _held(case, scan_id, fit_id) as held:
        return held and Claim(case, scan_id, fit_id).end(event)


def cancel_fit(case: CaseFolder, scan_id: str, fit_id: str) -> FitEntry:
    """Cancels the fit for all readers, and for its worker before the next event.

    Raises NotFound, Conflict when it is done or has failed.
    """
    with case.writing():
        found = get_fit(case, scan_id, fit_id)
        if found.state in ENDED - {"cancelled"}:
            raise Conflict(f"This fit has already ended: it is {found.state}.")
        put(case.path, f"{fit_part(scan_id, fit_id)}/{layout.CANCEL}", b"")
    end_abandoned(case, scan_id, fit_id, CANCELLED)
    return get_fit(case, scan_id, fit_id)


def is_at_work(case: CaseFolder, scan_id: str) -> bool:
    """Whether somebody works at a fit of the scan; who has stored its end has a moment to leave it."""
    deadline = time.monotonic() + LEAVES_S
    for fit_id in fit_ids(case, scan_id):
        while True:
            with _held(case, scan_id, fit_id) as held:
                if held:
                    break
            last = last_event(case.path / fit_part(scan_id, fit_id))
            if last is None or last["kind"] not in ENDED or time.monotonic() > deadline:
                return True
            time.sleep(LOOK_S)
    return False


@contextmanager
def _held(case: CaseFolder, scan_id: str, fit_id: str) -> Iterator[bool]:
    """Whether the claim is this block's; the kernel frees it when the process dies.  Raises NotFound."""
    case.check_scan(scan_id)
    folder = case.path / fit_part(scan_id, fit_id)
    with _locked(folder / layout.CLAIM) as held:
        yield held


@contextmanager
def _locked(file: Path) -> Iterator[bool]:
    """Whether the lock of that file is this block's.  Raises NotFound where its folder is gone."""
    try:
        descriptor = os.open(file, os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
    except FileNotFoundError as error:
        raise NotFound(NO_FIT) from error
    try:
        yield lock_descriptor(descriptor, blocking=False)
    finally:
        os.close(descriptor)


def starts_of(folder: Path) -> int:
    """The number of times that the fit was started."""
    try:
        return (folder / layout.ATTEMPTS).stat().st_size
    except FileNotFoundError:
        return 0


def _count_start(folder: Path) -> int:
    """Counts a start by appending one byte, so that no count is lost."""
    descriptor = os.open(folder / layout.ATTEMPTS, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
    try:
        os.write(descriptor, b".")
        os.fsync(descriptor)
        return os.fstat(descriptor).st_size
    finally:
        os.close(descriptor)


def find_fit(case: CaseFolder, fit_id: str) -> FitEntry:
    """The fit, of whichever scan of the case.  Raises NotFound."""
    for scan_id in case.scan_ids():
        if (case.path / scan_part(scan_id) / layout.FITS / fit_id / layout.FIT).is_file():
            return get_fit(case, scan_id, fit_id)
    raise NotFound(NO_FIT)

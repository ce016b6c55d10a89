"""A patient's files: large ones are read as they are sent, and only for as long as the reader may see them.

Once the scan is deleted, a visit over or its link revoked, nobody gets any more.  The file then ends early, which the
connection shows as an answer that was cut off.

Whoever has a link may ask for the scan as often and read it as slowly as they like.  An answer here holds an open file
and no memory; how many go to visitors is bounded in all, for each share and for each client, and who comes then is
asked to come again.  A visitor who takes nothing keeps the place only until another one needs it.
"""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import IO

from flask import Response, request
from werkzeug.wsgi import wrap_file

from breastrig.api.access.security import refuse
from breastrig.api.answers import PERSONAL, file_answer
from breastrig.api.share_limits import BIG_ANSWERS, BIG_ANSWERS_EACH, BIG_BYTES, BIG_RETRY_S, STALLED_S, STILL_OPEN_S
from breastrig.api.trusted_proxy import client_of
from breastrig.core.errors import NotFound
from breastrig.storage.files import OpenedFile

CHUNK_BYTES = 2**16
BUSY = f"Too many large files are being sent at the moment; try again in {BIG_RETRY_S} s."


@dataclass(eq=False)
class Place:
    """One answer under way."""

    share_id: str
    client: str  # as client_of says
    moved_at: float  # of the clock: when it was last read from
    is_open: Callable[[], bool]  # whether the reader may still see the file
    asked_at: float  # of the clock: when that was asked last
    is_cut: bool = False


@dataclass(eq=False)
class BigAnswers:
    """The places of visitors' answers under way.  May be called from any thread; `clock` gives seconds."""

    clock: Callable[[], float] = time.monotonic
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _places: set[Place] = field(default_factory=set)

    def take(self, share_id: str, client: str, is_open: Callable[[], bool] = lambda: True) -> Place | None:
        """A place, to be given back with `leave`; None when there is none."""
        with self._lock:
            for hinders in self._full(share_id, client):
                stalled = min(hinders, key=lambda place: place.moved_at)
                if self.clock() - stalled.moved_at < STALLED_S:
                    return None
                stalled.is_cut = True
                self._places.discard(stalled)
            place = self.uncounted(is_open, share_id, client)
            self._places.add(place)
            return place

    def uncounted(self, is_open: Callable[[], bool], share_id: str = "", client: str = "") -> Place:
        """The owner's, who is refused none."""
        now = self.clock()
        return Place(share_id, client, now, is_open, now)

    def _full(self, share_id: str, client: str) -> Iterator[list[Place]]:
        """The groups that have no place left for such an answer."""
        for most, fits in (
            (BIG_ANSWERS_EACH, lambda place: place.share_id == share_id),
            (BIG_ANSWERS_EACH, lambda place: place.client == client),
            (BIG_ANSWERS, lambda place: True),
        ):
            group = [place for place in self._places if fits(place)]
            if len(group) >= most:
                yield group

    def leave(self, place: Place) -> None:
        with self._lock:
            self._places.discard(place)

    def check(self, place: Place) -> None:
        """Raises ConnectionAbortedError for a reader that gets no more."""
        now = self.clock()
        if now - place.asked_at >= STILL_OPEN_S:
            place.asked_at = now
            place.is_cut = place.is_cut or not place.is_open()
        if place.is_cut:
            raise ConnectionAbortedError(
                "a reader took nothing for too long, or what it read is not open to it any more"
            )

    @property
    def under_way(self) -> int:
        return len(self._places)


class _Part:
    """Some bytes of a file, as a file of their own; gives its place back when it is closed."""

    def __init__(self, file: IO[bytes], start: int, length: int, place: Place, answers: BigAnswers) -> None:
        self._file, self._start, self._length = file, start, length
        self._place, self._answers = place, answers
        self._at = 0

    def read(self, size: int = -1) -> bytes:
        """Raises ConnectionAbortedError once the place is another reader's or the file is closed to this one."""
        self._answers.check(self._place)
        left = self._length - self._at
        wanted = left if size < 0 else min(size, left)
        if wanted <= 0:
            return b""
        self._file.seek(self._start + self._at)
        content = self._file.read(wanted)
        self._at += len(content)
        self._place.moved_at = self._answers.clock()
        return content

    def seek(self, offset: int, whence: int = 0) -> int:
        self._at = offset + (0, self._at, self._length)[whence]
        return self._at

    def tell(self) -> int:
        return self._at

    def seekable(self) -> bool:
        return True

    def close(self) -> None:
        self._answers.leave(self._place)
        self._file.close()


def big_answer(
    answers: BigAnswers,
    file: OpenedFile,
    media_type: str,
    is_open: Callable[[], bool],
    *,
    share_id: str | None = None,
    download_as: str | None = None,
) -> Response:
    """As `file_answer`; a large file only as long as it `is_open` to the reader, to a share's visitors within bounds.

    Raises 503 beyond the bounds, NotFound when it is gone.
    """
    response = _checked(answers, file, media_type, is_open, share_id)
    response.headers["Cache-Control"] = PERSONAL
    if download_as is not None:
        response.headers["Content-Disposition"] = f"attachment; filename={download_as}"
    return response


def _checked(
    answers: BigAnswers, file: OpenedFile, media_type: str, is_open: Callable[[], bool], share_id: str | None
) -> Response:
    if file.size < BIG_BYTES:
        return file_answer(file, media_type, PERSONAL)
    response = Response(b"", mimetype=media_type)
    response.set_etag(file.etag)
    response.content_length = file.size
    response.make_conditional(request, accept_ranges=True, complete_length=file.size)
    if request.method == "HEAD" or response.status_code == 304:
        return response
    start, length = 0, file.size
    if response.status_code == 206:
        start, length = response.content_range.start or 0, response.content_length or 0
    client = client_of(request.remote_addr)
    place = answers.uncounted(is_open) if share_id is None else answers.take(share_id, client, is_open)
    if place is None:
        raise refuse(503, BUSY, {"Retry-After": str(BIG_RETRY_S)})
    with _given_back_on_error(answers, place):
        part = _Part(opened(file), start, length, place, answers)
        response.response = wrap_file(request.environ, part, CHUNK_BYTES)  # type: ignore[arg-type]
        response.direct_passthrough = True
    return response


@contextmanager
def _given_back_on_error(answers: BigAnswers, place: Place) -> Iterator[None]:
    try:
        yield
    except BaseException:
        answers.leave(place)
        raise


def opened(file: OpenedFile) -> IO[bytes]:
    """Raises NotFound when it was deleted meanwhile."""
    try:
        return file.open()
    except FileNotFoundError as error:
        raise NotFound("This file has just been deleted.") from error

"""A patient's files: large ones are read as they are sent, and only for as long as the reader may see them.

Once the scan is deleted, a visit over or its link revoked, nobody gets any more.  The file then ends early, which the
connection shows as an answer that was cut off.

Whoever has a link may ask for the scan as often and read it as slowly as they like, and each answer is an open file and
a thread.  So the number of those to visitors is bounded, in all, for each share and for each client, and who comes then
is asked to come again.
"""

import threading
import time
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from typing import IO

from flask import Response, request

from breastrig.api.answers import PERSONAL, file_answer, streamed_answer
from breastrig.api.errors import refuse
from breastrig.api.share_limits import BIG_ANSWERS, BIG_ANSWERS_EACH, BIG_BYTES, BIG_RETRY_S, STILL_OPEN_S
from breastrig.api.trusted_proxy import client_of
from breastrig.storage.files import OpenedFile

BUSY = f"Too many large files are being sent at the moment; try again in {BIG_RETRY_S} s."


class BigAnswers:
    """Counts visitors' answers under way.  May be called from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._counts: Counter[str] = Counter()

    @property
    def under_way(self) -> int:
        return self._counts["all"]

    def take(self, share_id: str, client: str) -> Callable[[], None] | None:
        """A place: what gives it back, to be called once; None when there is none."""
        bounds = {f"share {share_id}": BIG_ANSWERS_EACH, f"client {client}": BIG_ANSWERS_EACH, "all": BIG_ANSWERS}
        with self._lock:
            if any(self._counts[name] >= most for name, most in bounds.items()):
                return None
            self._counts.update(bounds.keys())
        return partial(self._leave, Counter(bounds.keys()))

    def _leave(self, names: Counter[str]) -> None:
        with self._lock:
            self._counts -= names


class WhileOpen:
    """A file as long as its reader may see it, which is asked now and then."""

    def __init__(self, file: IO[bytes], is_open: Callable[[], bool]) -> None:
        self._file, self._is_open, self._asked_at = file, is_open, time.monotonic()
        self.seek, self.tell, self.seekable, self.close = file.seek, file.tell, file.seekable, file.close

    def read(self, size: int = -1) -> bytes:
        """Raises ConnectionAbortedError once the reader gets no more."""
        if (now := time.monotonic()) - self._asked_at >= STILL_OPEN_S:
            self._asked_at = now
            if not self._is_open():
                raise ConnectionAbortedError("what a reader reads is not open to it any more")
        return self._file.read(size)


def big_answer(
    answers: BigAnswers,
    file: OpenedFile,
    media_type: str,
    is_open: Callable[[], bool],
    *,
    share_id: str | None = None,
    download_as: str | None = None,
) -> Response:
    """The file as by `file_answer`; a large one only as long as it `is_open` to the reader, to visitors within limits.

    Raises 503 beyond the limits, NotFound when it is gone.
    """
    if file.size < BIG_BYTES:
        response = file_answer(file, media_type, PERSONAL)
    else:
        with ExitStack() as place:
            if share_id is not None:
                leave = answers.take(share_id, client_of(request.remote_addr))
                if leave is None:
                    raise refuse(503, BUSY, {"Retry-After": str(BIG_RETRY_S)})
                place.callback(leave)
            response = streamed_answer(file, media_type, lambda opened: WhileOpen(opened, is_open))
            response.call_on_close(place.pop_all().close)
    response.headers["Cache-Control"] = PERSONAL
    if download_as is not None:
        response.headers["Content-Disposition"] = f"attachment; filename={download_as}"
    return response

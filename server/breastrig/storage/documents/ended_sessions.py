"""Sessions that were left: their cookies are signed and would be good until they are too old."""

from breastrig.index import questions
from breastrig.storage.storage import Storage


def add_ended_session(storage: Storage, id_sha256: str, now: str, forget_before: str) -> None:
    """Notes the end; forgets those that ended before a time (as `iso_utc`).  Ending twice is no error."""
    with storage.index.writing() as rows:
        questions.end_session(rows, id_sha256, now, forget_before)


def has_ended(storage: Storage, id_sha256: str, began_at: str) -> bool:
    """Whether the session was left, or began before an index that was lost with all that had ended."""
    return storage.index.asked(lambda rows: questions.is_session_over(rows, id_sha256, began_at))

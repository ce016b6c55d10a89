"""What is asked of an index: whose a scan or fit is, the worklist, the queue, secrets of links, ended sessions.

Each is a function of a connection, to be given to `Index.asked` or called inside `Index.writing`.
"""

import sqlite3
from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal

Sort = Literal["newest", "code", "deletion"]  # deletion: the first of its scans came first
KEYS: dict[str, str] = {"newest": "created_at", "code": "code_key", "deletion": "first_scan"}


@dataclass(frozen=True)
class CaseRow:
    id: str
    code: str
    created_at: str
    plan: int  # version; 0: there is none yet


@dataclass(frozen=True)
class LinkSecret:
    """What opens a link."""

    link: str
    token_sha256: str
    passcode_hash: str | None = None
    wrong: int = 0  # passcodes, since the link was made
    wrong_at: str | None = None
    forgiven: int = 0  # of them, by the owner


def case_of_scan(rows: sqlite3.Connection, scan_id: str) -> str | None:
    return _one(rows, "SELECT patient FROM scans WHERE id = ?", scan_id)


def case_of_fit(rows: sqlite3.Connection, fit_id: str) -> tuple[str, str] | None:
    """(case, scan) of a fit."""
    found: tuple[str, str] | None = rows.execute("SELECT patient, scan FROM fits WHERE id = ?", (fit_id,)).fetchone()
    return found


def cases_page(
    rows: sqlite3.Connection, limit: int, last: tuple[str, str] | None = None, search: str = "", sort: Sort = "newest"
) -> tuple[list[CaseRow], tuple[str, str] | None]:
    """Cases in that order, and the key and id behind which the next page goes on (None: nowhere)."""
    key, back = KEYS[sort], sort == "newest"
    order = "DESC" if back else "ASC"
    wanted, given = ["1"], list[object]()
    if search:
        wanted.append("instr(code_search, ?)")
        given.append(search.casefold())
    if last is not None:
        wanted.append(f"({key}, id) {'<' if back else '>'} (?, ?)")
        given += last
    found = rows.execute(
        f"SELECT id, code, created_at, plan, {key} FROM cases WHERE {' AND '.join(wanted)} "
        f"ORDER BY {key} {order}, id {order} LIMIT ?",
        (*given, limit + 1),
    ).fetchall()
    more = (found[limit - 1][4], found[limit - 1][0]) if len(found) > limit else None
    return [CaseRow(*row[:4]) for row in found[:limit]], more


def next_waiting(rows: sqlite3.Connection, besides: Collection[str] = ()) -> tuple[str, str, str] | None:
    """(case, scan, fit) that was asked for first among those that wait, but for some fits."""
    found = rows.execute("SELECT patient, scan, id FROM fits WHERE state = 'queued' ORDER BY asked_at, place")
    return next((row for row in found if row[2] not in besides), None)


def queue_positions(rows: sqlite3.Connection, fits: Collection[str]) -> dict[str, int]:
    """{fit: 1 for the next to run, 2 for the one after it}; those that do not wait are not in it."""
    waiting = rows.execute("SELECT id FROM fits WHERE state = 'queued' ORDER BY asked_at, place")
    return {row[0]: number for number, row in enumerate(waiting, start=1) if row[0] in fits}


def count_by_state(rows: sqlite3.Connection) -> dict[str, int]:
    """How many fits are in each state that any fit is in."""
    return dict(rows.execute("SELECT state, count(*) FROM fits GROUP BY state").fetchall())


def scans_before(rows: sqlite3.Connection, moment: str) -> list[tuple[str, str]]:
    """(case, scan) of the scans that came before a time, the oldest first."""
    chosen = "SELECT patient, id FROM scans WHERE created_at < ? ORDER BY created_at, id"
    return [(row[0], row[1]) for row in rows.execute(chosen, (moment,))]


def put_secret(rows: sqlite3.Connection, secret: LinkSecret) -> None:
    """Keeps what opens a link, in place of what was known of it."""
    given = (secret.link, secret.token_sha256, secret.passcode_hash, secret.wrong, secret.wrong_at, secret.forgiven)
    rows.execute("INSERT OR REPLACE INTO link_secrets VALUES (?, ?, ?, ?, ?, ?)", given)


def secret_of_token(rows: sqlite3.Connection, token_sha256: str) -> LinkSecret | None:
    found = rows.execute("SELECT * FROM link_secrets WHERE token_sha256 = ?", (token_sha256,)).fetchone()
    return None if found is None else LinkSecret(*found)


def forget_link(rows: sqlite3.Connection, link: str) -> None:
    """Nothing opens the link any more, and nobody knows when it was opened."""
    rows.execute("DELETE FROM link_secrets WHERE link = ?", (link,))
    rows.execute("DELETE FROM openings WHERE link = ?", (link,))


def note_opening(rows: sqlite3.Connection, link: str, at: str, visit_hmac: str) -> None:
    rows.execute("INSERT INTO openings (link, opened_at, visit_hmac) VALUES (?, ?, ?)", (link, at, visit_hmac))


def openings_of(rows: sqlite3.Connection, link: str) -> list[str]:
    """When the link was opened, ISO 8601, the first time first."""
    chosen = "SELECT opened_at FROM openings WHERE link = ? ORDER BY opened_at"
    return [row[0] for row in rows.execute(chosen, (link,))]


def end_session(rows: sqlite3.Connection, id_sha256: str, at: str) -> None:
    rows.execute("INSERT OR IGNORE INTO ended_sessions VALUES (?, ?)", (id_sha256, at))


def is_session_over(rows: sqlite3.Connection, id_sha256: str, began_at: str) -> bool:
    """Whether it was ended, or began before an index that was lost with all that had been ended."""
    since = _one(rows, "SELECT value FROM meta WHERE key = ?", "sessions_from")
    if since is not None and began_at < since:
        return True
    return _one(rows, "SELECT id_sha256 FROM ended_sessions WHERE id_sha256 = ?", id_sha256) is not None


def _one(rows: sqlite3.Connection, question: str, given: str) -> str | None:
    found = rows.execute(question, (given,)).fetchone()
    return None if found is None else str(found[0])

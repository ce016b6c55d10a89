"""Queries of the index: the owner of a scan or fit, the worklist, the queue, secrets of links, ended sessions.

Each is a function of a connection, to be given to `Index.asked` or called inside `Index.writing`.
"""

import sqlite3
from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal

from breastrig.core.identity import random_code

Sort = Literal["newest", "code", "deletion"]  # deletion: the first of its scans came first
Groups = Collection[str] | None  # whose patients are asked for; None: all
KEYS: dict[str, str] = {"newest": "''", "code": "code_key", "deletion": "first_scan"}


@dataclass(frozen=True)
class CaseRow:
    id: str
    code: str
    created_at: str
    plan: int  # version; 0: there is none yet
    planned: str  # JSON, see read_case.planned_in_short
    group: str | None  # of people, that owns the patient


@dataclass(frozen=True)
class ListedFit:
    id: str
    state: str
    created_at: str
    verdict: str | None
    line_error_mm: float | None
    stance: str | None  # as decided at its start


@dataclass(frozen=True)
class ListedScan:
    id: str
    created_at: str
    stance: str  # as proposed
    kind: str
    fit: ListedFit | None  # that was asked for last, no prediction


@dataclass(frozen=True)
class ListedCase(CaseRow):
    """A line of the worklist."""

    scans: tuple[ListedScan, ...]  # oldest first


@dataclass(frozen=True)
class AgedScan:
    """Times ISO 8601, UTC."""

    id: str
    created_at: str
    announced_at: str | None  # its deletion


@dataclass(frozen=True)
class LinkSecret:
    """The stored secrets of a link."""

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
    rows: sqlite3.Connection,
    limit: int,
    last: tuple[str, int] | None = None,
    search: str = "",
    sort: Sort = "newest",
    groups: Groups = None,
) -> tuple[list[CaseRow], tuple[str, int] | None]:
    """Cases in that order, and the key and place behind which the next page goes on (None: nowhere).

    Of those with equal keys the newest first.
    """
    key = KEYS[sort]
    wanted, given = ["1"], list[object]()
    if groups is not None:
        wanted.append(f"owner IN ({_marks(groups)})")
        given += groups
    if search:
        wanted.append("instr(code_search, ?)")
        given.append(search.casefold())
    if last is not None and sort == "newest":
        wanted.append("place < ?")
        given.append(last[1])
    elif last is not None:
        wanted.append(f"({key} > ? OR ({key} = ? AND place < ?))")
        given += [last[0], last[0], last[1]]
    order = "place DESC" if sort == "newest" else f"{key}, place DESC"
    found = rows.execute(
        f"SELECT id, code, created_at, plan, planned, owner, {key}, place FROM cases WHERE {' AND '.join(wanted)} "
        f"ORDER BY {order} LIMIT ?",
        (*given, limit + 1),
    ).fetchall()
    more = (found[limit - 1][6], found[limit - 1][7]) if len(found) > limit else None
    return [CaseRow(*row[:6]) for row in found[:limit]], more


def stamps(rows: sqlite3.Connection, cases: Collection[str]) -> dict[str, int]:
    """{case: its folder's stamp when it was read}"""
    return dict(rows.execute(f"SELECT id, stamp FROM cases WHERE id IN ({_marks(cases)})", tuple(cases)).fetchall())


def listed_cases(rows: sqlite3.Connection, cases: Collection[str]) -> list[ListedCase]:
    """The cases that exist, in the order given, with their scans, oldest first."""
    scans: dict[str, list[ListedScan]] = {case: [] for case in cases}
    newest = "SELECT id FROM fits WHERE scan = scans.id AND predicted_from IS NULL ORDER BY place DESC LIMIT 1"
    chosen = (
        "SELECT scans.patient, scans.id, scans.created_at, scans.stance, kind, fits.id, fits.state, asked_at, verdict, "
        f"line_error_mm, fits.stance FROM scans LEFT JOIN fits ON fits.id = ({newest}) "
        f"WHERE scans.patient IN ({_marks(cases)}) ORDER BY scans.created_at, scans.id"
    )
    for case, scan, came, proposed, kind, fit_id, *of_fit in rows.execute(chosen, tuple(cases)):
        fit = None if fit_id is None else ListedFit(fit_id, *of_fit)
        scans[case].append(ListedScan(scan, came, proposed, kind, fit))
    chosen = f"SELECT id, code, created_at, plan, planned, owner FROM cases WHERE id IN ({_marks(cases)})"
    known = rows.execute(chosen, tuple(cases))
    found = {
        case: ListedCase(case, code, made, plan, planned, owner, tuple(scans[case]))
        for case, code, made, plan, planned, owner in known
    }
    return [found[case] for case in cases if case in found]


def scans_page(
    rows: sqlite3.Connection, limit: int, last: tuple[str, str] | None = None, groups: Groups = None
) -> tuple[list[str], tuple[str, str] | None]:
    """Scans after the `last` one's time and id, the newest first, and where the next page goes on (None: nowhere)."""
    wanted, given = _of_groups(groups)
    if last is not None:
        wanted.append("(created_at, id) < (?, ?)")
        given += last
    found = rows.execute(
        f"SELECT id, created_at FROM scans WHERE {' AND '.join(wanted)} ORDER BY created_at DESC, id DESC LIMIT ?",
        (*given, limit + 1),
    ).fetchall()
    more = (found[limit - 1][1], found[limit - 1][0]) if len(found) > limit else None
    return [row[0] for row in found[:limit]], more


def aged_scans(rows: sqlite3.Connection, created_until: str) -> list[AgedScan]:
    """Scans of up to that time, and all whose deletion has been announced; the oldest first."""
    chosen = "SELECT id, created_at, announced_at FROM scans WHERE created_at <= ? OR announced_at IS NOT NULL"
    return [AgedScan(*row) for row in rows.execute(f"{chosen} ORDER BY created_at", (created_until,))]


def new_code(rows: sqlite3.Connection) -> str:
    """A random code that no patient here has."""
    code = random_code()
    while _one(rows, "SELECT id FROM cases WHERE code = ?", code) is not None:
        code = random_code()
    return code


def fit_of_key(rows: sqlite3.Connection, key_sha256: str) -> tuple[str, str] | None:
    """(fit, hash of the request) that came with an Idempotency-Key."""
    found: tuple[str, str] | None = rows.execute(
        "SELECT id, request_sha256 FROM fits WHERE key_sha256 = ?", (key_sha256,)
    ).fetchone()
    return found


def predictions_of(rows: sqlite3.Connection, fit: str, stance: str) -> list[str]:
    """Predictions of that stance from a fit that have neither failed nor been cancelled, as far as is known here."""
    chosen = "SELECT id FROM fits WHERE predicted_from = ? AND asked_stance = ?"
    found = rows.execute(f"{chosen} AND state NOT IN ('failed', 'cancelled') ORDER BY place", (fit, stance))
    return [row[0] for row in found]


def note_state(rows: sqlite3.Connection, fit: str, state: str) -> None:
    rows.execute("UPDATE fits SET state = ? WHERE id = ?", (state, fit))


def put_back(rows: sqlite3.Connection) -> int:
    """Fits that run wait again; how many they were."""
    return rows.execute("UPDATE fits SET state = 'queued' WHERE state = 'running'").rowcount


def fits_page(
    rows: sqlite3.Connection, limit: int, before: int | None = None, scan: str | None = None, groups: Groups = None
) -> tuple[list[str], int | None]:
    """Fits, or those of a scan, the newest first, and the place where the next page goes on (None: nowhere)."""
    wanted, given = _of_groups(groups)
    for condition, value in (("place < ?", before), ("scan = ?", scan)):
        if value is not None:
            wanted.append(condition)
            given.append(value)
    found = rows.execute(
        f"SELECT id, place FROM fits WHERE {' AND '.join(wanted)} ORDER BY place DESC LIMIT ?", (*given, limit + 1)
    ).fetchall()
    return [row[0] for row in found[:limit]], found[limit - 1][1] if len(found) > limit else None


def perhaps_done(rows: sqlite3.Connection, scan: str) -> list[str]:
    """Fits of the scan, no predictions, that are done or may be by now, the one that was asked for last first."""
    chosen = "SELECT id FROM fits WHERE scan = ? AND predicted_from IS NULL AND state NOT IN ('failed', 'cancelled')"
    return [row[0] for row in rows.execute(f"{chosen} ORDER BY place DESC", (scan,))]


def next_waiting(rows: sqlite3.Connection, besides: Collection[str] = ()) -> tuple[str, str, str] | None:
    """(case, scan, fit) that was asked for first among those that wait, but for some fits."""
    found = rows.execute("SELECT patient, scan, id FROM fits WHERE state = 'queued' ORDER BY asked_at, place")
    return next((row for row in found if row[2] not in besides), None)


def queue_positions(rows: sqlite3.Connection, fits: Collection[str]) -> dict[str, int]:
    """{fit: 1 for the next to run, 2 for the one after it}; those that do not wait are not in it."""
    waiting = rows.execute("SELECT id FROM fits WHERE state = 'queued' ORDER BY asked_at, place")
    return {row[0]: number for number, row in enumerate(waiting, start=1) if row[0] in fits}


def count_by_state(rows: sqlite3.Connection) -> dict[str, int]:
    """The number of fits in each state that any fit is in."""
    return dict(rows.execute("SELECT state, count(*) FROM fits GROUP BY state").fetchall())


def put_secret(rows: sqlite3.Connection, secret: LinkSecret) -> None:
    """Stores the secrets of a link, replacing earlier ones."""
    given = (secret.link, secret.token_sha256, secret.passcode_hash, secret.wrong, secret.wrong_at, secret.forgiven)
    rows.execute("INSERT OR REPLACE INTO link_secrets VALUES (?, ?, ?, ?, ?, ?)", given)


def secret_of_token(rows: sqlite3.Connection, token_sha256: str) -> LinkSecret | None:
    found = rows.execute("SELECT * FROM link_secrets WHERE token_sha256 = ?", (token_sha256,)).fetchone()
    return None if found is None else LinkSecret(*found)


def fit_of_link(rows: sqlite3.Connection, link: str) -> tuple[str, str, str] | None:
    """(case, scan, fit) of a link."""
    found: tuple[str, str, str] | None = rows.execute(
        "SELECT patient, scan, fit FROM links WHERE id = ?", (link,)
    ).fetchone()
    return found


def links_of_scan(rows: sqlite3.Connection, scan: str) -> list[str]:
    return [row[0] for row in rows.execute("SELECT id FROM links WHERE scan = ?", (scan,))]


def links_over(rows: sqlite3.Connection, now: str) -> list[tuple[str, str]]:
    """(fit, link) of links that are over and still show something."""
    return rows.execute("SELECT fit, id FROM links WHERE shown > 0 AND ends_at <= ?", (now,)).fetchall()


def secret_of_link(rows: sqlite3.Connection, link: str) -> LinkSecret | None:
    found = rows.execute("SELECT * FROM link_secrets WHERE link = ?", (link,)).fetchone()
    return None if found is None else LinkSecret(*found)


def wrong_passcodes(rows: sqlite3.Connection, link: str) -> int | None:
    """The number of wrong passcodes that are not forgiven; None where there is no such link."""
    found = rows.execute("SELECT wrong - forgiven FROM link_secrets WHERE link = ?", (link,)).fetchone()
    return None if found is None else int(found[0])


def count_wrong(rows: sqlite3.Connection, link: str, at: str) -> None:
    rows.execute("UPDATE link_secrets SET wrong = wrong + 1, wrong_at = ? WHERE link = ?", (at, link))


def forgive(rows: sqlite3.Connection, link: str) -> None:
    rows.execute("UPDATE link_secrets SET forgiven = wrong WHERE link = ?", (link,))


def has_visit(rows: sqlite3.Connection, link: str, visit_hmac: str, opened_after: str) -> bool:
    chosen = "SELECT 1 FROM openings WHERE link = ? AND visit_hmac = ? AND opened_at > ?"
    return rows.execute(chosen, (link, visit_hmac, opened_after)).fetchone() is not None


def end_visit(rows: sqlite3.Connection, link: str, visit_hmac: str) -> bool:
    """Voids the visit's credential; returns whether there was such a visit."""
    ended = rows.execute(
        "UPDATE openings SET visit_hmac = NULL WHERE link = ? AND visit_hmac = ?", (link, visit_hmac)
    ).rowcount
    return ended > 0


def links_gone(rows: sqlite3.Connection) -> list[str]:
    """Links with stored secrets that are in no case."""
    return [row[0] for row in rows.execute("SELECT link FROM link_secrets WHERE link NOT IN (SELECT id FROM links)")]


def forget_link(rows: sqlite3.Connection, link: str) -> None:
    """Deletes the link's secrets and openings."""
    rows.execute("DELETE FROM link_secrets WHERE link = ?", (link,))
    rows.execute("DELETE FROM openings WHERE link = ?", (link,))


def note_opening(rows: sqlite3.Connection, link: str, at: str, visit_hmac: str) -> None:
    rows.execute("INSERT INTO openings (link, opened_at, visit_hmac) VALUES (?, ?, ?)", (link, at, visit_hmac))


def openings_of(rows: sqlite3.Connection, link: str) -> list[str]:
    """The times at which the link was opened, ISO 8601, oldest first."""
    chosen = "SELECT opened_at FROM openings WHERE link = ? ORDER BY id"
    return [row[0] for row in rows.execute(chosen, (link,))]


def end_session(rows: sqlite3.Connection, id_sha256: str, at: str, forget_before: str = "") -> None:
    """Notes the end; forgets those that ended before a time."""
    rows.execute("DELETE FROM ended_sessions WHERE ended_at < ?", (forget_before,))
    rows.execute("INSERT OR IGNORE INTO ended_sessions VALUES (?, ?)", (id_sha256, at))


def is_session_over(rows: sqlite3.Connection, id_sha256: str, began_at: str) -> bool:
    """Whether the session was ended, or began before an index that was lost with all ended ones."""
    since = _one(rows, "SELECT value FROM meta WHERE key = ?", "sessions_from")
    if since is not None and began_at < since:
        return True
    return _one(rows, "SELECT id_sha256 FROM ended_sessions WHERE id_sha256 = ?", id_sha256) is not None


def _one(rows: sqlite3.Connection, question: str, given: str) -> str | None:
    found = rows.execute(question, (given,)).fetchone()
    return None if found is None else str(found[0])


def _of_groups(groups: Groups) -> tuple[list[str], list[object]]:
    """Conditions for what is of patients of these groups, and what is given to them."""
    if groups is None:
        return ["1"], []
    return [f"patient IN (SELECT id FROM cases WHERE owner IN ({_marks(groups)}))"], list(groups)


def _marks(values: Collection[object]) -> str:
    return ", ".join("?" for _ in values)

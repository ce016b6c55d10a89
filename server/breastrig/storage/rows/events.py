"""The events of each fit, appended one by one and never changed.

`append` is the only door.  It numbers the event, brings the fit's row up to date in the same transaction, and
refuses whatever comes after the last event.  So a fit ends exactly once, whoever comes first: its worker, the
person who cancels, or the server that finds the worker dead.

A worker may be taken for dead and still go on.  So each one has a number, the fit's `attempt`, and `append`
refuses the events of all but the latest.
"""

import json
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from sqlalchemy import bindparam, case, func, insert, select, update

from breastrig.core.errors import Conflict, NotFound
from breastrig.storage import schema
from breastrig.storage.rows.fits import ENDED
from breastrig.storage.rows.queries import value_of
from breastrig.storage.storage import Storage

# Asked many times a second while somebody follows a fit; to put one together takes three times as long as its answer.
AFTER = (
    select(schema.events.c.number, schema.events.c.kind, schema.events.c.json)
    .where(schema.events.c.fit == bindparam("fit_id"), schema.events.c.number > bindparam("after"))
    .order_by(schema.events.c.number)
)
NEWS = (
    select(
        schema.events.c.fit,
        func.max(schema.events.c.position),
        func.max(case((schema.events.c.kind == "iterated", 0), else_=1)),
    )
    .where(schema.events.c.position > bindparam("position"))
    .group_by(schema.events.c.fit)
)


@dataclass(frozen=True)
class StoredEvent:
    number: int
    kind: str
    json: str  # one line

    @cached_property
    def utf8(self) -> bytes:
        """The line as it is sent, encoded once for all who follow the fit."""
        return self.json.encode()


@dataclass(frozen=True)
class News:
    """New events of one fit."""

    fit: str
    position: int  # of its last one; grows with every event of every fit
    moves_queue: bool  # whether a fit began or ended: others may have moved up


def append(storage: Storage, fit_id: str, event: dict[str, Any], attempt: int | None = None) -> int:
    """Stores the event and gives its number; `attempt` is the worker's, None for whoever may always end a fit.

    Raises NotFound (fit deleted) or Conflict (fit has ended, or another worker is at it).
    """
    kind = event["kind"]
    text = json.dumps(event, separators=(",", ":"), allow_nan=False)
    with storage.database.writing() as connection:
        table = schema.fits
        fit = connection.execute(
            select(table.c.state, table.c.attempt, table.c.last_event).where(table.c.id == fit_id)
        ).one_or_none()
        if fit is None:
            raise NotFound("There is no such fit; it may have been deleted.")
        if fit.state in ENDED:
            raise Conflict(f"This fit has already ended: it is {fit.state}.")
        if attempt is not None and (fit.state, fit.attempt) != ("running", attempt):
            raise Conflict("Another worker has taken this fit over.")
        number = int(fit.last_event) + 1
        connection.execute(insert(schema.events).values(fit=fit_id, number=number, kind=kind, json=text))
        changes = {"last_event": number, **_changes(event)}
        connection.execute(update(table).where(table.c.id == fit_id).values(changes))
    return number


def _changes(event: dict[str, Any]) -> dict[str, Any]:
    """What the event changes in the fit's own row."""
    match event["kind"]:
        case "started":
            return {"stance": event["stance"]}
        case "iterated":
            numbers = {key: value for key, value in event.items() if key not in ("kind", "nodes")}
            return {"iterations": schema.fits.c.iterations + 1, "numbers": numbers}
        case "done":
            verdict = event.get("result", {}).get("verdict") or {}
            return {"state": "done", "verdict": verdict.get("level")}
        case kind:
            return {"state": kind, "reason": event["reason"]}


def events_after(storage: Storage, fit_id: str, after: int, limit: int | None = None) -> list[StoredEvent]:
    """The events with a greater number, in order; the first `limit` of them."""
    with storage.database.reading() as connection:
        found = connection.execute(AFTER if limit is None else AFTER.limit(limit), {"fit_id": fit_id, "after": after})
        return [StoredEvent(number, kind, text) for number, kind, text in found]


def event_of_kind(storage: Storage, fit_id: str, kind: str, offset: int = 0) -> StoredEvent | None:
    """The first event of a kind, or the one so many after it: for instance an iteration."""
    table = schema.events
    chosen = select(table.c.number, table.c.kind, table.c.json).where(table.c.fit == fit_id, table.c.kind == kind)
    with storage.database.reading() as connection:
        row = connection.execute(chosen.order_by(table.c.number).offset(offset).limit(1)).one_or_none()
    return None if row is None else value_of(StoredEvent, row)


def news_after(storage: Storage, position: int) -> list[News]:
    """What came above a position: one entry for each fit, so there are never more than fits."""
    with storage.database.reading() as connection:
        found = connection.execute(NEWS, {"position": position})
        return [News(fit, int(last), bool(moved)) for fit, last, moved in found]

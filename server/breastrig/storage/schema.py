"""The tables.  Deleting a scan deletes all rows that depend on it.

New databases are made from them.  Whatever changes here needs a revision of its own in `migrations/versions`, which
changes the tables of older data folders; a test brings those of the first revision up to date and compares both.

`events` is append-only and the single source of truth about a fit; the fit's own row repeats the last state for
quick answers and is only ever written in the same transaction as the event.
"""

import json
from collections.abc import Callable
from typing import Any

from sqlalchemy import (
    Boolean,
    Column,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    TypeDecorator,
    UniqueConstraint,
    false,
)

metadata = MetaData()


class Json(TypeDecorator[Any]):
    """A value as one line of JSON; `kind` is what a list is read as."""

    impl = Text
    cache_ok = True

    def __init__(self, kind: Callable[[Any], Any] | None = None) -> None:
        super().__init__()
        self.kind = kind

    def process_bind_param(self, value: Any, dialect: Any) -> str | None:
        return None if value is None else json.dumps(value, separators=(",", ":"))

    def process_result_value(self, value: Any, dialect: Any) -> Any:
        found = None if value is None else json.loads(value)
        return found if self.kind is None else self.kind(found)


scans = Table(
    "scans",
    metadata,
    Column("id", String(32), primary_key=True),
    Column("created_at", String(32), nullable=False),  # ISO 8601, UTC
    Column("file_type", String(8), nullable=False),  # stored; of earlier versions ply, obj, stl, glb, zip
    Column("sha256", String(64), nullable=False),  # of the uploaded bytes
    Column("facts", Json, nullable=False),  # what reading found: unit, counts, bounds, frame, stance, notes
)

landmarks = Table(
    "landmarks",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("points_mm", Json, nullable=False),  # {name: [x, y, z]}, scan frame
    Column("certain", Json(tuple), nullable=False, server_default="[]"),  # names among them
    Column("confidence", Json, nullable=False, server_default="{}"),  # {name: 0 to 1} of proposed ones
)

cuts = Table(  # what a person has cut out of the scan; it stays whole itself
    "cuts",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("json", Json(tuple), nullable=False),  # [{to_picture, lasso}], see scan/hand_cuts.py
)

proposals = Table(
    "proposals",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("model_sha256", String(64), nullable=False),  # of the model that proposed, and the cuts
    Column("json", Json, nullable=False),  # {name: {point, confidence, on_scan, error_mm, ...}}, mm, scan frame
)

ink = Table(
    "ink",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("json", Json, nullable=False),  # breastrig/drawing@1, mm, scan frame
    Column("dropped", Json(set), nullable=False, server_default="[]"),  # names of shapes that are none of the plan
)

patients = Table(  # a woman under a code, never a name; one without scans is not kept
    "patients",
    metadata,
    Column("position", Integer, primary_key=True, autoincrement=True),  # order of arrival
    Column("id", String(32), nullable=False, unique=True),
    Column("code", String(60), nullable=False, server_default=""),
    Column("created_at", String(32), nullable=False),  # ISO 8601, UTC
    Column("version", Integer, nullable=False, server_default="0"),  # of her plan; 0 before the first item
    Column("code_key", Text, nullable=False, server_default="1"),  # what the code is sorted by, see rows/patients.py
)

scans_of_patients = Table(
    "scans_of_patients",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("patient", String(32), ForeignKey("patients.id", ondelete="CASCADE"), nullable=False, index=True),
)

same_patient = (
    Table(  # of scans that do not look like it a person has said that they are one patient's; the lesser id first
        "same_patient",
        metadata,
        Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
        Column("other", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True, index=True),
    )
)

plans = Table(  # what the surgeon wants on her skin: the plan as it is, and as it was before
    "plans",
    metadata,
    Column("position", Integer, primary_key=True, autoincrement=True),
    Column("patient", String(32), ForeignKey("patients.id", ondelete="CASCADE"), nullable=False),
    Column("version", Integer, nullable=False),
    Column("json", Json, nullable=False),  # breastrig/plan@1
    UniqueConstraint("patient", "version"),
)

fits = Table(
    "fits",
    metadata,
    Column("id", String(32), primary_key=True),
    Column("place", Integer, nullable=False, unique=True),  # order of arrival
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), nullable=False, index=True),
    Column("created_at", String(32), nullable=False),
    Column("state", String(16), nullable=False, index=True),  # queued, running, done, failed, cancelled
    Column("stance", String(16), nullable=False),  # the decided one, once the fit has started
    Column("asked_stance", String(16)),
    Column("preset", String(100), nullable=False),
    Column("drawing", Text),  # as it was asked for, see drawings/patterns.py
    Column("landmarks_mm", Json, nullable=False),  # as they were when the fit was asked for
    Column("certain", Json(tuple), nullable=False, server_default="[]"),  # names among them
    Column("confidence", Json, nullable=False, server_default="{}"),  # {name: 0 to 1} of proposed ones
    Column("cuts", Json(tuple), nullable=False, server_default="[]"),  # the scan's, as they were then
    Column("refine", Boolean, nullable=False, server_default=false()),
    Column("start_from", String(32)),  # an earlier fit of the same scan, whose last pose this one goes on from
    Column("predicted_from", String(32)),  # of a prediction: the fit of the scan, which is of another stance
    Column("simulate", Boolean, nullable=False, server_default=false()),  # of an earlier version: by finite elements
    Column("attempt", Integer, nullable=False, server_default="0"),  # how often a worker has started it
    Column("last_event", Integer, nullable=False, default=0),
    Column("iterations", Integer, nullable=False, default=0),
    Column("numbers", Json),  # the last iterated event without its nodes
    Column("reason", Text),
    Column("verdict", String(16)),  # good, uncalibrated, check, unusable; null before the end
)

asked_once = Table(  # requests with an Idempotency-Key; neither the key nor the request is kept, only their hashes
    "asked_once",
    metadata,
    Column("key_sha256", String(64), primary_key=True),
    Column("request_sha256", String(64), nullable=False),
    Column("fit", String(32), ForeignKey("fits.id", ondelete="CASCADE"), nullable=False, index=True),
)

shares = Table(
    "shares",
    metadata,
    Column("position", Integer, primary_key=True, autoincrement=True),  # order of making
    Column("id", String(32), nullable=False, unique=True),  # for the owner; it opens nothing
    Column("fit", String(32), ForeignKey("fits.id", ondelete="CASCADE"), nullable=False, index=True),
    Column("token_sha256", String(64), nullable=False, unique=True),  # of the secret in the link
    Column("created_at", String(32), nullable=False),
    Column("expires_at", String(32), nullable=False),
    Column("revoked_at", String(32)),
    Column("scan", String(8), nullable=False),  # none, plain, full
    Column("notes", Boolean, nullable=False, server_default=false()),  # whether those of the plan are shown
    Column("snapshot", String(32)),  # the place of the files that it shows; null once the link is over
    Column("snapshot_at", String(32)),  # when they were made
    Column("passcode_hash", String(300)),  # salted scrypt
    Column("wrong_passcodes", Integer, nullable=False, server_default="0"),  # since the link was made
    Column("last_wrong_at", String(32)),
    Column("forgiven_passcodes", Integer, nullable=False, server_default="0"),  # of them, by opening the link again
)

openings = Table(  # when a share was opened; not by whom and not what was looked at
    "openings",
    metadata,
    Column("id", Integer, primary_key=True, autoincrement=True),
    Column("share", String(32), ForeignKey("shares.id", ondelete="CASCADE"), nullable=False, index=True),
    Column("opened_at", String(32), nullable=False),
    Column("visit_hmac", String(64), index=True),  # of the browser's credential; null once the visitor has closed it
)

ended_sessions = Table(  # browsers that signed out before their cookie was too old
    "ended_sessions",
    metadata,
    Column("id_sha256", String(64), primary_key=True),  # of the random number in the cookie
    Column("ended_at", String(32), nullable=False),
)

events = Table(
    "events",
    metadata,
    Column("position", Integer, primary_key=True, autoincrement=True),  # over all fits; grows with each event
    Column("fit", String(32), ForeignKey("fits.id", ondelete="CASCADE"), nullable=False),
    Column("number", Integer, nullable=False),  # from 1 within the fit
    Column("kind", String(16), nullable=False),
    Column("json", Text, nullable=False),
    UniqueConstraint("fit", "number"),
    sqlite_autoincrement=True,  # a position is never used twice, even after a delete
)

Index("events_of_kind", events.c.fit, events.c.kind)

installation = Table(  # one row: the name that the files carry too
    "installation",
    metadata,
    Column("id", String(32), primary_key=True),
)

file_journal = Table(  # places that may hold files and have no row: being made, or to be removed
    "file_journal",
    metadata,
    Column("place", String(64), primary_key=True),  # scans/ID or fits/ID
    Column("scan", String(32), nullable=False, index=True),  # no foreign key: its row may be gone, or not yet be there
    Column("removing", Boolean, nullable=False),
)

expiring_scans = Table(  # scans whose deletion by age has been announced
    "expiring_scans",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("announced_at", String(32), nullable=False),
)

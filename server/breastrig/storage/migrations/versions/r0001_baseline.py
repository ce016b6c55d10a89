"""The first tables, written out once more because those of `schema` may change.

Revision ID: 0001
Revises:
"""

from alembic import op
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
    UniqueConstraint,
    false,
    true,
)

revision = "0001"
down_revision = None

metadata = MetaData()

Table(
    "scans",
    metadata,
    Column("id", String(32), primary_key=True),
    Column("created_at", String(32), nullable=False),
    Column("file_type", String(8), nullable=False),
    Column("sha256", String(64), nullable=False),
    Column("facts", Text, nullable=False),
)

Table(
    "landmarks",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("points_mm", Text, nullable=False),
    Column("certain", Text, nullable=False, server_default="[]"),
    Column("confidence", Text, nullable=False, server_default="{}"),
)

Table(
    "cuts",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("json", Text, nullable=False),
)

Table(
    "proposals",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("model_sha256", String(64), nullable=False),
    Column("json", Text, nullable=False),
)

Table(
    "ink",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("json", Text, nullable=False),
    Column("dropped", Text, nullable=False, server_default="[]"),
)

Table(
    "patients",
    metadata,
    Column("position", Integer, primary_key=True, autoincrement=True),
    Column("id", String(32), nullable=False, unique=True),
    Column("code", String(60), nullable=False, server_default=""),
    Column("created_at", String(32), nullable=False),
    Column("version", Integer, nullable=False, server_default="0"),
    Column("code_key", Text, nullable=False, server_default="1"),
)

Table(
    "scans_of_patients",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("patient", String(32), ForeignKey("patients.id", ondelete="CASCADE"), nullable=False, index=True),
)

Table(
    "plans",
    metadata,
    Column("position", Integer, primary_key=True, autoincrement=True),
    Column("patient", String(32), ForeignKey("patients.id", ondelete="CASCADE"), nullable=False),
    Column("version", Integer, nullable=False),
    Column("json", Text, nullable=False),
    UniqueConstraint("patient", "version"),
)

Table(
    "fits",
    metadata,
    Column("id", String(32), primary_key=True),
    Column("place", Integer, nullable=False, unique=True),
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), nullable=False, index=True),
    Column("created_at", String(32), nullable=False),
    Column("state", String(16), nullable=False, index=True),
    Column("stance", String(16), nullable=False),
    Column("asked_stance", String(16)),
    Column("preset", String(100), nullable=False),
    Column("drawing", Text),
    Column("landmarks_mm", Text, nullable=False),
    Column("certain", Text, nullable=False, server_default="[]"),
    Column("confidence", Text, nullable=False, server_default="{}"),
    Column("cuts", Text, nullable=False, server_default="[]"),
    Column("refine", Boolean, nullable=False, server_default=false()),
    Column("start_from", String(32)),
    Column("partner", String(32)),
    Column("leads", Boolean, nullable=False, server_default=true()),
    Column("attempt", Integer, nullable=False, server_default="0"),
    Column("last_event", Integer, nullable=False, default=0),
    Column("iterations", Integer, nullable=False, default=0),
    Column("numbers", Text),
    Column("reason", Text),
    Column("verdict", String(16)),
)

Table(
    "asked_once",
    metadata,
    Column("key_sha256", String(64), primary_key=True),
    Column("request_sha256", String(64), nullable=False),
    Column("fit", String(32), ForeignKey("fits.id", ondelete="CASCADE"), nullable=False, index=True),
)

Table(
    "shares",
    metadata,
    Column("position", Integer, primary_key=True, autoincrement=True),
    Column("id", String(32), nullable=False, unique=True),
    Column("fit", String(32), ForeignKey("fits.id", ondelete="CASCADE"), nullable=False, index=True),
    Column("token_sha256", String(64), nullable=False, unique=True),
    Column("created_at", String(32), nullable=False),
    Column("expires_at", String(32), nullable=False),
    Column("revoked_at", String(32)),
    Column("scan", String(8), nullable=False),
    Column("notes", Boolean, nullable=False, server_default=false()),
    Column("snapshot", String(32)),
    Column("snapshot_at", String(32)),
    Column("passcode_hash", String(300)),
    Column("wrong_passcodes", Integer, nullable=False, server_default="0"),
    Column("last_wrong_at", String(32)),
    Column("forgiven_passcodes", Integer, nullable=False, server_default="0"),
)

Table(
    "openings",
    metadata,
    Column("id", Integer, primary_key=True, autoincrement=True),
    Column("share", String(32), ForeignKey("shares.id", ondelete="CASCADE"), nullable=False, index=True),
    Column("opened_at", String(32), nullable=False),
    Column("visit_hmac", String(64), index=True),
)

Table(
    "ended_sessions",
    metadata,
    Column("id_sha256", String(64), primary_key=True),
    Column("ended_at", String(32), nullable=False),
)

_events = Table(
    "events",
    metadata,
    Column("position", Integer, primary_key=True, autoincrement=True),
    Column("fit", String(32), ForeignKey("fits.id", ondelete="CASCADE"), nullable=False),
    Column("number", Integer, nullable=False),
    Column("kind", String(16), nullable=False),
    Column("json", Text, nullable=False),
    UniqueConstraint("fit", "number"),
    sqlite_autoincrement=True,
)

Index("events_of_kind", _events.c.fit, _events.c.kind)

Table(
    "installation",
    metadata,
    Column("id", String(32), primary_key=True),
)

Table(
    "file_journal",
    metadata,
    Column("place", String(64), primary_key=True),
    Column("scan", String(32), nullable=False, index=True),
    Column("removing", Boolean, nullable=False),
)

Table(
    "expiring_scans",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("announced_at", String(32), nullable=False),
)


def upgrade() -> None:
    metadata.create_all(op.get_bind())

"""The tables as they were before there were revisions.

Adopts what it finds: an empty database gets all of them, one of an older version what it lacks.  The tables are
written out here once more, because those of `schema` go on changing.

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
    inspect,
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
)

Table(
    "proposals",
    metadata,
    Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
    Column("model_sha256", String(64), nullable=False),
    Column("json", Text, nullable=False),
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
    Column("preset", String(100), nullable=False),
    Column("drawing", String(100)),
    Column("landmarks_mm", Text, nullable=False),
    Column("refine", Boolean, nullable=False, server_default=false()),
    Column("partner", String(32)),
    Column("leads", Boolean, nullable=False, server_default=true()),
    Column("last_event", Integer, nullable=False),
    Column("iterations", Integer, nullable=False),
    Column("numbers", Text),
    Column("reason", Text),
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
    Column("passcode_hash", String(300)),
)

Table(
    "openings",
    metadata,
    Column("id", Integer, primary_key=True, autoincrement=True),
    Column("share", String(32), ForeignKey("shares.id", ondelete="CASCADE"), nullable=False, index=True),
    Column("opened_at", String(32), nullable=False),
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


def upgrade() -> None:
    connection = op.get_bind()
    metadata.create_all(connection)
    found = inspect(connection)
    for table in metadata.sorted_tables:
        present = {column["name"] for column in found.get_columns(table.name)}
        for column in table.columns:
            if column.name not in present:  # each of them may be null or has a default
                default = column.server_default
                op.add_column(
                    table.name, Column(column.name, column.type, nullable=column.nullable, server_default=default)
                )

"""A share link shows what stood when it was made.

Links of earlier versions showed whatever stood when they were opened, and have no such files: they end.

Revision ID: 0017
Revises: 0016
"""

from alembic import op
from sqlalchemy import Boolean, Column, String, column, false, table

from breastrig.storage.storage import utc_now

revision = "0017"
down_revision = "0016"


def upgrade() -> None:
    op.add_column("shares", Column("notes", Boolean, nullable=False, server_default=false()))
    op.add_column("shares", Column("snapshot", String(32)))
    op.add_column("shares", Column("snapshot_at", String(32)))
    shares = table("shares", column("revoked_at", String(32)))
    op.execute(shares.update().where(shares.c.revoked_at.is_(None)).values(revoked_at=utc_now()))

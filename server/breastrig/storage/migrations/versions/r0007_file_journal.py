"""Files that have no row, and scans that are about to be too old.

Revision ID: 0007
Revises: 0006
"""

from alembic import op
from sqlalchemy import Boolean, Column, ForeignKey, String

revision = "0007"
down_revision = "0006"


def upgrade() -> None:
    op.create_table(
        "file_journal",
        Column("place", String(64), primary_key=True),
        Column("scan", String(32), nullable=False, index=True),
        Column("removing", Boolean, nullable=False),
    )
    op.create_table(
        "expiring_scans",
        Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
        Column("announced_at", String(32), nullable=False),
    )

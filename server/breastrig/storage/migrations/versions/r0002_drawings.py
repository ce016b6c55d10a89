"""The surgeon's own drawing on a scan.

Revision ID: 0002
Revises: 0001
"""

from alembic import op
from sqlalchemy import Column, ForeignKey, String, Text

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    op.create_table(
        "drawings",
        Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
        Column("json", Text, nullable=False),
    )

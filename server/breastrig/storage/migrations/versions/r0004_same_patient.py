"""What a person has said of scans that do not look like one patient's.

Revision ID: 0004
Revises: 0003
"""

from alembic import op
from sqlalchemy import Column, ForeignKey, String

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    op.create_table(
        "same_patient",
        Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
        Column("other", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True, index=True),
    )

"""Lines of ink found on the skin of a scan.

Revision ID: 0012
Revises: 0011
"""

from alembic import op
from sqlalchemy import Column, ForeignKey, String, Text

revision = "0012"
down_revision = "0011"


def upgrade() -> None:
    op.create_table(
        "ink",
        Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
        Column("json", Text, nullable=False),
    )

"""What a person has cut out of a scan, and what was cut when a fit was asked for.

Revision ID: 0014
Revises: 0013
"""

from alembic import op
from sqlalchemy import Column, ForeignKey, String, Text

revision = "0014"
down_revision = "0013"


def upgrade() -> None:
    op.create_table(
        "cuts",
        Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
        Column("json", Text, nullable=False),
    )
    op.add_column("fits", Column("cuts", Text, nullable=False, server_default="[]"))

"""Sessions of browsers that have signed out.

Revision ID: 0004
Revises: 0003
"""

from alembic import op
from sqlalchemy import Column, String

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    op.create_table(
        "ended_sessions",
        Column("id_sha256", String(64), primary_key=True),
        Column("ended_at", String(32), nullable=False),
    )

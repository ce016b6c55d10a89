"""What beginning a fit again needs: how often it was begun, and the stance that was asked for.

Revision ID: 0003
Revises: 0002
"""

from alembic import op
from sqlalchemy import Column, Integer, String

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    op.add_column("fits", Column("attempt", Integer, nullable=False, server_default="0"))
    op.add_column("fits", Column("asked_stance", String(16)))

"""Which of the lines found on the skin a person has dropped.

Revision ID: 0013
Revises: 0012
"""

from alembic import op
from sqlalchemy import Column, Text

revision = "0013"
down_revision = "0012"


def upgrade() -> None:
    op.add_column("ink", Column("dropped", Text, nullable=False, server_default="[]"))

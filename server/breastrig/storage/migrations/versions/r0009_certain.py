"""Landmarks that a person is certain of.

Revision ID: 0009
Revises: 0008
"""

from alembic import op
from sqlalchemy import Column, Text

revision = "0009"
down_revision = "0008"


def upgrade() -> None:
    for table in ("landmarks", "fits"):
        op.add_column(table, Column("certain", Text, nullable=False, server_default="[]"))

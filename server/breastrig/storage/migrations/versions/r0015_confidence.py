"""Landmarks that were proposed and only agreed to, with how sure each of them is.

Revision ID: 0015
Revises: 0014
"""

from alembic import op
from sqlalchemy import Column, Text

revision = "0015"
down_revision = "0014"


def upgrade() -> None:
    for table in ("landmarks", "fits"):
        op.add_column(table, Column("confidence", Text, nullable=False, server_default="{}"))

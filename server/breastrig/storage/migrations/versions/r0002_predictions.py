"""Predictions are fits with a fit that they come from.

Revision ID: 0002
Revises: 0001
"""

from alembic import op
from sqlalchemy import Boolean, Column, String, false

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    op.add_column("fits", Column("predicted_from", String(32)))
    op.add_column("fits", Column("simulate", Boolean, nullable=False, server_default=false()))

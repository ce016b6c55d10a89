"""Visits of share links that end by themselves, and what wrong passcodes do to a link.

Revision ID: 0008
Revises: 0007
"""

from alembic import op
from sqlalchemy import Column, Integer, String

revision = "0008"
down_revision = "0007"


def upgrade() -> None:
    op.add_column("shares", Column("wrong_passcodes", Integer, nullable=False, server_default="0"))
    op.add_column("shares", Column("last_wrong_at", String(32)))
    op.add_column("shares", Column("forgiven_passcodes", Integer, nullable=False, server_default="0"))
    op.add_column("openings", Column("visit_hmac", String(64)))
    op.create_index("ix_openings_visit_hmac", "openings", ["visit_hmac"])

"""A fit may go on from an earlier one of the same scan.

Revision ID: 0005
Revises: 0004
"""

from alembic import op
from sqlalchemy import Column, String

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    op.add_column("fits", Column("start_from", String(32)))

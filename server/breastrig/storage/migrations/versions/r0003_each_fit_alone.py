"""A fit has one scan: those that were fitted together stay, and none names the other.

Revision ID: 0003
Revises: 0002
"""

from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    for column in ("partner", "leads"):
        op.drop_column("fits", column)

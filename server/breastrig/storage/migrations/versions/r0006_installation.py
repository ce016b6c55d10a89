"""The name by which files know the database that they belong to.

Revision ID: 0006
Revises: 0005
"""

from alembic import op
from sqlalchemy import Column, String

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    op.create_table("installation", Column("id", String(32), primary_key=True))

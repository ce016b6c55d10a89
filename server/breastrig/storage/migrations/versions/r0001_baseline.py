"""The tables of version 0.2, where every database begins that is older than the next revision.

Revision ID: 0001
Revises:
"""

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Nothing: new databases are made from `schema`, see `database`."""

"""What a fit is asked to draw may be as long as a plan.

Revision ID: 0016
Revises: 0015
"""

from alembic import op
from sqlalchemy import Column, Text

revision = "0016"
down_revision = "0015"


def upgrade() -> None:
    # SQLite changes a type by making the table anew, and dropping the old one would take the events with it.
    op.add_column("fits", Column("long_drawing", Text))
    op.execute("UPDATE fits SET long_drawing = drawing")
    op.drop_column("fits", "drawing")
    op.alter_column("fits", "long_drawing", new_column_name="drawing")

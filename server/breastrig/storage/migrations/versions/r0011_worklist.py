"""What the list of patients shows and is sorted by: the verdict of each fit, and codes with their numbers as numbers.

Revision ID: 0011
Revises: 0010
"""

import json

from alembic import op
from sqlalchemy import Column, String, Text, text

from breastrig.storage.rows.sorting import code_key

revision = "0011"
down_revision = "0010"


def upgrade() -> None:
    op.add_column("fits", Column("verdict", String(16)))
    op.add_column("patients", Column("code_key", Text, nullable=False, server_default="1"))
    run = op.get_bind().execute
    for fit, event in run(text("SELECT fit, json FROM events WHERE kind = 'done'")).all():
        level = ((json.loads(event).get("result") or {}).get("verdict") or {}).get("level")
        if level is not None:
            run(text("UPDATE fits SET verdict = :level WHERE id = :fit"), {"level": level, "fit": fit})
    for patient, code in run(text("SELECT id, code FROM patients WHERE code <> ''")).all():
        run(text("UPDATE patients SET code_key = :key WHERE id = :id"), {"key": code_key(code), "id": patient})

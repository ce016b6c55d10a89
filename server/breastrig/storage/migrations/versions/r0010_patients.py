"""Patients: which scans are of one, her code, and her plan, into which the drawings on her scans go.

Each scan so far becomes a patient of its own, for nobody said which belong together.

Revision ID: 0010
Revises: 0009
"""

import json

from alembic import op
from sqlalchemy import Column, ForeignKey, Integer, String, Text, UniqueConstraint, text

revision = "0010"
down_revision = "0009"


def upgrade() -> None:
    op.create_table(
        "patients",
        Column("position", Integer, primary_key=True, autoincrement=True),
        Column("id", String(32), nullable=False, unique=True),
        Column("code", String(60), nullable=False, server_default=""),
        Column("created_at", String(32), nullable=False),
        Column("version", Integer, nullable=False, server_default="0"),
    )
    op.create_table(
        "scans_of_patients",
        Column("scan", String(32), ForeignKey("scans.id", ondelete="CASCADE"), primary_key=True),
        Column("patient", String(32), ForeignKey("patients.id", ondelete="CASCADE"), nullable=False, index=True),
    )
    op.create_table(
        "plans",
        Column("position", Integer, primary_key=True, autoincrement=True),
        Column("patient", String(32), ForeignKey("patients.id", ondelete="CASCADE"), nullable=False),
        Column("version", Integer, nullable=False),
        Column("json", Text, nullable=False),
        UniqueConstraint("patient", "version"),
    )
    run = op.get_bind().execute
    run(text("INSERT INTO patients (id, created_at) SELECT id, created_at FROM scans ORDER BY created_at"))
    run(text("INSERT INTO scans_of_patients (scan, patient) SELECT id, id FROM scans"))
    for scan, drawing in run(text("SELECT scan, json FROM drawings")).all():
        shapes = json.loads(drawing)["shapes"]
        items = [shape | {"id": f"line-{k}", "scan": scan, "kind": "line"} for k, shape in enumerate(shapes, 1)]
        plan = {"schema": "breastrig/plan@1", "unit": "mm", "items": items}
        values = {"patient": scan, "plan": json.dumps(plan, separators=(",", ":"))}
        run(text("INSERT INTO plans (patient, version, json) VALUES (:patient, 1, :plan)"), values)
        run(text("UPDATE patients SET version = 1 WHERE id = :patient"), {"patient": scan})
    op.drop_table("drawings")

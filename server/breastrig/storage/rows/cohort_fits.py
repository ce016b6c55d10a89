"""Fits that a clinic's prior may be learned from."""

from dataclasses import dataclass

from sqlalchemy import or_, select

from breastrig.storage import schema
from breastrig.storage.rows.queries import value_of
from breastrig.storage.storage import Storage


@dataclass(frozen=True)
class CohortFit:
    id: str
    patient: str
    stance: str


def cohort_fits(storage: Storage) -> list[CohortFit]:
    """All that are done and of use, by their order of arrival; no predictions."""
    fits, patients = schema.fits.c, schema.scans_of_patients.c
    query = (
        select(fits.id, patients.patient, fits.stance)
        .join(schema.scans_of_patients, patients.scan == fits.scan)
        .where(fits.state == "done", fits.predicted_from.is_(None))
        .where(or_(fits.verdict.is_(None), fits.verdict != "unusable"))
        .order_by(fits.place)
    )
    with storage.database.reading() as connection:
        return [value_of(CohortFit, row) for row in connection.execute(query)]

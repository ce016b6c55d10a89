"""Rows of patients, of their scans and their plans.

Every scan is of one patient; a patient goes with her last scan.  A plan is replaced only by somebody who has seen the
one that is there: each has a version, and earlier ones are kept for undoing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from sqlalchemy import ColumnElement, Connection, delete, exists, func, insert, select, update

from breastrig.core.errors import Conflict, NeedsYes, NotFound
from breastrig.core.identity import code_key, random_code
from breastrig.storage import schema
from breastrig.storage.folders import new_id
from breastrig.storage.rows.queries import by_key, is_there, newest_first, no_such_scan, value_of
from breastrig.storage.storage import Storage, utc_now

VERSIONS = 50  # of a plan that are kept; nobody undoes more

Document = dict[str, Any]
Sort = Literal["newest", "code", "deletion"]  # deletion: the first of her scans came first


@dataclass(frozen=True)
class PatientRow:
    id: str
    code: str
    created_at: str
    version: int  # of her plan; 0: there is none yet


@dataclass(frozen=True)
class PlanRow:
    version: int
    items: tuple[Document, ...] = ()  # as breastrig/plan@1 has them
    is_whole: bool = False  # somebody has written it as a whole: what it does not name is not wanted
    written_at: str = ""  # ISO 8601, UTC; empty in plans of earlier versions


def put_scan(connection: Connection, scan_id: str, patient_id: str | None, now: str, again: bool = False) -> None:
    """Says whose scan it is: that patient's, or one who is new with it.

    Raises NotFound, and NeedsYes where she has a scan of the same file and nobody said `again`.
    """
    patient = patient_id or new_id()
    if patient_id is None:
        _add_patient(connection, patient, now)
    elif not is_there(connection, schema.patients, patient_id):
        raise _no_patient()
    else:
        _check_new(connection, scan_id, patient_id, again)
    connection.execute(insert(schema.scans_of_patients).values(scan=scan_id, patient=patient))


def move_scan(
    storage: Storage, scan_id: str, patient_id: str | None, again: bool = False, same_as: Sequence[str] = ()
) -> str:
    """The scan is that patient's from now on, or a new one's, and with it the items that were made on it; whose it is.

    `same_as`: of these scans of the patient a person has said that this one is of the same patient, whatever the bodies
    say.  Raises as `put_scan`, and NotFound where one of them is none of the patient's.
    """
    table, new_patient = schema.scans_of_patients, new_id()
    with storage.database.writing(durable=True) as connection:
        before = _patient_of(connection, scan_id)
        if patient_id is None:
            patient_id = new_patient
            _add_patient(connection, patient_id, utc_now())
        elif not is_there(connection, schema.patients, patient_id):
            raise _no_patient()
        if before == patient_id:
            _say_same(connection, scan_id, patient_id, same_as)
            return patient_id
        _check_new(connection, scan_id, patient_id, again)
        moved = [item for item in _plan(connection, before).items if item.get("scan") == scan_id]
        connection.execute(update(table).where(table.c.scan == scan_id).values(patient=patient_id))
        same = schema.same_patient
        connection.execute(delete(same).where((same.c.scan == scan_id) | (same.c.other == scan_id)))
        _say_same(connection, scan_id, patient_id, same_as)
        if moved:
            there = _plan(connection, patient_id)
            taken = {item["id"] for item in there.items}
            items = [*there.items, *(_renamed(item, taken) for item in moved)]
            _write(connection, patient_id, items, there.is_whole)
        _forget_scan(connection, before, scan_id)
    return patient_id


def _say_same(connection: Connection, scan_id: str, patient_id: str, others: Sequence[str]) -> None:
    for other in others:
        if _patient_of(connection, other) != patient_id:
            raise NotFound("One of these scans is none of this patient's.")
        pair = dict(zip(("scan", "other"), sorted((scan_id, other)), strict=True))
        same = schema.same_patient
        known = select(exists(select(same).where(same.c.scan == pair["scan"], same.c.other == pair["other"])))
        if scan_id != other and not connection.execute(known).scalar_one():
            connection.execute(insert(same).values(pair))


def said_same(storage: Storage, scan_id: str) -> set[str]:
    """Scans of which a person has said that they are of the same patient as this one, whatever the bodies say."""
    same = schema.same_patient
    of = select(same).where((same.c.scan == scan_id) | (same.c.other == scan_id))
    with storage.database.reading() as connection:
        return {other for row in connection.execute(of) for other in (row.scan, row.other)} - {scan_id}


def _add_patient(connection: Connection, patient_id: str, now: str) -> None:
    code = _new_code(connection)
    new = insert(schema.patients).values(id=patient_id, created_at=now, code=code, code_key=code_key(code))
    connection.execute(new)


def _check_new(connection: Connection, scan_id: str, patient_id: str, again: bool) -> None:
    """NeedsYes where the patient has a scan of the same file."""
    of, scans = schema.scans_of_patients, schema.scans
    sha256 = select(scans.c.sha256).where(scans.c.id == scan_id).scalar_subquery()
    same = (
        select(scans.c.id).join(of, of.c.scan == scans.c.id).where(of.c.patient == patient_id, scans.c.sha256 == sha256)
    )
    if not again and connection.execute(select(exists(same))).scalar_one():
        raise NeedsYes("This scan is already here: the same file is one of this patient's scans", "again")


def patient_of_scan(storage: Storage, scan_id: str) -> str:
    """Raises NotFound."""
    with storage.database.reading() as connection:
        return _patient_of(connection, scan_id)


def scans_of_patient(storage: Storage, patient_id: str) -> list[str]:
    """Ids, the first that came first.  Raises NotFound."""
    table, scans = schema.scans_of_patients, schema.scans
    with storage.database.reading() as connection:
        if not is_there(connection, schema.patients, patient_id):
            raise _no_patient()
        chosen = select(table.c.scan).join(scans, scans.c.id == table.c.scan).where(table.c.patient == patient_id)
        return list(connection.execute(chosen.order_by(scans.c.created_at, scans.c.id)).scalars())


def scans_of_patients(storage: Storage, patient_ids: Sequence[str]) -> dict[str, list[str]]:
    """{patient: ids of her scans, the first that came first}"""
    table, scans = schema.scans_of_patients, schema.scans
    chosen = select(table).join(scans, scans.c.id == table.c.scan).where(table.c.patient.in_(patient_ids))
    found: dict[str, list[str]] = {patient: [] for patient in patient_ids}
    with storage.database.reading() as connection:
        for row in connection.execute(chosen.order_by(scans.c.created_at, scans.c.id)):
            found[row.patient].append(row.scan)
    return found


def get_patient(storage: Storage, patient_id: str) -> PatientRow:
    """Raises NotFound."""
    table = schema.patients
    with storage.database.reading() as connection:
        row = connection.execute(select(table).where(table.c.id == patient_id)).one_or_none()
    if row is None:
        raise _no_patient()
    return value_of(PatientRow, row)


def patients_of_scans(storage: Storage, scan_ids: Sequence[str]) -> dict[str, PatientRow]:
    """{scan: its patient}; scans that are gone are not in it."""
    table, of = schema.patients, schema.scans_of_patients
    query = select(of.c.scan, table).join(table, table.c.id == of.c.patient).where(of.c.scan.in_(scan_ids))
    with storage.database.reading() as connection:
        return {row.scan: value_of(PatientRow, row) for row in connection.execute(query)}


def patients_page(
    storage: Storage, limit: int, last: tuple[str, int] | None, search: str = "", sort: Sort = "newest"
) -> tuple[list[PatientRow], tuple[str, int] | None]:
    """Patients in that order, and the key and number where the next page goes on; `search` is a part of a code."""
    table = schema.patients
    query = select(table)
    if search:
        query = query.where(func.lower(table.c.code).contains(search.lower(), autoescape=True))
    if sort == "newest":
        rows, before = newest_first(storage, query, table.c.position, limit, None if last is None else last[1])
        more = None if before is None else ("", before)
    else:
        key = table.c.code_key if sort == "code" else _first_scan_at()
        rows, more = by_key(storage, query, key, table.c.position, limit, last)
    return [value_of(PatientRow, row) for row in rows], more


def _first_scan_at() -> ColumnElement[str]:
    """When the first of a patient's scans came, ISO 8601; the empty text where she has none."""
    of, scans = schema.scans_of_patients, schema.scans
    first = select(func.min(scans.c.created_at)).join(of, of.c.scan == scans.c.id)
    return func.coalesce(first.where(of.c.patient == schema.patients.c.id).scalar_subquery(), "")


def rename_patient(storage: Storage, patient_id: str, code: str) -> None:
    """An empty code is replaced by a new random one.  Raises NotFound."""
    table = schema.patients
    with storage.database.writing() as connection:
        code = code or _new_code(connection)
        named = update(table).where(table.c.id == patient_id).values(code=code, code_key=code_key(code))
        if connection.execute(named).rowcount == 0:
            raise _no_patient()


def get_plan(storage: Storage, patient_id: str, version: int | None = None) -> PlanRow:
    """The plan as it is, or as it was in a version that is still kept; empty before the first.  Raises NotFound."""
    table = schema.plans
    with storage.database.reading() as connection:
        if not is_there(connection, schema.patients, patient_id):
            raise _no_patient()
        if version is None:
            return _plan(connection, patient_id)
        chosen = select(table.c.json).where(table.c.patient == patient_id, table.c.version == version)
        document = connection.execute(chosen).scalar_one_or_none()
    if document is None:
        raise NotFound("This version of the plan is not kept any more.")
    return _plan_row(version, document)


def put_plan(storage: Storage, patient_id: str, items: Sequence[Document], seen: int) -> PlanRow | None:
    """Replaces the plan that has the version `seen`; None when another one is there by now.

    Raises NotFound, and Conflict for an item of a scan that is none of hers, perhaps since a moment ago.
    """
    table = schema.scans_of_patients
    with storage.database.writing(durable=True) as connection:
        if not is_there(connection, schema.patients, patient_id):
            raise _no_patient()
        if _version(connection, patient_id) != seen:
            return None
        scans = set(connection.execute(select(table.c.scan).where(table.c.patient == patient_id)).scalars())
        elsewhere = next((str(item["id"]) for item in items if item.get("scan") not in scans), None)
        if elsewhere is not None:
            raise Conflict(f'The scan of the item "{elsewhere}" was deleted or moved meanwhile; take the item out.')
        return _write(connection, patient_id, items, is_whole=True)


def put_items_of_scan(storage: Storage, scan_id: str, kind: str, items: Sequence[Document]) -> None:
    """Replaces the items of one kind that were made on the scan, whatever else the plan holds.  Raises NotFound."""
    with storage.database.writing(durable=True) as connection:
        patient = _patient_of(connection, scan_id)
        plan = _plan(connection, patient)
        others = [item for item in plan.items if (item.get("scan"), item["kind"]) != (scan_id, kind)]
        taken = {item["id"] for item in others}
        _write(connection, patient, [*others, *(_renamed(item, taken) for item in items)], plan.is_whole)


def forget_scan(connection: Connection, scan_id: str) -> None:
    """Before the scan's row is deleted: what was made on it goes too, and the patient when it was her last."""
    table = schema.scans_of_patients
    patient = connection.execute(select(table.c.patient).where(table.c.scan == scan_id)).scalar_one_or_none()
    if patient is None:
        return
    connection.execute(delete(table).where(table.c.scan == scan_id))
    _forget_scan(connection, patient, scan_id)


def _forget_scan(connection: Connection, patient_id: str, scan_id: str) -> None:
    table, plans = schema.scans_of_patients, schema.plans
    left = connection.execute(select(func.count()).where(table.c.patient == patient_id)).scalar_one()
    if left == 0:
        connection.execute(delete(schema.patients).where(schema.patients.c.id == patient_id))
        return
    before = _plan(connection, patient_id)
    for row in connection.execute(select(plans).where(plans.c.patient == patient_id)).all():
        plan = _plan_row(row.version, row.json)
        kept = [item for item in plan.items if item.get("scan") != scan_id]
        if len(kept) != len(plan.items):
            changed = _document(kept, plan.is_whole, plan.written_at)
            connection.execute(update(plans).where(plans.c.position == row.position).values(json=changed))
    after = _plan(connection, patient_id)
    if after != before:  # who has seen the one before must not write it again
        _write(connection, patient_id, after.items, after.is_whole)


def _write(connection: Connection, patient_id: str, items: Sequence[Document], is_whole: bool) -> PlanRow:
    plans, patients = schema.plans, schema.patients
    version, now = _version(connection, patient_id) + 1, utc_now()
    connection.execute(insert(plans).values(patient=patient_id, version=version, json=_document(items, is_whole, now)))
    connection.execute(update(patients).where(patients.c.id == patient_id).values(version=version))
    old = plans.c.version <= version - VERSIONS
    connection.execute(delete(plans).where(plans.c.patient == patient_id, old))
    return PlanRow(version, tuple(items), is_whole, now)


def _plan(connection: Connection, patient_id: str) -> PlanRow:
    plans = schema.plans
    newest = select(plans).where(plans.c.patient == patient_id).order_by(plans.c.version.desc()).limit(1)
    row = connection.execute(newest).one_or_none()
    return PlanRow(0) if row is None else _plan_row(row.version, row.json)


def _plan_row(version: int, plan: Document) -> PlanRow:
    return PlanRow(version, tuple(plan["items"]), plan.get("whole", False), plan.get("written_at", ""))


def _renamed(item: Document, taken: set[str]) -> Document:
    wanted, count = item["id"], 1
    while item["id"] in taken:
        count += 1
        item = item | {"id": f"{wanted[:56]}-{count}"}
    taken.add(item["id"])
    return item


def _document(items: Sequence[Document], is_whole: bool, written_at: str) -> Document:
    kept = {"items": list(items), "whole": is_whole, "written_at": written_at}
    return {"schema": "breastrig/plan@1", "unit": "mm"} | kept


def _version(connection: Connection, patient_id: str) -> int:
    return int(
        connection.execute(select(schema.patients.c.version).where(schema.patients.c.id == patient_id)).scalar_one()
    )


def _new_code(connection: Connection) -> str:
    """A random one that no patient here has."""
    code, table = random_code(), schema.patients
    while connection.execute(select(exists().where(table.c.code == code))).scalar_one():
        code = random_code()
    return code


def _patient_of(connection: Connection, scan_id: str) -> str:
    table = schema.scans_of_patients
    patient = connection.execute(select(table.c.patient).where(table.c.scan == scan_id)).scalar_one_or_none()
    if patient is None:
        raise no_such_scan()
    return str(patient)


def _no_patient() -> NotFound:
    return NotFound("There is no such patient; she goes with her last scan.")

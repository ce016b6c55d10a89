"""Patients, their scans and their plans.

Every scan is of one patient; a patient goes with the last scan.  A plan is replaced only by somebody who has seen the
one that is there, which its ETag proves; earlier versions are kept for undoing.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from pydantic import TypeAdapter

from breastrig.cases import fits, of_scans, plans, removal
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.layout import fit_part
from breastrig.cases.plans import StoredPlan
from breastrig.cases.writing import NONE_HERE
from breastrig.core.errors import NotFound
from breastrig.drawings.plan_schema import PlanItem
from breastrig.index import questions
from breastrig.index.questions import ListedCase, ListedScan
from breastrig.index.questions import Sort as Sort
from breastrig.storage.storage import Storage

Document = dict[str, Any]
ITEMS: TypeAdapter[list[PlanItem]] = TypeAdapter(list[PlanItem])


@dataclass(frozen=True)
class StoredPatient:
    id: str
    code: str
    created_at: str
    version: int  # of the plan; 0: there is none yet


@dataclass(frozen=True)
class PatientPlan:
    version: int
    etag: str  # of what is stored
    items: tuple[Document, ...] = ()  # as breastrig/plan@1 has them
    is_whole: bool = False  # somebody has written it as a whole: what it does not name is not wanted
    written_at: str = ""  # ISO 8601, UTC


def move_scan(
    storage: Storage, scan_id: str, patient_id: str | None, again: bool = False, same_as: Sequence[str] = ()
) -> str:
    """The scan is that patient's from now on, or a new one's, and with it the items that were made on it; whose it is.

    `same_as`: of these scans of the patient a person has said that this one is of the same patient, whatever the bodies
    say.  Raises NotFound, also where one of them is none of the patient's, Conflict while a fit of it runs, and
    NeedsYes where there is a scan of the same file.
    """
    source = storage.case_of_scan(scan_id)
    if patient_id is None:
        target = removal.move_to_new(source, scan_id, storage.new_place(), storage.new_code())
    else:
        target = storage.case(patient_id)
        removal.move_scan(source, scan_id, target, again, same_as)
    for case in (target, source):  # so the scan is always somebody's, and its links are
        storage.index.refresh(case.id)
    return target.id


def said_same(storage: Storage, scan_id: str) -> set[str]:
    """Scans that a person has stated to be of the same patient as this one, whatever the bodies' measures."""
    return of_scans.said_same(storage.case_of_scan(scan_id), scan_id)


def patient_of_scan(storage: Storage, scan_id: str) -> str:
    """The scan's patient. Raises NotFound."""
    return storage.case_of_scan(scan_id).id


def scans_of_patient(storage: Storage, patient_id: str) -> list[str]:
    """Ids of the patient's scans, oldest first. Raises NotFound."""
    return [one.id for one in storage.case(patient_id).scans()]


def get_patient(storage: Storage, patient_id: str) -> StoredPatient:
    """The patient's row. Raises NotFound."""
    return _row(storage.case(patient_id))


def patients_of_scans(storage: Storage, scan_ids: Sequence[str]) -> dict[str, StoredPatient]:
    """{scan: its patient}; scans that are gone are not in it."""
    found = {}
    for scan_id in scan_ids:
        try:
            found[scan_id] = _row(storage.case_of_scan(scan_id))
        except NotFound:
            continue
    return found


def listed_page(
    storage: Storage, limit: int, last: tuple[str, int] | None, search: str = "", sort: Sort = "newest"
) -> tuple[list[ListedCase], tuple[str, int] | None]:
    """Patients in that order, and the key and number where the next page goes on; `search` is a part of a code."""
    groups = storage.groups_in_reach()
    rows, more = storage.index.asked(questions.cases_page, limit, last, search, sort, groups)
    return _listed(storage, [row.id for row in rows]), more


def listed_patient(storage: Storage, patient_id: str) -> ListedCase:
    """The patient's line of the worklist. Raises NotFound."""
    storage.case(patient_id)
    found = _listed(storage, [patient_id])
    if not found:
        raise NotFound(NONE_HERE)
    return found[0]


def _listed(storage: Storage, ids: Sequence[str]) -> list[ListedCase]:
    """The patients that exist, from the index.

    Folders are opened only of what has changed, and of fits that have not ended, as their log says more than the index
    until then.
    """
    behind, groups = storage.index.catch_up(ids), storage.groups_in_reach()
    found = []
    for row in storage.index.asked(questions.listed_cases, ids):
        if groups is not None and row.group not in groups:  # given to others a moment ago
            continue
        scans = row.scans
        if row.id in behind:
            try:
                there = storage.case(row.id).scan_ids()
            except NotFound:
                continue
            scans = tuple(scan for scan in scans if scan.id in there)
        if scans is not row.scans or any(_goes_on(scan) for scan in scans):
            row = replace(row, scans=tuple(_with_present_fit(storage, row.id, scan) for scan in scans))
        found.append(row)
    return found


def _goes_on(scan: ListedScan) -> bool:
    """Whether its fit has not ended as far as the index knows."""
    return scan.fit is not None and scan.fit.state not in fits.ENDED


def _with_present_fit(storage: Storage, case_id: str, scan: ListedScan) -> ListedScan:
    """The scan with its fit as it is now."""
    if scan.fit is None or not _goes_on(scan):
        return scan
    try:
        case = storage.case(case_id)
        now = fits.get_fit(case, scan.id, scan.fit.id)
    except NotFound:
        return replace(scan, fit=None)
    stance = (fits.first_event(case.path / fit_part(scan.id, now.id)) or {}).get("stance")
    return replace(scan, fit=replace(scan.fit, state=now.state, verdict=now.verdict, stance=stance))


def rename_patient(storage: Storage, patient_id: str, code: str) -> None:
    """Replaces the code; an empty one by a new random one. Raises NotFound."""
    storage.case(patient_id).rename(code or storage.new_code())
    storage.index.refresh(patient_id)


def give_patient(storage: Storage, patient_id: str, group: str | None) -> None:
    """The patient is owned by that group from then on. Raises NotFound."""
    storage.case(patient_id).give_to(group)
    storage.index.refresh(patient_id)


def get_plan(storage: Storage, patient_id: str, version: int | None = None) -> PatientPlan:
    """The plan as it is, or as it was in a version that is still kept; empty before the first.  Raises NotFound."""
    return _patient_plan(plans.get_plan(storage.case(patient_id), version))


def put_plan(storage: Storage, patient_id: str, items: Sequence[Document], seen: str) -> PatientPlan:
    """Replaces the plan that has the ETag `seen`.

    Raises NotFound, Changed when another one is there by now, and Conflict for an item of a scan that is not the
    patient's, perhaps since a moment ago.
    """
    case = storage.case(patient_id)
    plan = plans.put_plan(case, ITEMS.validate_python(list(items)), seen)
    storage.index.refresh(case.id)
    return _patient_plan(plan)


def put_items_of_scan(storage: Storage, scan_id: str, kind: str, items: Sequence[Document]) -> None:
    """Replaces the items of one kind that were made on the scan, whatever else the plan holds.  Raises NotFound."""
    case = storage.case_of_scan(scan_id)
    plans.put_items_of_scan(case, scan_id, kind, ITEMS.validate_python(list(items)))
    storage.index.refresh(case.id)


def _row(case: CaseFolder) -> StoredPatient:
    document = case.document()
    return StoredPatient(case.id, document.code, document.created_at, plans.stored_plan(case).version)


def _patient_plan(plan: StoredPlan) -> PatientPlan:
    items = tuple(item.model_dump(mode="json") for item in plan.document.items)
    return PatientPlan(plan.document.version, plan.etag, items, plan.document.whole, plan.document.written_at)

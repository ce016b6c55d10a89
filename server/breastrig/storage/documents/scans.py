"""Scans, their landmarks, and their cuts by hand."""

import hashlib
import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from breastrig.cases import lengths, of_scans
from breastrig.cases.case_folder import MadeScan, ScanEntry
from breastrig.cases.documents import ScanDocument
from breastrig.cases.writing import Changed
from breastrig.core.errors import Conflict, NotFound
from breastrig.core.picks import Picks
from breastrig.index import questions
from breastrig.storage.files import scan_place, upload_name
from breastrig.storage.storage import Storage

Cuts = tuple[dict[str, Any], ...]  # {to_picture, lasso}, see scan/hand_cuts.py


@dataclass(frozen=True)
class StoredScan:
    id: str
    created_at: str
    file_type: str
    sha256: str
    facts: dict[str, Any]  # what reading found: unit, counts, bounds, frame, stance, notes


def add_scan(
    storage: Storage, row: StoredScan, patient: str | None = None, again: bool = False, group: str | None = None
) -> None:
    """Its files have been made; it is of that patient, or of a new one, whom the group owns.

    Raises NotFound when the patient is gone, and NeedsYes where there is that file already and nobody said `again`.
    """
    made = storage.files.made(scan_place(row.id))
    made.mkdir(mode=0o700, exist_ok=True)
    document = ScanDocument(
        created_at=row.created_at, sha256=row.sha256, facts=row.facts, file=upload_name(row.file_type)
    )
    if patient is not None:
        case = storage.case(patient)
        case.add_scan(made, document, row.id, again)
    else:
        case = storage.new_case(MadeScan(row.id, document, made), group)
    storage.index.refresh(case.id)


def get_scan(storage: Storage, scan_id: str) -> StoredScan:
    """The scan's row. Raises NotFound."""
    return _row(ScanEntry(scan_id, storage.case_of_scan(scan_id).scan(scan_id)))


def are_kept(storage: Storage, ids: Collection[str]) -> bool:
    """Whether none of the scans has been deleted."""
    return len(get_scans(storage, list(ids))) == len(set(ids))


def get_scans(storage: Storage, ids: Sequence[str]) -> list[StoredScan]:
    """The scans that exist, oldest first."""
    found = []
    for scan_id in dict.fromkeys(ids):
        try:
            found.append(get_scan(storage, scan_id))
        except NotFound:
            continue
    return sorted(found, key=lambda row: (row.created_at, row.id))


def scans_page(
    storage: Storage, limit: int, last: tuple[str, str] | None = None
) -> tuple[list[StoredScan], tuple[str, str] | None]:
    """Scans after the `last` one's time and id, the newest first, and where the next page goes on (None: nowhere)."""
    groups = storage.groups_in_reach()
    ids, more = storage.index.asked(questions.scans_page, limit, last, groups)
    return get_scans(storage, ids)[::-1], more


def get_landmarks(storage: Storage, scan_id: str) -> Picks:
    """The scan's landmarks; empty when none were stored."""
    try:
        return of_scans.get_landmarks(storage.case_of_scan(scan_id), scan_id)
    except NotFound:
        return Picks({})


def put_landmarks(storage: Storage, scan_id: str, picks: Picks, seen: str | None = None) -> bool:
    """Replaces the scan's landmarks; where `seen`, a digest, is given, only those, else it answers False.

    Raises NotFound when the scan is gone.
    """
    case = storage.case_of_scan(scan_id)
    try:
        of_scans.put_landmarks(case, scan_id, picks, seen, digest=lambda: picks_digest(get_landmarks(storage, scan_id)))
    except Changed:
        return False
    storage.index.refresh(case.id)
    return True


def picks_digest(picks: Picks) -> str:
    """A digest of landmarks, independent of their order; empty where there are none."""
    if not picks.points_mm and not picks.marks_mm:
        return ""
    points, marks = (
        {name: [*map(float, at)] for name, at in each.items()} for each in (picks.points_mm, picks.marks_mm)
    )
    known = [points, sorted(picks.certain), picks.confidence, *([marks] if marks else [])]
    text = json.dumps(known, separators=(",", ":"), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def get_cuts(storage: Storage, scan_id: str) -> Cuts:
    """The scan's cuts, oldest first; empty where nothing was cut."""
    try:
        return of_scans.get_cuts(storage.case_of_scan(scan_id), scan_id)
    except NotFound:
        return ()


def put_cuts(storage: Storage, scan_id: str, cuts: Cuts, seen: str | None = None) -> bool:
    """Replaces the scan's cuts, as `put_landmarks` does landmarks."""
    case = storage.case_of_scan(scan_id)
    try:
        of_scans.put_cuts(case, scan_id, cuts, seen, digest=lambda: cuts_digest(get_cuts(storage, scan_id)))
    except Changed:
        return False
    storage.index.refresh(case.id)
    return True


def get_factor(storage: Storage, scan_id: str) -> float:
    """From the size of the scan's file to that which it has. Raises NotFound."""
    size = lengths.get_length(storage.case_of_scan(scan_id), scan_id)
    return 1.0 if size is None else size.factor


def put_length(storage: Storage, scan_id: str, length: tuple[lengths.End, lengths.End, float] | None) -> None:
    """Gives the scan its true size (from, to, mm; as cases/lengths.py says), or with None its file's.

    Raises NotFound, BadLandmarks, Conflict while a fit of it waits or runs.
    """
    case = storage.case_of_scan(scan_id)
    if length is None:
        lengths.delete_length(case, scan_id)
    else:
        lengths.put_length(case, scan_id, length[:2], length[2])
    storage.index.refresh(case.id)


def said_model(storage: Storage, patient_id: str, scan_id: str) -> str | None:
    """Name of the model that a person has said is the right one for the patient's scan; None where nobody has."""
    try:
        return of_scans.get_answers(storage.case(patient_id), scan_id).model
    except NotFound:
        return None


def say_model(storage: Storage, scan_id: str, model: str, its: str) -> None:
    """Stores what `said_model` gives. Raises NotFound, and Conflict when `its` model is another one."""
    if model != its:
        raise Conflict(f'The scan was uploaded for the model "{its}". For another model upload its file again.')
    of_scans.say_model(storage.case_of_scan(scan_id), scan_id, model)


def cuts_digest(cuts: Sequence[dict[str, Any]]) -> str:
    """A digest of cuts; empty where nothing was cut."""
    text = json.dumps(cuts, separators=(",", ":"), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16] if cuts else ""


def cut_facts(row: StoredScan) -> dict[str, Any]:
    """The parts of the scan that are not the patient: background, table, other_pieces."""
    seen = (row.facts.get("orientation") or {}).get("seen", {})  # all that earlier versions have kept of the table
    known = {"background": [], "table": seen.get("table"), "other_pieces": []}
    return known | {name: row.facts[name] for name in known if name in row.facts}


def _row(entry: ScanEntry) -> StoredScan:
    known = entry.document
    return StoredScan(entry.id, known.created_at, Path(known.file).suffix.lstrip("."), known.sha256, known.facts)

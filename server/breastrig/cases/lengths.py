"""The length that gives a scan of a case its true size (scan/true_size.py): one file decides about all that is kept."""

from collections.abc import Mapping, Sequence

import numpy as np

from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.fits import fits_of_scan, is_at_work
from breastrig.cases.layout import scan_part
from breastrig.cases.of_scans import get_landmarks
from breastrig.cases.plans import stored_plan, write_plan
from breastrig.cases.writing import put, sync_folder
from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadLandmarks, Conflict
from breastrig.core.picks import PLACES, Length
from breastrig.scan.true_size import KEPT, TrueSize, kept_document, kept_factor, kept_size, true_size

AT_WORK = "A fit of this scan waits or runs; cancel it or wait for its end, then give the scan its size."
OLD = "This scan was kept by an early version of BreastRig; upload its file again to give it its true size."
IMAGE = "An image has its true size already; it takes no length."
FAR = "An end of the length lies outside of the scan; give both in mm, in the scan's own frame."
REACH = 0.05  # m beyond the scan's bounds

End = str | Sequence[float]  # a landmark or mark of the scan, or (3,) mm in its frame and present size


def get_length(case: CaseFolder, scan_id: str) -> TrueSize | None:
    """How the scan got its true size; None: it has that of its file. Raises NotFound."""
    case.check_scan(scan_id)
    return kept_size(case.scan_folder(scan_id))


def put_length(case: CaseFolder, scan_id: str, ends: tuple[End, End], mm: float) -> TrueSize:
    """Gives the scan its true size, and with it all that is kept of it; fits in another size count no more.

    Raises NotFound, BadLandmarks, Conflict while a fit of it waits or runs.
    """
    with case.writing():
        document = case.scan(scan_id)
        facts = document.facts
        if facts.get("image") or facts.get("segments"):
            raise BadLandmarks(IMAGE)
        if document.file != layout.STORED:
            raise Conflict(OLD)
        picks, per_mm = get_landmarks(case, scan_id), 1e-3 / kept_factor(case.scan_folder(scan_id))
        places = {name: per_mm * np.array(at) for name, at in (picks.points_mm | picks.marks_mm).items()}
        names = list[str]()
        for end, name in zip(ends, PLACES, strict=True):
            if not isinstance(end, str):
                _check_near(facts["bounds_m"], end)
                places[name] = per_mm * np.array(end, dtype=np.float64)
            names.append(end if isinstance(end, str) else name)
        size = true_size(Length(names[0], names[1], mm), places)
        _put(case, scan_id, size)
    return size


def delete_length(case: CaseFolder, scan_id: str) -> None:
    """The scan has its file's size again.  Raises NotFound, Conflict while a fit of it waits or runs."""
    with case.writing():
        if get_length(case, scan_id) is not None:
            _put(case, scan_id, None)


def _put(case: CaseFolder, scan_id: str, size: TrueSize | None) -> None:
    """One rename decides; the plan's new version is for who has seen the one before in another size."""
    states = {fit.state for fit in fits_of_scan(case, scan_id)}
    if "queued" in states or ("running" in states and is_at_work(case, scan_id)):
        raise Conflict(AT_WORK)
    if size is None:
        (case.scan_folder(scan_id) / KEPT).unlink(missing_ok=True)
        sync_folder(case.scan_folder(scan_id))
    else:
        put(case.path, f"{scan_part(scan_id)}/{KEPT}", json_bytes(kept_document(size)))
    plan = stored_plan(case)
    if any(item.scan == scan_id for item in plan.items):
        write_plan(case, plan.items, plan.whole)


def _check_near(bounds: Mapping[str, Sequence[float]], end: Sequence[float]) -> None:
    metres = 1e-3 * np.array(end, dtype=np.float64)
    low, high = np.array(bounds["min"]) - REACH, np.array(bounds["max"]) + REACH
    if metres.shape != (3,) or not ((metres >= low) & (metres <= high)).all():
        raise BadLandmarks(FAR)

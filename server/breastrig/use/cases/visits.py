"""The visits of a case: the day of each scan as a person has said it, and what the dated scans say over time."""

from contextlib import suppress
from dataclasses import dataclass
from datetime import date, timedelta
from itertools import combinations
from pathlib import Path

from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.fits import fits_of_scan
from breastrig.cases.layout import fit_part
from breastrig.cases.of_scans import get_answers, get_cuts, put_visit, said_same
from breastrig.core import wall_clock
from breastrig.core.errors import BadInput
from breastrig.core.model_choice import ModelChoice
from breastrig.report.pages.printable import check_printable
from breastrig.use.visits.over_time import DatedFit, VisitsJob

LABEL = 60  # characters


@dataclass(frozen=True)
class ScanVisit:
    """When a scan was taken; it is never guessed."""

    date: str | None  # ISO 8601, a day; None: nobody has said it
    label: str  # before, in theatre, 6 weeks; may be empty


def visit_of(case: CaseFolder, scan_id: str) -> ScanVisit:
    """As a person has said it. Raises NotFound."""
    found = get_answers(case, scan_id)
    return ScanVisit(found.visit_date, found.visit or "")


def say_visit(case: CaseFolder, scan_id: str, day: str | None, label: str = "") -> ScanVisit:
    """Stores the day (ISO 8601; None: not known) and the label of a scan's visit.  Raises NotFound, BadInput."""
    if day is not None:
        said = None
        with suppress(ValueError):
            said = date.fromisoformat(day)
        if said is None or said.isoformat() != day or said.year < 1900:
            raise BadInput(f"{day[:20]} is no day; write it as year-month-day, such as 2026-11-29.")
        if said > wall_clock.now().date() + timedelta(days=1):
            raise BadInput(f"{day} is in the future; a visit is the day on which the scan was taken.")
    label = label.strip()
    if len(label) > LABEL:
        raise BadInput(f"The name of a visit may have {LABEL} characters; shorten it.")
    check_printable([("The name of the visit", label)])
    put_visit(case, scan_id, day, label)
    return ScanVisit(day, label)


def visits_job(case: CaseFolder, choice: ModelChoice) -> VisitsJob:
    """The newest finished fit of each scan that has one, with its visit.  Raises BadInput.

    Scans for other models than the first one's are left out.
    """
    found = list[tuple[Path | None, DatedFit]]()
    for scan in case.scans():
        done = [each for each in fits_of_scan(case, scan.id) if each.state == "done"]
        done = [each for each in done if each.document.predicted_from is None]
        if done and (stance := (done[-1].last or {}).get("result", {}).get("stance")):
            folder, visit = case.path / fit_part(scan.id, done[-1].id), visit_of(case, scan.id)
            cuts = tuple(get_cuts(case, scan.id))
            fit = DatedFit(scan.id, folder, stance, visit.date, visit.label, cuts)
            found.append((choice.of(scan.document.facts), fit))
    model = found[0][0] if found else None
    fits = tuple(fit for its, fit in found if its == model)
    pairs = combinations(sorted(fit.scan for fit in fits), 2)
    return VisitsJob(fits, frozenset(pair for pair in pairs if pair[1] in said_same(case, pair[0])), model)

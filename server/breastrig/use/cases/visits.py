"""The visits of a case: the day of each scan as a person has said it, and what the dated scans say over time."""

from dataclasses import dataclass
from datetime import date, timedelta
from itertools import combinations

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
        try:
            said = date.fromisoformat(day)
        except ValueError as error:
            raise BadInput(f"{day[:20]} is no day; write it as year-month-day, such as 2026-11-29.") from error
        if said.isoformat() != day or said.year < 1900:
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
    found, models = list[DatedFit](), dict[str, str]()
    for scan in case.scans():
        done = [
            fit for fit in fits_of_scan(case, scan.id) if fit.state == "done" and fit.document.predicted_from is None
        ]
        if done and (stance := (done[-1].last or {}).get("result", {}).get("stance")):
            visit, cuts = visit_of(case, scan.id), tuple(get_cuts(case, scan.id))
            found.append(
                DatedFit(scan.id, case.path / fit_part(scan.id, done[-1].id), stance, visit.date, visit.label, cuts)
            )
            models[scan.id] = str(choice.of(scan.document.facts))
    same = {pair for pair in combinations(sorted(models), 2) if pair[1] in said_same(case, pair[0])}
    first = models[found[0].scan] if found else ""
    fits = tuple(fit for fit in found if models[fit.scan] == first)
    return VisitsJob(fits, frozenset(same), choice.of(case.scan(fits[0].scan).facts) if fits else None)

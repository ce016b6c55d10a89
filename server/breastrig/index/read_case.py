"""What the index keeps of one case, read from its folder while nobody writes there."""

from dataclasses import dataclass

from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.fits import fits_of_scan
from breastrig.cases.plans import stored_plan
from breastrig.core.identity import code_key

Row = tuple[object, ...]


@dataclass(frozen=True)
class CaseRows:
    """Rows in the order of their tables' columns."""

    case: Row
    scans: tuple[Row, ...]
    fits: tuple[Row, ...]  # without a place


def read_case(case: CaseFolder) -> CaseRows:
    """To be called where nobody else writes into the case.

    Raises NotFound when the case is gone, BadInput for a damaged document.
    """
    document, stamp, scans, fits = case.document(), case.stamp, case.scans(), list[Row]()
    for scan in scans:
        for fit in fits_of_scan(case, scan.id):
            verdict = ((fit.last or {}).get("result", {}).get("verdict") or {}).get("level")
            asked = fit.document
            fits.append((fit.id, case.id, scan.id, asked.asked_at, fit.state, verdict, asked.predicted_from))
    first = scans[0].document.created_at if scans else ""
    names = document.code, code_key(document.code), document.code.casefold()
    stances = {one.id: one.document.facts.get("stance", {}).get("proposed", "") for one in scans}
    return CaseRows(
        (case.id, *names, document.created_at, first, stored_plan(case).version, stamp),
        tuple((one.id, case.id, one.document.created_at, stances[one.id], one.document.sha256) for one in scans),
        tuple(fits),
    )

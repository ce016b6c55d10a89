"""The index's rows of one case, read from its folder while nobody writes there."""

from dataclasses import dataclass

from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.documents import ExpiresDocument
from breastrig.cases.fits import first_event, fits_of_scan
from breastrig.cases.layout import EXPIRES, LINKS, fit_part, scan_part
from breastrig.cases.links import links_of_fit
from breastrig.cases.plans import stored_plan
from breastrig.core.identity import code_key

Row = tuple[object, ...]


@dataclass(frozen=True)
class CaseRows:
    """Rows in the order of their tables' columns."""

    case: Row
    scans: tuple[Row, ...]
    fits: tuple[Row, ...]  # without a place
    links: tuple[Row, ...] = ()


def read_case(case: CaseFolder) -> CaseRows:
    """The case's rows, to be read where nobody else writes into the case.

    Raises NotFound when the case is gone, BadInput for a damaged document.
    """
    document, stamp, scans = case.document(), case.stamp, case.scans()
    fits, links = list[Row](), list[Row]()
    for scan in scans:
        for fit in fits_of_scan(case, scan.id):
            asked = fit.document
            hashes = asked.key_sha256, asked.request_sha256
            stance = "" if asked.simulated else asked.stance  # nobody is given one for a prediction
            known = fit.id, case.id, scan.id, asked.asked_at, fit.state, fit.verdict, asked.predicted_from, stance
            decided = (first_event(case.path / fit_part(scan.id, fit.id)) or {}).get("stance")
            fits.append((*known, *hashes, decided))
            if (case.path / fit_part(scan.id, fit.id) / LINKS).is_dir():
                for link, one in links_of_fit(case, scan.id, fit.id).items():
                    ends = "" if one.revoked_at else one.expires_at
                    links.append((link, case.id, scan.id, fit.id, ends, one.shown))
    first = scans[0].document.created_at if scans else ""
    names = document.code, code_key(document.code), document.code.casefold()
    stances = {one.id: one.document.facts.get("stance", {}).get("proposed", "") for one in scans}
    return CaseRows(
        (case.id, *names, document.created_at, first, stored_plan(case).version, stamp),
        tuple(
            (one.id, case.id, one.document.created_at, stances[one.id], one.document.sha256, _announced(case, one.id))
            for one in scans
        ),
        tuple(fits),
        tuple(links),
    )


def _announced(case: CaseFolder, scan_id: str) -> str | None:
    found = case.read(f"{scan_part(scan_id)}/{EXPIRES}", ExpiresDocument)
    return None if found is None else found.announced_at

"""The index's rows of one case, read from its folder while nobody writes there."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from breastrig.cases.case_folder import CaseFolder, ScanEntry
from breastrig.cases.documents import ExpiresDocument
from breastrig.cases.fits import first_event, fits_of_scan
from breastrig.cases.layout import EXPIRES, LINKS, fit_part, scan_part
from breastrig.cases.links import links_of_fit
from breastrig.cases.plans import stored_plan
from breastrig.core.identity import code_key
from breastrig.drawings.plan_schema import PlanItem, PlanPattern

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
            known = fit.id, case.id, scan.id, asked.asked_at, fit.state, fit.verdict, fit.line_error_mm
            decided = (first_event(case.path / fit_part(scan.id, fit.id)) or {}).get("stance")
            fits.append((*known, asked.predicted_from, asked.stance, *hashes, decided))
            if (case.path / fit_part(scan.id, fit.id) / LINKS).is_dir():
                for link, one in links_of_fit(case, scan.id, fit.id).items():
                    ends = "" if one.revoked_at else one.expires_at
                    links.append((link, case.id, scan.id, fit.id, ends, one.shown))
    first = scans[0].document.created_at if scans else ""
    names = document.code, code_key(document.code), document.code.casefold()
    plan = stored_plan(case)
    planned = json.dumps(planned_in_short(plan.items))
    return CaseRows(
        (case.id, *names, document.created_at, first, plan.version, planned, document.group, stamp),
        tuple(_scan_row(case, one) for one in scans),
        tuple(fits),
        tuple(links),
    )


def planned_in_short(items: Sequence[PlanItem]) -> dict[str, Any]:
    """{"patterns": names, "lines": count, "lesions": count} of a plan; a tumour given by the clock is a lesion."""
    kinds = [item.kind for item in items]
    patterns = dict.fromkeys(item.name for item in items if isinstance(item, PlanPattern))
    lesions = kinds.count("lesion") + kinds.count("tumour")
    return {"patterns": list(patterns), "lines": kinds.count("line"), "lesions": lesions}


def _scan_row(case: CaseFolder, scan: ScanEntry) -> Row:
    facts = scan.document.facts
    kind = "image" if facts.get("segments") or facts.get("image") else "surface"
    stance = facts.get("stance", {}).get("proposed", "")
    announced = _announced(case, scan.id)
    return scan.id, case.id, scan.document.created_at, stance, kind, scan.document.sha256, announced


def _announced(case: CaseFolder, scan_id: str) -> str | None:
    found = case.read(f"{scan_part(scan_id)}/{EXPIRES}", ExpiresDocument)
    return None if found is None else found.announced_at

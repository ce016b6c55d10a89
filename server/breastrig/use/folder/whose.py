"""Whose a plan or drawing file is: it may carry the patient's code and the sha256 of the scans that it was made on.

A fixed scanner gives every patient one frame, so that another's lines and tumours lie near this skin too.  A file that
names other scans and another code is asked about; one that names nothing is as it always was.
"""

from collections.abc import Iterable, Mapping
from typing import Any

from breastrig.core.errors import NeedsYes
from breastrig.files.result import ResultFile


def check_whose(document: Mapping[str, Any], fits: Iterable[ResultFile], same_patient: bool) -> None:
    """NeedsYes where the file is another patient's, or cannot be known to be this one's; `same_patient`: it is."""
    results = list(fits)
    codes = [each.patient.code for each in results if each.patient is not None]
    asked_about(document, [each.scan.sha256 for each in results], codes, same_patient)


def asked_about(document: Mapping[str, Any], scans: Iterable[str], codes: Iterable[str], same_patient: bool) -> None:
    """Raises NeedsYes for another patient's document, as check_whose, by the scans' sha256 and the patient's codes."""
    made_on, code = _scans(document), str(document.get("patient") or "")
    own = [each for each in dict.fromkeys(codes) if each]
    if same_patient or not (made_on or code) or made_on & set(scans) or code in own:
        return
    theirs = f"patient {code}" if code else "another scan, of no patient named"
    ours = f"patient {', '.join(own)}" if own else "another scan"
    raise NeedsYes(f"This plan or drawing was made for {theirs}, not for {ours}", "same_patient")


def _scans(document: Mapping[str, Any]) -> set[str]:
    listed = document.get("scans")
    entries = [each for each in listed if isinstance(each, Mapping)] if isinstance(listed, list) else []
    return {str(each) for each in (document.get("scan_sha256"), *(scan.get("sha256") for scan in entries)) if each}


def made_on(result: ResultFile) -> dict[str, str]:
    """The fields of a drawing on that fit's scan that say whose it is."""
    code = "" if result.patient is None else result.patient.code
    return {"scan_sha256": result.scan.sha256} | ({"patient": code} if code else {})

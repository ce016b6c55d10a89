"""Checks whose a sent plan or drawing is: one that names another patient is questioned."""

from collections.abc import Mapping, Sequence
from typing import Any

from breastrig.api.app_context import storage
from breastrig.storage.documents.patients import get_patient, scans_of_patient
from breastrig.storage.documents.scans import get_scans
from breastrig.use.folder.whose import asked_about


def check_whose(document: Mapping[str, Any], patients: Sequence[str], same_patient: bool) -> None:
    """NeedsYes where it is none of these patients' and nobody says `same_patient`; NotFound for one who is gone."""
    if not (document.get("patient") or document.get("scans") or document.get("scan_sha256")):
        return
    found = [get_patient(storage, each) for each in dict.fromkeys(patients)]
    scans = get_scans(storage, [scan for each in found for scan in scans_of_patient(storage, each.id)])
    asked_about(document, [row.sha256 for row in scans], [each.code for each in found], same_patient)

"""Ink on scans: searched once a scan, see scan_search.py."""

from pathlib import Path
from typing import Any

from breastrig.core.errors import BadScan
from breastrig.service.scan_search import ScanSearch, Task
from breastrig.storage.rows.ink import get_ink, put_ink
from breastrig.storage.rows.scans import ScanRow
from breastrig.workflow.further_jobs import InkJob
from breastrig.workflow.tasks import find_ink_on_file


class InkSearch(ScanSearch):
    """breastrig/drawing@1 of each scan, in mm."""

    what = "Finding ink"
    instead = "Draw the lines by hand."

    def found(self, scan: ScanRow, wait_s: float) -> dict[str, Any] | None:
        """The drawing; None when it takes longer and goes on.  Raises BadScan at once for a scan without colour."""
        if scan.facts.get("colours") == "none":
            raise BadScan("This scan has no colour, so no ink can be seen on it; scan again with colour.")
        return self.get(scan, "", wait_s)

    def _stored(self, scan_id: str, variant: str) -> dict[str, Any] | None:
        return get_ink(self._storage, scan_id)

    def _store(self, scan_id: str, variant: str, found: dict[str, Any]) -> None:
        put_ink(self._storage, scan_id, found)

    def _task(self, file: Path, scan: ScanRow) -> Task:
        return find_ink_on_file, InkJob(file, scan.file_type, scan.facts["unit"])

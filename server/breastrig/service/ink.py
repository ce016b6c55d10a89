"""Ink on scans: searched once a scan, see scan_search.py.

It is searched on the whole scan, whatever is cut out of it: cuts come and go, and lines keep their names.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.errors import BadScan
from breastrig.scan.hand_cuts import are_cut
from breastrig.service.scan_search import ScanSearch, Task
from breastrig.storage.rows.cuts import get_cuts
from breastrig.storage.rows.ink import drop_ink, get_ink, put_ink
from breastrig.storage.rows.scans import ScanRow
from breastrig.workflow.jobs import InkJob
from breastrig.workflow.tasks import find_ink_on_file


class InkSearch(ScanSearch):
    """breastrig/drawing@1 of each scan, in mm."""

    what = "Finding ink"
    instead = "Draw the lines by hand."

    def found(self, scan: ScanRow, wait_s: float) -> dict[str, Any] | None:
        """The drawing; None when it takes longer and goes on.  Raises BadScan at once for a scan without colour."""
        if scan.facts.get("colours") == "none":
            raise BadScan("This scan has no colour, so no ink can be seen on it; scan again with colour.")
        found = self.get(scan, "", wait_s)
        return None if found is None else self._with_cuts(scan.id, found)

    def mark_dropped(self, scan_id: str, dropped: Mapping[str, bool]) -> dict[str, Any]:
        """The drawing after these lines were dropped, or are so no more; see storage/rows/ink.py for what it raises."""
        return self._with_cuts(scan_id, drop_ink(self._storage, scan_id, dropped))

    def _with_cuts(self, scan_id: str, drawing: dict[str, Any]) -> dict[str, Any]:
        """Says of each line that lies for the most part in what is cut out of the scan by hand that it is cut."""
        cuts = get_cuts(self._storage, scan_id)
        if not cuts:
            return drawing
        places_m = [1e-3 * np.array(shape["points"], dtype=float) for shape in drawing["shapes"]]
        shapes = [
            shape | {"cut": True} if np.mean(are_cut(places, cuts)) > 0.5 else shape
            for shape, places in zip(drawing["shapes"], places_m, strict=True)
        ]
        return drawing | {"shapes": shapes}

    def _stored(self, scan_id: str, variant: str) -> dict[str, Any] | None:
        return get_ink(self._storage, scan_id)

    def _store(self, scan_id: str, variant: str, found: dict[str, Any]) -> None:
        put_ink(self._storage, scan_id, found)

    def _task(self, file: Path, scan: ScanRow) -> Task:
        return find_ink_on_file, InkJob(file, scan.file_type, scan.facts["unit"])

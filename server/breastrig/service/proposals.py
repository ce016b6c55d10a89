"""Proposed landmarks: searched once a scan and model, see scan_search.py."""

import hashlib
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from breastrig.execution.executor import Executor
from breastrig.service.scan_search import ScanSearch, Task
from breastrig.storage.rows.cuts import cuts_digest, get_cuts
from breastrig.storage.rows.proposals import get_proposals, put_proposals
from breastrig.storage.rows.scans import Picks, ScanRow, get_landmarks
from breastrig.storage.storage import Storage
from breastrig.workflow.jobs import ProposeJob

SAME_PLACE = 0.05  # mm; no click meets a proposal so closely

Proposer = Callable[[ProposeJob], dict[str, Any]]


class Proposals(ScanSearch):
    """{name: {point (mm), confidence, on_scan, error_mm}} of each scan; see `variant`."""

    what = "Finding landmarks"
    instead = "Place them by hand."

    def __init__(
        self, storage: Storage, processes: Executor, wall_s: float, proposer: Proposer, model: Path | None
    ) -> None:
        super().__init__(storage, processes, wall_s)
        self._proposer = proposer
        self._model = model

    def variant(self, scan_id: str, model_sha256: str) -> str:
        """The sha256 of the model, and of what is cut out of the scan by hand."""
        digest = cuts_digest(get_cuts(self._storage, scan_id))
        return hashlib.sha256(f"{model_sha256} {digest}".encode()).hexdigest() if digest else model_sha256

    def agreed(self, scan_id: str, variant: str, picks: Picks) -> Picks:
        """With the confidence of each of which nothing is said: as it was there, else as proposed."""
        before = get_landmarks(self._storage, scan_id)
        known = [(before.points_mm[name], name, share) for name, share in before.confidence.items()]
        proposed = self.known(scan_id, variant) or {}
        known += [(each["point"], name, float(each["confidence"])) for name, each in proposed.items()]
        said = {*picks.certain, *picks.confidence}
        found: dict[str, float] = {}
        for place, name, share in known:
            if name in picks.points_mm and name not in said and math.dist(picks.points_mm[name], place) < SAME_PLACE:
                found.setdefault(name, share)
        return replace(picks, confidence=picks.confidence | found)

    def _stored(self, scan_id: str, variant: str) -> dict[str, Any] | None:
        return get_proposals(self._storage, scan_id, variant)

    def _store(self, scan_id: str, variant: str, found: dict[str, Any]) -> None:
        put_proposals(self._storage, scan_id, variant, found)

    def _task(self, file: Path, scan: ScanRow) -> Task:
        cuts = get_cuts(self._storage, scan.id)
        orientation = None if cuts else scan.facts.get("orientation")  # that is of the whole scan
        return self._proposer, ProposeJob(file, scan.file_type, scan.facts["unit"], self._model, orientation, cuts)

"""Searches on a scan: computed once, in a process of its own, and kept with the scan's rows.

Whoever asks while it is being computed waits for the same computation.  A failure is raised for those who wait and is
not kept: the next call tries again.  Ink is searched on the whole scan, whatever is cut out of it: cuts come and
go, and lines keep their names.
"""

import hashlib
import logging
import math
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError, Future, wait
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.cases import of_scans
from breastrig.cases.documents import InkDocument
from breastrig.core.errors import BadScan, BreastRigError, FitFailed, NotFound
from breastrig.core.model_choice import ModelChoice
from breastrig.core.picks import Picks
from breastrig.execution.executor import Executor
from breastrig.fitting.prepare_scan import keeping
from breastrig.scan.hand_cuts import are_cut
from breastrig.scan.piece import COLOURLESS
from breastrig.service.failed_tasks import FULL
from breastrig.storage.documents.scans import StoredScan, cuts_digest, get_cuts, get_factor, get_landmarks, get_scan
from breastrig.storage.files import scan_place, upload_name
from breastrig.storage.storage import Storage
from breastrig.use.ink import InkJob, find_ink_on_file
from breastrig.use.landmarks import ProposeJob

Task = tuple[Callable[[Any], dict[str, Any]], Any]  # a function of a named module, and what it is given

log = logging.getLogger(__name__)


class ScanSearch(ABC):
    """The searches of one kind, on all scans.  All methods may be called from any thread.

    `variant` says with what it is searched, such as a model; one that has no variants has the empty one.
    """

    what: str  # "Finding landmarks"
    instead: str  # what a person can do when it breaks

    def __init__(self, storage: Storage, processes: Executor, wall_s: float) -> None:
        self._storage = storage
        self._processes = processes
        self._wall_s = wall_s
        self._lock = threading.Lock()
        self._running: dict[tuple[str, str], Any] = {}  # by scan and variant; a failed one stays until it was raised

    @abstractmethod
    def _stored(self, scan_id: str, variant: str) -> dict[str, Any] | None:
        """The stored result."""

    @abstractmethod
    def _store(self, scan_id: str, variant: str, found: dict[str, Any]) -> None:
        """Keeps it.  Raises NotFound when the scan is gone."""

    @abstractmethod
    def _task(self, file: Path, scan: StoredScan) -> Task:
        """The task to run; `file` is the scan's."""

    def get(self, scan: StoredScan, variant: str, wait_s: float) -> dict[str, Any] | None:
        """The result; None when it takes more than `wait_s` and goes on.

        Raises a BreastRigError when it cannot be done, NotFound when the scan was deleted meanwhile.
        """
        future = self._future(scan, variant)
        if not wait([future], timeout=wait_s).done:
            return None
        try:
            found: dict[str, Any] = future.result()
            return found
        except CancelledError as error:
            raise NotFound("This scan was deleted.") from error
        except Exception as error:
            self._forget((scan.id, variant), future)
            get_scan(self._storage, scan.id)
            raise self._as_sentence(error) from error

    def known(self, scan_id: str, variant: str) -> dict[str, Any] | None:
        """The known result, also while it is still being stored; None where there is none."""
        with self._lock:
            ended = self._running.get((scan_id, variant))
        if ended is not None and ended.done() and not ended.cancelled() and ended.exception() is None:
            found: dict[str, Any] = ended.result()
            return found
        return self._stored(scan_id, variant)

    def drop(self, scan_id: str) -> None:
        """Stops what runs for a scan that is being deleted."""
        with self._lock:
            dropped = [self._running.pop(key) for key in list(self._running) if key[0] == scan_id]
        for future in dropped:
            future.cancel()

    def _future(self, scan: StoredScan, variant: str) -> Any:
        """The future of the search that runs, else of the stored result, else of a search that is started.

        A search leaves `_running` once it is stored, so that looking there first misses none.
        """
        key = scan.id, variant
        with self._lock:
            future = self._running.get(key)
            if future is not None:
                return future
            stored = self._stored(scan.id, variant)
            if stored is not None:
                future = Future()
                future.set_result(stored)
                return future
            file = self._storage.files.folder(scan_place(scan.id)) / upload_name(scan.file_type)
            future = self._processes.schedule(keeping, self._task(file, scan), self._wall_s, scan.id)
            self._running[key] = future
        future.add_done_callback(lambda ended: self._keep(scan.id, variant, ended))
        return future

    def _keep(self, scan_id: str, variant: str, future: Any) -> None:
        """In the task's thread: stores what was found, even when nobody waits any more."""
        if future.cancelled() or future.exception() is not None:
            return
        try:
            with suppress(NotFound):  # the scan was deleted meanwhile
                self._store(scan_id, variant, future.result())
        except OSError as error:  # a full disk: it is found again when somebody asks
            log.warning("what was found on a scan cannot be stored: %s", getattr(error, "orig", error))
        except Exception:
            log.exception("what was found on a scan cannot be stored")
        self._forget((scan_id, variant), future)

    def _forget(self, key: tuple[str, str], future: Any) -> None:
        with self._lock:
            if self._running.get(key) is future:
                del self._running[key]

    def _as_sentence(self, error: Exception) -> Exception:
        if isinstance(error, BreastRigError) or getattr(error, "errno", None) in FULL:
            return error
        if isinstance(error, TimeoutError):
            return FitFailed(f"{self.what} took longer than {self._wall_s:g} s; simplify the scan first.")
        log.error("the process that looked on a scan broke: %r", error)
        return FitFailed(f"{self.what} on this scan broke; the server's log says why. {self.instead}")


class InkSearch(ScanSearch):
    """The drawing (breastrig/drawing@1, mm) of found lines on each scan."""

    what = "Finding ink"
    instead = "Draw the lines by hand."

    def found(self, scan: StoredScan, wait_s: float) -> dict[str, Any] | None:
        """The drawing; None when it takes longer and goes on.  Raises BadScan at once for a scan without colour."""
        if scan.facts.get("colours") == "none":
            raise BadScan(COLOURLESS)
        found = self.get(scan, "", wait_s)
        return None if found is None else self._with_cuts(scan.id, found)

    def mark_dropped(self, scan_id: str, dropped: Mapping[str, bool]) -> dict[str, Any]:
        """The drawing after these lines were dropped, or are so no more; raises as `of_scans.drop_ink`."""
        found = of_scans.drop_ink(self._storage.case_of_scan(scan_id), scan_id, dict(dropped))
        return self._with_cuts(scan_id, _drawing(found))

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
        with suppress(NotFound):
            found = of_scans.get_ink(self._storage.case_of_scan(scan_id), scan_id)
            return None if found is None else _drawing(found)
        return None

    def _store(self, scan_id: str, variant: str, found: dict[str, Any]) -> None:
        of_scans.put_ink(self._storage.case_of_scan(scan_id), scan_id, found)

    def _task(self, file: Path, scan: StoredScan) -> Task:
        return find_ink_on_file, InkJob(file, scan.file_type, scan.facts["unit"])


def _drawing(found: InkDocument) -> dict[str, Any]:
    """The found drawing, with dropped shapes marked."""
    document = found.model_dump(mode="json", by_alias=True)
    dropped, _ = document.pop("dropped"), document.pop("scale")
    shapes = [shape | {"dropped": True} if shape["name"] in dropped else shape for shape in document["shapes"]]
    return document | {"shapes": shapes}


SAME_PLACE = 0.05  # mm; no click meets a proposal so closely

Proposer = Callable[[ProposeJob], dict[str, Any]]


class Proposals(ScanSearch):
    """The proposals of `propose_on_file` on each scan, by model, cuts by hand and size."""

    what = "Finding landmarks"
    instead = "Place them by hand."

    def __init__(
        self, storage: Storage, processes: Executor, wall_s: float, proposer: Proposer, models: ModelChoice
    ) -> None:
        super().__init__(storage, processes, wall_s)
        self._proposer = proposer
        self._models = models

    def of(self, scan: StoredScan, model_sha256: str, wait_s: float) -> dict[str, Any] | None:
        """This model's proposals; as `get`."""
        return self.get(scan, self._variant(scan.id, model_sha256), wait_s)

    def _variant(self, scan_id: str, model_sha256: str) -> str:
        """The hash of the model, of the cuts by hand and of the scan's true size."""
        digest, factor = cuts_digest(get_cuts(self._storage, scan_id)), get_factor(self._storage, scan_id)
        digest += "" if factor == 1.0 else f" {factor!r}"
        return hashlib.sha256(f"{model_sha256} {digest}".encode()).hexdigest() if digest else model_sha256

    def agreed(self, scan_id: str, model_sha256: str, picks: Picks) -> Picks:
        """The picks with the confidence of unstated ones: as stored at that place, else as this model proposed it."""
        before = get_landmarks(self._storage, scan_id)
        known = [(before.points_mm[name], name, share) for name, share in before.confidence.items()]
        proposed = self.known(scan_id, self._variant(scan_id, model_sha256)) or {}
        known += [(each["point"], name, float(each["confidence"])) for name, each in proposed.items()]
        said = {*picks.certain, *picks.confidence}
        found: dict[str, float] = {}
        for place, name, share in known:
            if name in picks.points_mm and name not in said and math.dist(picks.points_mm[name], place) < SAME_PLACE:
                found.setdefault(name, share)
        return replace(picks, confidence=picks.confidence | found)

    def _stored(self, scan_id: str, variant: str) -> dict[str, Any] | None:
        with suppress(NotFound):
            return of_scans.get_proposals(self._storage.case_of_scan(scan_id), scan_id, variant)
        return None

    def _store(self, scan_id: str, variant: str, found: dict[str, Any]) -> None:
        of_scans.put_proposals(self._storage.case_of_scan(scan_id), scan_id, variant, found)

    def _task(self, file: Path, scan: StoredScan) -> Task:
        cuts = get_cuts(self._storage, scan.id)
        orientation = None if cuts else scan.facts.get("orientation")  # that is of the whole scan
        model = self._models.of(scan.facts)
        return self._proposer, ProposeJob(file, scan.file_type, scan.facts["unit"], model, orientation, cuts)

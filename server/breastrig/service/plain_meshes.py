"""The scan's shape without its colours, for share links that show no more: made once, in a process of its own.

It is kept beside the coloured mesh, as a file of the scan, so it goes with the scan.  Made for each visitor anew it
would take seconds and a hundred megabytes each time.  What was cut away by hand is not in it; other cuts make another
file.
"""

import errno
import logging

from breastrig.core.errors import FitFailed, NotFound
from breastrig.execution.fair_processes import FairProcesses
from breastrig.service.single_flight import SingleFlight
from breastrig.storage.files import MESH, PLAIN_MESH, OpenedFile, scan_place
from breastrig.storage.rows.cuts import Cuts, cuts_digest, get_cuts
from breastrig.storage.rows.scans import get_scan
from breastrig.storage.storage import Storage
from breastrig.workflow.further_jobs import PlainMeshJob
from breastrig.workflow.tasks import write_plain_mesh

WALL_S = 60.0  # the largest scan takes two seconds

log = logging.getLogger(__name__)


class PlainMeshes:
    """The plain meshes of all scans.  May be called from any thread."""

    def __init__(self, storage: Storage, processes: FairProcesses) -> None:
        self._storage = storage
        self._processes = processes
        self._flights: SingleFlight[None] = SingleFlight()

    def get(self, scan_id: str) -> OpenedFile:
        """The file, made now if it is not there.

        Raises a BreastRigError with a sentence, NotFound when the scan was deleted meanwhile, OSError for a full disk.
        """
        cuts = get_cuts(self._storage, scan_id)
        name = f"{PLAIN_MESH.removesuffix('.glb')}_{cuts_digest(cuts)}.glb" if cuts else PLAIN_MESH
        kept = self._kept(scan_id, name)
        if kept is None:
            self._flights.result(f"{scan_id}/{name}", lambda: self._make(scan_id, name, cuts))
            kept = self._kept(scan_id, name)
        if kept is None:
            raise NotFound("This scan has no mesh; it may have been deleted.")
        return kept

    def _kept(self, scan_id: str, name: str) -> OpenedFile | None:
        return self._storage.files.find(scan_place(scan_id), name)

    def _make(self, scan_id: str, name: str, cuts: Cuts) -> None:
        place, files = scan_place(scan_id), self._storage.files
        if self._kept(scan_id, name) is not None:  # it was made between looking and coming here
            return
        if files.find(place, MESH) is None:
            raise NotFound("This scan has no mesh; it may have been deleted.")
        try:
            with files.reading(place, [MESH]) as source, files.writing(place) as draft:
                job = PlainMeshJob(source / MESH, draft.folder / name, cuts)
                self._processes.result(write_plain_mesh, (job,), WALL_S)
                draft.keep()
        except TimeoutError as error:
            raise FitFailed(f"Taking the colours off this scan took longer than {WALL_S:g} s; try again.") from error
        except FileNotFoundError as error:
            raise NotFound("This scan has no mesh; it may have been deleted.") from error
        except (OSError, RuntimeError) as error:
            if getattr(error, "errno", None) in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
                raise
            log.warning("the process that took the colours off a scan died: %r", error)
            raise FitFailed("Taking the colours off this scan failed; try again, or simplify the scan.") from error
        try:
            get_scan(self._storage, scan_id)
        except NotFound:
            self._storage.remove(place)
            raise

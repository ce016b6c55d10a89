"""The scan's mesh for share links, with or without its colours: made once, in a process of its own.

It is kept beside the scan's own mesh, as a file of the scan, so it goes with the scan.  Made for each visitor anew it
would take seconds and a hundred megabytes each time.  What was cut away by hand is not in it; other cuts make another
file.  A scan of which nothing was cut away is its own coloured mesh.
"""

import errno
import logging

from breastrig.core.errors import FitFailed, NotFound
from breastrig.execution.fair_processes import FairProcesses
from breastrig.service.single_flight import SingleFlight
from breastrig.storage.files import CUT_MESH, MESH, PLAIN_MESH, OpenedFile, scan_place
from breastrig.storage.rows.cuts import Cuts, cuts_digest, get_cuts
from breastrig.storage.rows.scans import get_scan
from breastrig.storage.storage import Storage
from breastrig.workflow.further_jobs import LinkMeshJob
from breastrig.workflow.tasks import write_link_mesh

WALL_S = 60.0  # the largest scan takes two seconds

log = logging.getLogger(__name__)


class LinkMeshes:
    """The meshes of all scans, as links show them.  May be called from any thread."""

    def __init__(self, storage: Storage, processes: FairProcesses) -> None:
        self._storage = storage
        self._processes = processes
        self._flights: SingleFlight[None] = SingleFlight()

    def get(self, scan_id: str, has_colours: bool = False) -> OpenedFile:
        """The file, made now if it is not there.

        Raises a BreastRigError with a sentence, NotFound when the scan was deleted meanwhile, OSError for a full disk.
        """
        cuts = get_cuts(self._storage, scan_id)
        name = f"{CUT_MESH if has_colours else PLAIN_MESH}{f'_{cuts_digest(cuts)}' if cuts else ''}.glb"
        if has_colours and not cuts:
            name = MESH
        kept = self._kept(scan_id, name)
        if kept is None:
            self._flights.result(f"{scan_id}/{name}", lambda: self._make(scan_id, name, cuts, has_colours))
            kept = self._kept(scan_id, name)
        if kept is None:
            raise NotFound("This scan has no mesh; it may have been deleted.")
        return kept

    def _kept(self, scan_id: str, name: str) -> OpenedFile | None:
        return self._storage.files.find(scan_place(scan_id), name)

    def _make(self, scan_id: str, name: str, cuts: Cuts, has_colours: bool) -> None:
        place, files = scan_place(scan_id), self._storage.files
        if self._kept(scan_id, name) is not None:  # it was made between looking and coming here
            return
        if files.find(place, MESH) is None:
            raise NotFound("This scan has no mesh; it may have been deleted.")
        try:
            with files.reading(place, [MESH]) as source, files.writing(place) as draft:
                job = LinkMeshJob(source / MESH, draft.folder / name, cuts, has_colours)
                self._processes.result(write_link_mesh, (job,), WALL_S)
                draft.keep()
        except TimeoutError as error:
            raise FitFailed(f"Making the mesh for links took longer than {WALL_S:g} s; try again.") from error
        except FileNotFoundError as error:
            raise NotFound("This scan has no mesh; it may have been deleted.") from error
        except (OSError, RuntimeError) as error:
            if getattr(error, "errno", None) in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
                raise
            log.warning("the process that made a mesh for links died: %r", error)
            raise FitFailed("Making the mesh for links failed; try again, or simplify the scan.") from error
        try:
            get_scan(self._storage, scan_id)
        except NotFound:
            self._storage.remove(place)
            raise

"""The service's processes: those that end with their task, and those kept for scans in work, which both pools share.

A process is kept for one scan from its upload on, and serves that scan alone; pairs, transfers and reports, which look
at more than one, have a process of their own each.  Landmarks and patterns that are moved by hand have places beside
these, so that uploads take none from a hand.  Three processes stand ready beside the readers at work, as
FairProcesses hands over two tasks more, and as in each pool for the next one.
"""

from breastrig.execution.fair_processes import FairProcesses
from breastrig.execution.kept_processes import KeptProcesses
from breastrig.execution.limits import FitLimits, UploadLimits
from breastrig.execution.processes import Processes
from breastrig.execution.warm_first import WarmFirst
from breastrig.workflow.tasks import keeping

SCANS = 4  # in work at once; a patient has two


class Pools:
    """Of one service."""

    def __init__(self, uploads: UploadLimits, fits: FitLimits) -> None:
        self.scans = KeptProcesses(max(uploads.memory_bytes, fits.memory_bytes), kept=SCANS, ready=True)
        readers = Processes(uploads.workers, memory_bytes=uploads.memory_bytes, cpu_s=uploads.cpu_s, spare=3)
        fitters = Processes(fits.workers, memory_bytes=fits.memory_bytes, spare=1)
        self.readers = FairProcesses(
            WarmFirst(readers, self.scans, keeping, memory_bytes=uploads.memory_bytes, cpu_s=uploads.cpu_s),
            uploads.waiting_per_client,
        )
        self.fits = WarmFirst(fitters, self.scans, keeping, memory_bytes=fits.memory_bytes)

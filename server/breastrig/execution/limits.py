"""Resource limits of a worker process. Each number has its reason; none is a promise about speed."""

import os
from dataclasses import dataclass, field

from breastrig.scan.limits import FILE_BYTES, IMAGE_ZIP_BYTES, TRIANGLES

GIB = 2**30


@dataclass(frozen=True)
class UploadLimits:
    file_bytes: int = FILE_BYTES
    zip_bytes: int = IMAGE_ZIP_BYTES  # of DICOM images
    triangles: int = TRIANGLES
    memory_bytes: int = 6 * GIB  # address space: 1 GiB libraries, and ten times the largest file as arrays
    wall_s: float = 180.0  # 2 million triangles of text take about 20 s
    workers: int = 2
    waiting_per_client: int = 8  # scans and reports that one client may have in work; each holds a thread of the server


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)


@dataclass(frozen=True)
class FitLimits:
    workers: int = field(default_factory=lambda: max(1, min(8, _cores())))  # one fit keeps one core busy
    memory_bytes: int = 6 * GIB  # address space; a fit touches about 0.5 GiB
    wall_s: float = 120.0  # a fit takes about a second; a slow machine with a huge scan may take many
    waiting_per_client: int = (
        50  # nearly a minute of work for one core; a script waits for some before it asks for more
    )
    grace_s: float = 10.0  # how long a stopping server waits for running fits

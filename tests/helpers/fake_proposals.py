"""Proposers that stand in for propose_on_file; like the runners of fake_fit, imported by name in worker processes."""

import os
import signal
import time
from typing import Any

from breastrig.core.errors import FitFailed
from breastrig.use.landmarks import ProposeJob


def at_the_nipple(job: ProposeJob) -> dict[str, Any]:
    """One proposal, less sure of a scan with cuts, and a line in a file beside the scan each time that it was made.

    Not made while there is a file `held` beside the scan.
    """
    with job.scan.with_name("proposed").open("a") as count:
        count.write("once\n")
    while job.scan.with_name("held").exists():
        time.sleep(0.005)
    confidence = 0.25 if job.cuts else 0.5
    found = {"point": [70.0, 350.0, 120.0], "confidence": confidence, "on_scan": True, "error_mm": 16.0}
    unseen = found | {"on_scan": False, "to_skin_mm": 105.0, "reason": None}
    return {"nipple_L": found | {"reason": "areola seen"}, "umbilicus": unseen}


def failing(_job: ProposeJob) -> dict[str, Any]:
    raise FitFailed("The model found no skin near it; place three landmarks.")


def broken(_job: ProposeJob) -> dict[str, Any]:
    raise ZeroDivisionError("an error of ours")


def dying(_job: ProposeJob) -> dict[str, Any]:
    os.kill(os.getpid(), signal.SIGKILL)
    return {}


def hanging(_job: ProposeJob) -> dict[str, Any]:
    time.sleep(60)
    return {}


def by_process(_job: ProposeJob) -> dict[str, Any]:
    """Says in which process it was made."""
    found = {"point": [70.0, 350.0, 120.0], "confidence": 0.5, "on_scan": True, "error_mm": 16.0}
    return {"nipple_L": found | {"reason": str(os.getpid())}}

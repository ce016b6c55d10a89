"""Landmarks that this run has proposed before are not searched for again, see remembered.py."""

from typing import Any

from breastrig.use.landmarks import ProposeJob
from helpers.remembered import key_of_job, once


def propose_once(job: ProposeJob) -> dict[str, Any]:
    """As `propose_on_file`."""
    from breastrig.use.landmarks import propose_on_file

    found: dict[str, Any] = once(key_of_job("proposals", job), lambda: propose_on_file(job))
    return found

"""A fit that is deleted while a kept process reads it leaves nothing in memory, also where reading failed."""

import pytest
from helpers import in_worker
from helpers.rows import add_waiting_fit

from breastrig.core.errors import NotFound
from breastrig.execution.kept_processes import KeptProcesses
from breastrig.service.moving.deleted_fits import drop_if_deleted
from breastrig.storage.storage import Storage


def test_the_process_of_a_deleted_fit_is_ended_and_that_of_another_stays(storage: Storage, scan_id: str) -> None:
    add_waiting_fit(storage, scan_id, "there")
    processes = KeptProcesses(4 * 2**30)
    try:
        for fit in ("there", "gone"):
            processes.result(fit, in_worker.rest, (0.0,), 60.0)
        drop_if_deleted(storage, processes, "there")
        with pytest.raises(NotFound, match="no such fit"):
            drop_if_deleted(storage, processes, "gone")
        assert len(processes) == 1
    finally:
        processes.stop()

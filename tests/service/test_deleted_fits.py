"""A fit that is deleted while a process reads it leaves nothing in memory, also where reading failed."""

import pytest
from helpers import in_worker
from helpers.stored_fits import add_waiting_fit, named

from breastrig.core.errors import NotFound
from breastrig.execution.pool import Pool
from breastrig.service.kept_models import KeptModels
from breastrig.service.moving import Moving
from breastrig.storage.storage import Storage


def test_the_process_of_a_deleted_fit_is_ended_and_that_of_another_stays(storage: Storage, scan_id: str) -> None:
    there, gone = named("there"), named("gone")
    add_waiting_fit(storage, scan_id, there)
    pool = Pool(most_idle=4)
    queue = pool.queue(1, 4 * 2**30)
    moving = Moving(storage, queue, KeptModels(storage, None))
    try:
        for fit in (there, gone):
            queue.result(in_worker.rest, (0.0,), 60.0, fit)
        with moving.dropped_if_deleted(there):
            pass
        with pytest.raises(NotFound, match="no such fit"), moving.dropped_if_deleted(gone):
            raise OSError("cannot be read")
        assert pool.idle_keys == [there]
    finally:
        pool.stop()

"""Patterns that follow a hand on the scan of a fit: each fit in a process of its own, which is kept for a while.

What it has prepared is of one patient's body, so it is in no other process's memory and on no disk, and goes with the
deletion of the scan.
"""

from typing import Any

from breastrig.core.errors import Conflict
from breastrig.execution.kept_processes import KeptProcesses
from breastrig.service.failed_tasks import explained
from breastrig.service.kept_models import KeptModels
from breastrig.service.moving.deleted_fits import drop_if_deleted
from breastrig.storage.files import fit_place
from breastrig.storage.rows.fits import get_fit
from breastrig.storage.storage import Storage
from breastrig.workflow.jobs import LengthsQuestion, LiveQuestion
from breastrig.workflow.tasks import live_pattern, read_and_live_pattern

WALL_S = 30.0  # an answer takes a tenth of a second, the first one; huge scans on a slow machine take many


class LivePatterns:
    """May be called from any thread."""

    def __init__(self, storage: Storage, processes: KeptProcesses, models: KeptModels) -> None:
        self._storage = storage
        self._models = models
        self._processes = processes

    def answer(self, fit_id: str, question: LiveQuestion | LengthsQuestion) -> dict[str, Any]:
        """The pattern on the fit's scan, with its handles; or lengths along its skin.

        Raises NotFound, Conflict when the fit is not done, BadDrawing when the pattern does not fit there, TooMany.
        """
        fit = get_fit(self._storage, fit_id)
        if fit.state != "done":
            raise Conflict(f"The fit {fit.id} is {fit.state}; patterns and lengths need fits that are done.")
        with explained("Drawing this pattern", WALL_S, "give a smaller scan", self._storage, [fit_id]):
            found: dict[str, Any] | None = self._processes.result(fit_id, live_pattern, (fit_id, question), WALL_S)
            return self._read_and_answer(fit_id, question) if found is None else found

    def _read_and_answer(self, fit_id: str, question: LiveQuestion | LengthsQuestion) -> dict[str, Any]:
        try:
            reading, models = self._storage.files.reading(fit_place(fit_id)), self._models.of_fits([fit_id])
            with reading as folder, models as model:
                job = (fit_id, folder, model, question)
                found: dict[str, Any] = self._processes.result(fit_id, read_and_live_pattern, job, WALL_S)
        finally:
            drop_if_deleted(self._storage, self._processes, fit_id)
        return found

"""Which landmarks of a fit to check for the lines that are shown on it: its patient's plan, or its own drawing.

Made in a process of its own and remembered in memory for each version of the plan and each set of cuts by hand; a plan
may come from other scans.
"""

from typing import Any

from breastrig.execution.pool import TaskQueue
from breastrig.service.failed_tasks import explained
from breastrig.service.kept_models import KeptModels
from breastrig.service.plans import Plans
from breastrig.service.remembered import Remembered
from breastrig.storage.documents.fits import get_fit, shown_cuts
from breastrig.storage.documents.scans import Cuts, cuts_digest
from breastrig.storage.files import fit_place
from breastrig.storage.storage import Storage
from breastrig.use.lines.checks_on_fit import ChecksJob, checks_on_fit

WALL_S = 60.0  # a tenth of a second, of a huge scan on a busy machine many times that
REMEMBERED = 128  # of a kilobyte each


class LineChecks:
    """The checks of all fits.  May be called from any thread."""

    def __init__(self, storage: Storage, processes: TaskQueue, plans: Plans, models: KeptModels) -> None:
        self._storage, self._processes, self._plans, self._models = storage, processes, plans, models
        self._remembered: Remembered[dict[str, Any]] = Remembered(REMEMBERED)

    def on_fit(self, fit_id: str) -> dict[str, Any]:
        """The answer of api/wire/checks.py.  Raises a BreastRigError with a sentence, NotFound for a deleted fit."""
        planned, cuts = self._plans.of_fit(fit_id), shown_cuts(self._storage, get_fit(self._storage, fit_id))
        return self._remembered.result((planned.key, cuts_digest(cuts)), lambda: self._made(fit_id, cuts))

    def forget(self) -> None:
        """Clears the cache after a deletion."""
        self._remembered.forget()

    def _made(self, fit_id: str, cuts: Cuts) -> dict[str, Any]:
        plan = self._plans.lines_on_fit(fit_id)
        with (
            explained("Finding checks", WALL_S, "give a smaller scan", self._storage, [fit_id]),
            self._models.of_fits([fit_id]) as model,
        ):
            job = ChecksJob(self._storage.files.folder(fit_place(fit_id)), plan, model, cuts)
            return self._processes.result(checks_on_fit, (job,), WALL_S)

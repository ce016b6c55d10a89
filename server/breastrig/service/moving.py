"""Interactive changes: patterns, and finished fits that follow dragged landmarks.

Each fit has a process that is kept for it a while: its prepared data are of one patient's body, so they are in no other
process's memory and on no disk, and go with the deletion of the scan. Nothing is stored: the result of a drag is a fit
or a plan like any other, which is requested when it has ended.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from breastrig.cases.fits import FitEntry, find_fit
from breastrig.core.errors import BadInput, Conflict, NotFound
from breastrig.core.picks import Points
from breastrig.execution.pool import TaskQueue
from breastrig.service.failed_tasks import explained
from breastrig.service.kept_models import KeptModels
from breastrig.storage.documents.fits import StoredFit, get_fit
from breastrig.storage.files import fit_place
from breastrig.storage.storage import Storage
from breastrig.use.cases.case_work import job_of
from breastrig.use.moving.live_pattern import LengthsQuestion, LiveQuestion, live_pattern, read_and_live_pattern
from breastrig.use.moving.moved_landmarks import follow_landmarks, moved_landmarks

WALL_S = 90.0  # an answer takes a tenth of a second, the first one; huge scans on a slow or busy machine take many


class Moving:
    """Interactive changes of all fits. May be called from any thread."""

    def __init__(self, storage: Storage, processes: TaskQueue, models: KeptModels) -> None:
        self._storage, self._processes, self._models = storage, processes, models

    def pattern(self, fit_id: str, question: LiveQuestion | LengthsQuestion) -> dict[str, Any]:
        """The pattern on the fit's scan, with its handles; or lengths along its skin.

        Raises NotFound, Conflict when the fit is not done, BadDrawing when the pattern does not fit there, TooMany.
        """
        self._done(fit_id, "patterns and lengths need fits that are done")
        with explained("Drawing this pattern", WALL_S, "give a smaller scan", self._storage, [fit_id]):
            found = self._processes.result(live_pattern, (fit_id, question), WALL_S, fit_id)
            if found is not None:
                return found
            with self.dropped_if_deleted(fit_id), self._models.of_fits([fit_id]) as model:
                job = (fit_id, self._storage.files.folder(fit_place(fit_id)), model, question)
                return self._processes.result(read_and_live_pattern, job, WALL_S, fit_id)

    def landmarks(self, fit_id: str, landmarks: Points) -> dict[str, Any]:
        """The pose of a fit's model with landmarks (mm, scan frame) that were moved.

        Raises NotFound, Conflict when the fit is not done, TooMany, and FitFailed with a sentence.
        """
        fit = self._done(fit_id, "landmarks can be moved live on fits that are done")
        if fit.predicted_from is not None:
            raise BadInput("This body is predicted: move landmarks of the scan that it comes from, and predict again.")
        with explained("Following this landmark", WALL_S, "fit anew instead", self._storage, [fit_id]):
            found = self._processes.result(moved_landmarks, (fit_id, landmarks), WALL_S, fit_id)
            if found is not None:
                return found
            case, scan_id = self._storage.case_of_fit(fit_id)
            entry = find_fit(case, fit_id)
            going_on = {"stance": fit.stance, "drawing": None, "start_from": fit_id}
            with self.dropped_if_deleted(fit_id), self._models.of_fits([fit_id]) as model:
                job = job_of(case, scan_id, entry.document.model_copy(update=going_on), case.path, model)
                asked = (fit_id, job, _not_followed(entry), landmarks)
                return self._processes.result(follow_landmarks, asked, WALL_S, fit_id)

    def _done(self, fit_id: str, why: str) -> StoredFit:
        fit = get_fit(self._storage, fit_id)
        if fit.state != "done":
            raise Conflict(f"The fit {fit.id} is {fit.state}; {why}.")
        return fit

    @contextmanager
    def dropped_if_deleted(self, fit_id: str) -> Iterator[None]:
        """Around the reading of a fit: nothing stays in memory of one that is deleted meanwhile.  Raises NotFound."""
        try:
            yield
        finally:
            try:
                get_fit(self._storage, fit_id)
            except NotFound:
                self._processes.pool.drop(fit_id)
                raise


def _not_followed(fit: FitEntry) -> tuple[str, ...]:
    """The picks that a fit that is done has left out."""
    left_out = (fit.last or {}).get("result", {}).get("landmarks_not_followed", [])
    return tuple(name for each in left_out for name in each["names"])

"""Interactive changes: patterns, and finished fits that follow dragged landmarks.

Each fit has a process that is kept for it a while: its prepared data are of one patient's body, so they are in no other
process's memory and on no disk, and go with the deletion of the scan. Nothing is stored: the result of a drag is a fit
or a plan like any other, which is requested when it has ended.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from breastrig.core.errors import BadInput, Conflict, NotFound
from breastrig.core.picks import Points
from breastrig.execution.pool import Lane
from breastrig.service.failed_tasks import explained
from breastrig.service.fits.fit_worker import earlier_fit, fit_job
from breastrig.service.kept_models import KeptModels
from breastrig.storage.documents.events import event_of_kind
from breastrig.storage.documents.fits import FitRow, get_fit
from breastrig.storage.documents.scans import get_scan
from breastrig.storage.files import fit_place, scan_place
from breastrig.storage.storage import Storage
from breastrig.use.jobs import FollowJob, LengthsQuestion, LiveQuestion
from breastrig.use.steps.events import Done
from breastrig.use.tasks import follow_landmarks, live_pattern, moved_landmarks, read_and_live_pattern

WALL_S = 90.0  # an answer takes a tenth of a second, the first one; huge scans on a slow or busy machine take many


class Moving:
    """Interactive changes of all fits. May be called from any thread."""

    def __init__(self, storage: Storage, processes: Lane, models: KeptModels) -> None:
        self._storage, self._processes, self._models = storage, processes, models

    def pattern(self, fit_id: str, question: LiveQuestion | LengthsQuestion) -> dict[str, Any]:
        """The pattern on the fit's scan, with its handles; or lengths along its skin.

        Raises NotFound, Conflict when the fit is not done, BadDrawing when the pattern does not fit there, TooMany.
        """
        self._done(fit_id, "patterns and lengths need fits that are done")
        with explained("Drawing this pattern", WALL_S, "give a smaller scan", self._storage, [fit_id]):
            found: dict[str, Any] | None = self._processes.result(live_pattern, (fit_id, question), WALL_S, fit_id)
            if found is not None:
                return found
            with self.dropped_if_deleted(fit_id), self._models.of_fits([fit_id]) as model:
                job = (fit_id, self._storage.files.folder(fit_place(fit_id)), model, question)
                read: dict[str, Any] = self._processes.result(read_and_live_pattern, job, WALL_S, fit_id)
                return read

    def landmarks(self, fit_id: str, landmarks: Points) -> dict[str, Any]:
        """The pose of a fit's model with landmarks (mm, scan frame) that were moved.

        Raises NotFound, Conflict when the fit is not done, TooMany, and FitFailed with a sentence.
        """
        fit = self._done(fit_id, "landmarks can be moved live on fits that are done")
        if fit.predicted_from is not None:
            raise BadInput("This body is predicted: move landmarks of the scan that it comes from, and predict again.")
        with explained("Following this landmark", WALL_S, "fit anew instead", self._storage, [fit_id]):
            found: dict[str, Any] | None = self._processes.result(moved_landmarks, (fit_id, landmarks), WALL_S, fit_id)
            if found is not None:
                return found
            scan = get_scan(self._storage, fit.scan)
            folder = self._storage.files.folder(scan_place(scan.id))
            with self.dropped_if_deleted(fit_id), self._models.of_fits([fit_id]) as model:
                job = fit_job(scan, fit, folder, folder, model)
                job = replace(job, stance=fit.stance, drawing=None, earlier=earlier_fit(self._storage, fit_id))
                asked = (fit_id, FollowJob(job, self._not_followed(fit)), landmarks)
                read: dict[str, Any] = self._processes.result(follow_landmarks, asked, WALL_S, fit_id)
                return read

    def _done(self, fit_id: str, why: str) -> FitRow:
        fit = get_fit(self._storage, fit_id)
        if fit.state != "done":
            raise Conflict(f"The fit {fit.id} is {fit.state}; {why}.")
        return fit

    def _not_followed(self, fit: FitRow) -> tuple[str, ...]:
        done = event_of_kind(self._storage, fit.id, "done")
        assert done is not None
        result = Done.model_validate_json(done.json).result
        return tuple(name for each in result.landmarks_not_followed for name in each.names)

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

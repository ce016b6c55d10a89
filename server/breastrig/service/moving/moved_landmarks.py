"""Finished fits that follow landmarks while somebody drags them: each fit in a process of its own, kept for a while.

Nothing is stored: what comes of a drag is a fit like any other, which is asked for when it has ended.
"""

import json
from dataclasses import replace
from typing import Any

from breastrig.core.errors import Conflict
from breastrig.execution.kept_processes import KeptProcesses
from breastrig.service.failed_tasks import explained
from breastrig.service.fit_worker import earlier_fit, fit_job
from breastrig.service.kept_models import KeptModels
from breastrig.service.moving.deleted_fits import drop_if_deleted
from breastrig.storage.files import scan_place, upload_name
from breastrig.storage.rows.events import events_of_kind
from breastrig.storage.rows.fits import FitRow, get_fit
from breastrig.storage.rows.scans import Points, get_scan
from breastrig.storage.storage import Storage
from breastrig.workflow.jobs import FollowJob
from breastrig.workflow.tasks import follow_landmarks, moved_landmarks

WALL_S = 30.0  # an answer takes a twentieth of a second, the first one; huge scans on a slow machine take many


class MovedLandmarks:
    """May be called from any thread."""

    def __init__(self, storage: Storage, processes: KeptProcesses, models: KeptModels) -> None:
        self._storage = storage
        self._processes = processes
        self._models = models

    def moved(self, fit_id: str, landmarks: Points) -> dict[str, Any]:
        """Where the model of a fit lies with landmarks (mm, scan frame) that were moved.

        Raises NotFound, Conflict when the fit is not done, TooMany, and FitFailed with a sentence.
        """
        fit = get_fit(self._storage, fit_id)
        if fit.state != "done":
            raise Conflict(f"The fit {fit.id} is {fit.state}; landmarks can be moved live on fits that are done.")
        with explained("Following this landmark", WALL_S, "fit anew instead", self._storage, [fit_id]):
            found: dict[str, Any] | None = self._processes.result(fit_id, moved_landmarks, (fit_id, landmarks), WALL_S)
            return self._read_and_moved(fit, landmarks) if found is None else found

    def _read_and_moved(self, fit: FitRow, landmarks: Points) -> dict[str, Any]:
        scan = get_scan(self._storage, fit.scan)
        reading = self._storage.files.reading(scan_place(scan.id), [upload_name(scan.file_type)])
        with reading as folder, self._models.of_fits([fit.id]) as model:
            job = fit_job(scan, fit, folder, folder, model)
            job = replace(job, stance=fit.stance, drawing=None, earlier=earlier_fit(self._storage, fit.id))
            asked = (fit.id, FollowJob(job, self._not_followed(fit)), landmarks)
            try:
                found: dict[str, Any] = self._processes.result(fit.id, follow_landmarks, asked, WALL_S)
            finally:
                drop_if_deleted(self._storage, self._processes, fit.id)
        return found

    def _not_followed(self, fit: FitRow) -> tuple[str, ...]:
        (done,) = events_of_kind(self._storage, fit.id, "done")
        doubted = json.loads(done.json)["result"].get("landmarks_not_followed", [])
        return tuple(name for each in doubted for name in each["names"])

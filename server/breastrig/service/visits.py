"""A patient's visits over time: made in a process of its own from the newest fit of each scan, remembered in memory."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from breastrig.execution.pool import TaskQueue
from breastrig.service.failed_tasks import explained
from breastrig.service.kept_models import KeptModels
from breastrig.service.remembered import Remembered
from breastrig.storage.documents.scans import cuts_digest
from breastrig.storage.storage import Storage
from breastrig.use.cases.visits import visits_job
from breastrig.use.visits.over_time import VisitsJob, change_map_of, visits_json_of, visits_svg_of

REMEMBERED = 32
WALL_S = 180.0  # six visits take some five seconds


class Visits:
    """The visits of all patients.  May be called from any thread."""

    def __init__(self, storage: Storage, processes: TaskQueue, models: KeptModels) -> None:
        self._storage = storage
        self._processes = processes
        self._models = models
        self._remembered: Remembered[bytes] = Remembered(REMEMBERED)

    def document(self, patient_id: str) -> bytes:
        """The document breastrig/visits@1.  Raises a BreastRigError with a sentence, NotFound."""
        return self._made(patient_id, "json", visits_json_of)

    def plots(self, patient_id: str, stance: str, language: str) -> bytes:
        """Measures over the visits in one stance, SVG.  Raises likewise."""
        make = partial(visits_svg_of, stance=stance, language=language)
        return self._made(patient_id, f"svg {stance} {language}", make)

    def change(self, patient_id: str, scans: tuple[str, str], kind: str) -> bytes:
        """The map between two scans, "png", "glb" or "ply".  Raises likewise."""
        return self._made(patient_id, f"{kind} {scans}", partial(change_map_of, scans=scans, kind=kind))

    def forget(self) -> None:
        """Clears the cache after a deletion."""
        self._remembered.forget()

    def _made(self, patient_id: str, what: str, make: Callable[[VisitsJob], bytes]) -> bytes:
        job = visits_job(self._storage.case(patient_id), self._models.choice)
        ids = [fit.fit.name for fit in job.fits]

        def run() -> bytes:
            failing = explained("This comparison", WALL_S, "fit smaller scans", self._storage, ids)
            with failing, self._models.of_fits(ids) as model:
                return self._processes.result(make, (replace(job, model=model),), WALL_S)

        known = tuple((fit.fit.name, fit.date, fit.label, cuts_digest(fit.cuts)) for fit in job.fits)
        return self._remembered.result((patient_id, what, known, job.same), run)

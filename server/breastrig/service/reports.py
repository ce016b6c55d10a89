"""The service's reports: each made in a process of its own, the report of one fit made once and kept with its files.

A report of two stances is not kept: it would outlive the deletion of the other scan.  Nor is one with a plan, which
may have been carried from another scan: it is remembered for a while.
"""

import errno
import hashlib
import io
import logging
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from breastrig.core.errors import NotFound
from breastrig.execution.fair_processes import FairProcesses
from breastrig.service.failed_tasks import explained
from breastrig.service.plans import Plans
from breastrig.service.remembered import Remembered
from breastrig.service.single_flight import SingleFlight
from breastrig.storage.deletion import discard
from breastrig.storage.files import OpenedFile, fit_place
from breastrig.storage.rows.fits import get_fit
from breastrig.storage.rows.patients import patient_of_scan
from breastrig.storage.storage import Storage
from breastrig.workflow.further_jobs import ReportJob
from breastrig.workflow.tasks import measures_json_of, report_pdf_of

MAKERS: dict[str, Callable[[ReportJob], bytes]] = {"report.pdf": report_pdf_of, "measures.json": measures_json_of}
PLANNED = ("report.pdf",)  # what shows the plan; measures are those of the body
REMEMBERED = 8  # of half a megabyte
TWO_PATIENTS = (
    "The two scans are filed as those of two patients: what changes between them says something only if both are hers; "
    "file them under one patient then."
)
WALL_S = 60.0  # two stances take about four seconds; a slow machine with huge scans may take many

log = logging.getLogger(__name__)


class Reports:
    """The reports of all fits.  May be called from any thread."""

    def __init__(self, storage: Storage, processes: FairProcesses, plans: Plans, model: Path | None) -> None:
        self._storage = storage
        self._plans = plans
        self._processes = processes
        self._model = model
        self._flights: SingleFlight[bytes] = SingleFlight()
        self._remembered = Remembered(REMEMBERED)

    def pdf(self, fit_id: str, other_id: str | None) -> bytes:
        """The pages of a fit that is done, or of it and another one.

        Raises a BreastRigError with a sentence, NotFound when a fit was deleted meanwhile.
        """
        return self._kept_or_made("report.pdf", fit_id, other_id)

    def forget(self) -> None:
        """Nothing is remembered any more: a scan is deleted."""
        self._remembered.forget()

    def pdf_file(self, fit_id: str) -> OpenedFile:
        """The PDF of one fit as the file that is kept with it: for visitors, who may come often and read slowly.

        Raises as `pdf`, and OSError when it cannot be kept.
        """
        name = "report.pdf"
        if self._plans.of_fit(fit_id).plan.version > 0:
            content = self._kept_or_made(name, fit_id, None)
            return OpenedFile(None, len(content), hashlib.sha256(content).hexdigest()[:32], lambda: io.BytesIO(content))
        if self._kept(name, fit_id) is None:
            self._flights.result(f"{fit_id}/{name}", lambda: self._made_and_kept(name, fit_id))
        kept = self._kept(name, fit_id)
        if kept is None:  # the log says why
            raise OSError(errno.ENOSPC, "a report cannot be kept")
        return kept

    def measures(self, fit_id: str, other_id: str | None) -> bytes:
        """The same numbers as JSON, the document breastrig/report@1.  Raises likewise."""
        return self._kept_or_made("measures.json", fit_id, other_id)

    def _kept_or_made(self, name: str, fit_id: str, other_id: str | None) -> bytes:
        planned = [self._plans.of_fit(one) for one in (fit_id, other_id) if one is not None and name in PLANNED]
        if planned and planned[0].plan.version > 0:
            key = (name, *(one.key for one in planned))
            content = self._remembered.get(key)
            if content is None:
                content = self._flights.result(repr(key), lambda: self._made(name, fit_id, other_id))
                self._remembered.put(key, content)
                try:
                    for one in planned:  # one that was deleted meanwhile leaves nothing here
                        get_fit(self._storage, one.fit.id)
                except NotFound:
                    self.forget()
                    raise
            return content
        if other_id is not None:
            return self._made(name, fit_id, other_id)
        kept = self._kept(name, fit_id)
        if kept is not None:
            with kept.open() as file:
                return file.read()
        return self._flights.result(f"{fit_id}/{name}", lambda: self._made_and_kept(name, fit_id))

    def _made_and_kept(self, name: str, fit_id: str) -> bytes:
        kept = self._kept(name, fit_id)
        if kept is not None:  # it was made between looking and coming here
            with kept.open() as file:
                return file.read()
        content = self._made(name, fit_id, None)
        self._keep(name, fit_id, content)
        return content

    def _kept(self, name: str, fit_id: str) -> OpenedFile | None:
        return self._storage.files.find(fit_place(fit_id), name)

    def _keep(self, name: str, fit_id: str, content: bytes) -> None:
        """Raises NotFound when the fit was deleted meanwhile; then nothing is left of the report."""
        try:
            self._storage.files.write(fit_place(fit_id), name, content)
        except OSError as error:  # on the disk also because the folder is gone
            log.warning("a report cannot be kept (%s)", error.strerror)
        try:
            get_fit(self._storage, fit_id)
        except NotFound:
            discard(self._storage, fit_id, fit_place(fit_id))
            raise

    def _made(self, name: str, fit_id: str, other_id: str | None) -> bytes:
        ids = [one for one in (fit_id, other_id) if one is not None]
        with explained("This report", WALL_S, "fit a smaller scan", self._storage, ids), ExitStack() as stack:
            folders = [stack.enter_context(self._storage.files.reading(fit_place(one))) for one in ids]
            plans = tuple(self._plans.lines_on_fit(one) for one in (ids if name in PLANNED else ()))
            patients = {patient_of_scan(self._storage, get_fit(self._storage, one).scan) for one in ids}
            notes = () if len(patients) == 1 else (TWO_PATIENTS,)
            job = ReportJob(folders[0], None if other_id is None else folders[1], self._model, plans, notes=notes)
            content: bytes = self._processes.result(MAKERS[name], (job,), WALL_S)
        return content

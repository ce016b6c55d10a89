"""The service's reports: each made in a process of its own, the report of one fit kept with its files.

A report of two stances is not kept: it would outlive the deletion of the other scan.
"""

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

from breastrig.core.errors import BreastRigError, FitFailed
from breastrig.jobs.fit_files import write_whole
from breastrig.jobs.processes import Processes
from breastrig.jobs.report import ReportJob, measures_json_of, report_pdf_of
from breastrig.storage.fits import get_fit
from breastrig.storage.storage import Storage

MAKERS: dict[str, Callable[[ReportJob], bytes]] = {"report.pdf": report_pdf_of, "measures.json": measures_json_of}
WALL_S = 60.0  # two stances take about four seconds; a slow machine with huge scans may take many

log = logging.getLogger(__name__)


class Reports:
    """The reports of all fits.  May be called from any thread."""

    def __init__(self, storage: Storage, processes: Processes, model: Path | None) -> None:
        self._storage = storage
        self._processes = processes
        self._model = model

    def pdf(self, fit_id: str, other_id: str | None) -> bytes:
        """The two pages of a fit that is done, or of it and another one.

        Raises a BreastRigError with a sentence, NotFound when a fit was deleted meanwhile.
        """
        return self._kept_or_made("report.pdf", fit_id, other_id)

    def measures(self, fit_id: str, other_id: str | None) -> bytes:
        """The same numbers as JSON, the document breastrig/report@1.  Raises likewise."""
        return self._kept_or_made("measures.json", fit_id, other_id)

    def _kept_or_made(self, name: str, fit_id: str, other_id: str | None) -> bytes:
        kept = self._storage.folders.fit(fit_id) / name
        if other_id is None and kept.is_file():
            return kept.read_bytes()
        content = self._made(name, fit_id, other_id)
        if other_id is None:
            try:
                write_whole(kept, content)
            except OSError as error:
                get_fit(self._storage, fit_id)  # deleted: its folder is gone
                log.warning("a report cannot be kept (%s)", error.strerror)
        return content

    def _made(self, name: str, fit_id: str, other_id: str | None) -> bytes:
        folders = self._storage.folders
        other = None if other_id is None else folders.fit(other_id)
        future: Any = self._processes.schedule(
            MAKERS[name], (ReportJob(folders.fit(fit_id), other, self._model),), WALL_S
        )
        try:
            content: bytes = future.result()
        except BreastRigError:
            for known in (fit_id, other_id):
                if known is not None:
                    get_fit(self._storage, known)
            raise
        except TimeoutError as error:
            raise FitFailed(f"This report took longer than {WALL_S:g} s; fit a smaller scan.") from error
        except (OSError, RuntimeError) as error:
            log.warning("the process that made a report died: %r", error)
            raise FitFailed("This report needs more memory than it may use; fit a smaller scan.") from error
        return content

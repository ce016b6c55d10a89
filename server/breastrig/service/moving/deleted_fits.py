"""Fits that are deleted while a kept process reads them: nothing of them stays in memory."""

from breastrig.core.errors import NotFound
from breastrig.execution.kept_processes import KeptProcesses
from breastrig.storage.rows.fits import get_fit
from breastrig.storage.storage import Storage


def drop_if_deleted(storage: Storage, processes: KeptProcesses, fit_id: str) -> None:
    """To be called when a process has read the fit, or failed to.  Raises NotFound when the fit is gone."""
    try:
        get_fit(storage, fit_id)
    except NotFound:
        processes.drop(fit_id)
        raise

"""Where a fit runs best: in the process that is kept for its scan."""

from collections.abc import Callable
from typing import Any

from breastrig.core.errors import NotFound
from breastrig.execution.warm_first import ForKey
from breastrig.service.fit_worker import execute_fit
from breastrig.storage.rows.fits import get_fit
from breastrig.storage.storage import Storage


def fit_task(storage: Storage, fit_id: str) -> Callable[..., Any]:
    """`execute_fit`, for the process of the fit's scan; two stances together are left to any."""
    try:
        fit = get_fit(storage, fit_id)
    except NotFound:  # deleted in the meantime, which the task will see
        return execute_fit
    return execute_fit if len(fit.both) > 1 else ForKey(fit.scan, execute_fit)

"""The sentence for a failed task on finished fits; a deleted fit is reported first."""

import errno
import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from breastrig.core.errors import BreastRigError, FitFailed
from breastrig.storage.documents.fits import get_fit
from breastrig.storage.storage import Storage

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EIO)

log = logging.getLogger(__name__)


@contextmanager
def explained(what: str, wall_s: float, advice: str, storage: Storage, fit_ids: Sequence[str]) -> Iterator[None]:
    """Around a task in a process of its own, which takes `wall_s` at most and reads the files of these fits.

    Raises the task's own BreastRigError, FitFailed where it was too slow or its process died, NotFound when a fit was
    deleted meanwhile, OSError for a full or broken disk.  `what` begins the sentence ("This report"), `advice` ends it
    ("give smaller scans").
    """
    try:
        yield
    except (BreastRigError, OSError, RuntimeError) as error:  # TimeoutError is an OSError
        for fit_id in fit_ids:
            get_fit(storage, fit_id)
        if isinstance(error, BreastRigError) or getattr(error, "errno", None) in FULL:
            raise
        if isinstance(error, TimeoutError):
            raise FitFailed(f"{what} took longer than {wall_s:g} s; {advice}.") from error
        log.warning("the process of a task died: %r", error)
        raise FitFailed(f"{what} needs more memory than it may use; {advice}.") from error

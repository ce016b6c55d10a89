"""Who carries a fit out: so that whoever deletes it can wait until nothing more is written.

On the disk it is a lock of the fit's folder, which the system releases when the process dies.  With PostgreSQL it
is a lock of the database, because the process may be on another machine.
"""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Protocol, runtime_checkable

from breastrig.storage.folders import Folders


@runtime_checkable
class Locks(Protocol):
    def held(self, fit_id: str) -> AbstractContextManager[None]:
        """Marks the fit as being executed, until the block ends or the process dies; waits for who has it."""

    def wait_until_free(self, fit_id: str, timeout_s: float) -> bool:
        """Whether nobody carries the fit out any more, waiting for that a little."""


class FolderLocks:
    """Locks of the fits' folders."""

    def __init__(self, folders: Folders) -> None:
        self._folders = folders

    @contextmanager
    def held(self, fit_id: str) -> Iterator[None]:
        """Raises FileNotFoundError when the fit was deleted."""
        with self._folders.held(self._folders.fit(fit_id)):
            yield

    def wait_until_free(self, fit_id: str, timeout_s: float) -> bool:
        return self._folders.wait_until_free(self._folders.fit(fit_id), timeout_s)

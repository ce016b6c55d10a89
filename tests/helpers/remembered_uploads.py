"""Uploads that this run has read before are not read again: the same bytes for the same model have the same facts.

Most tests of the service upload one of a few scans first, and reading one takes more work than all that they ask about.
What is remembered was read by the service's own reader in its own process, see remembered.py.  A service remembers
while `remember_uploads` or `remembering_uploads` has its process do so; what its tasks compute is remembered too.

Processes of tasks import this file too, so that what only a service or a first reading needs is imported there.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from breastrig.execution.worker import preload
from breastrig.use.read_upload import UploadJob
from helpers.remembered import key_of_job, once

WRITTEN = ("kept", "mesh", "thumbnail", "volume")


def remember_uploads() -> None:
    """For all services of this process from now on."""
    from breastrig.service.scans import uploads

    uploads.read_upload = read_upload_once
    preload([__name__])


@contextmanager
def remembering_uploads() -> Iterator[None]:
    """The same inside the block."""
    from breastrig.service.scans import uploads

    before = uploads.read_upload
    remember_uploads()
    try:
        yield
    finally:
        uploads.read_upload = before


def read_upload_once(job: UploadJob) -> dict[str, Any]:
    """As `read_upload`, whose answer and files are given again when it has read the same before."""
    facts, files = once(key_of_job("upload", job), lambda: _read(job))
    for name, content in files.items():
        getattr(job, name).write_bytes(content)
    return dict(facts)


def _read(job: UploadJob) -> tuple[dict[str, Any], dict[str, bytes]]:
    from breastrig.use.read_upload import read_upload

    facts = read_upload(job)
    return facts, {name: place.read_bytes() for name in WRITTEN if (place := getattr(job, name)).exists()}

"""Uploads that this run has read before are not read again: the same bytes for the same model have the same facts.

Most tests of the service upload one of a few scans first, and reading one takes more work than all that they ask about.
What is remembered was read by the service's own reader in its own process, see remembered.py.  A service remembers
while `remember_uploads` or `remembering_uploads` has its process do so; what its tasks compute is remembered too.
Inside `remembering_uploads` no process is asked for what is known.

Processes of tasks import this file too, so that what only a service or a first reading needs is imported there.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from breastrig.execution.worker import preload
from breastrig.use.read_upload import UploadJob
from helpers.remembered import FOLDER, changed, kept, key_of_job, once

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

    read_upload, read = uploads.read_upload, uploads.Uploads._read

    def read_here(service: Any, scan_id: str, job: UploadJob) -> dict[str, Any]:
        if uploads.read_upload is read_upload_once and FOLDER in os.environ and not changed:
            known = kept(key_of_job("upload", job))
            if known is not None:
                return _again(job, *known[0])
        return read(service, scan_id, job)

    remember_uploads()
    uploads.Uploads._read = read_here  # type: ignore[method-assign]
    try:
        yield
    finally:
        uploads.read_upload, uploads.Uploads._read = read_upload, read  # type: ignore[method-assign]


def read_upload_once(job: UploadJob) -> dict[str, Any]:
    """As `read_upload`, whose answer and files are given again when it has read the same before."""
    return _again(job, *once(key_of_job("upload", job), lambda: _read(job)))


def _again(job: UploadJob, facts: dict[str, Any], files: dict[str, bytes]) -> dict[str, Any]:
    for name, content in files.items():
        getattr(job, name).write_bytes(content)
    return dict(facts)


def _read(job: UploadJob) -> tuple[dict[str, Any], dict[str, bytes]]:
    from breastrig.use.read_upload import read_upload

    facts = read_upload(job)
    return facts, {name: place.read_bytes() for name in WRITTEN if (place := getattr(job, name)).exists()}

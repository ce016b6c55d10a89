"""Uploads that this run has read before are not read again: the same bytes for the same model have the same facts.

Most tests of the service upload one of a few scans first, and reading one takes more work than all that they ask about.
What is remembered was read by the service's own reader in its own process; files lie in FOLDER, where processes of all
tests find them.  A service remembers while `remember_uploads` or `remembering_uploads` has its process do so.

Processes of tasks import this file too, so that what only a service or a first reading needs is imported there.
"""

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from breastrig.core.assets import asset_folder
from breastrig.execution.worker import preload
from breastrig.use.read_upload import UploadJob

FOLDER = "BREASTRIG_REMEMBERED_UPLOADS"  # environment; without it nothing is remembered


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
    """As `read_upload`, whose answer and files are copied when it has read the same before."""
    if FOLDER not in os.environ:
        return _read(job)
    known = Path(os.environ[FOLDER], _key(job))
    if not known.is_dir():
        _keep(job, _read(job), known)
    shutil.copyfile(known / "kept", job.kept)
    shutil.copyfile(known / "mesh", job.mesh)
    shutil.copyfile(known / "thumbnail", job.thumbnail)
    found: dict[str, Any] = json.loads((known / "facts").read_text("utf-8"))
    return found


def _read(job: UploadJob) -> dict[str, Any]:
    from breastrig.use.read_upload import read_upload

    return read_upload(job)


def _key(job: UploadJob) -> str:
    """Of everything that the answer depends on."""
    total = hashlib.sha256(f"{job.scan.suffix} {job.units} {job.triangles} {job.answers} ".encode())
    model = job.model or asset_folder("model") / "torso.glb"
    for file in (model, model.with_suffix(".json"), job.scan):
        total.update(hashlib.sha256(file.read_bytes()).digest())
    return total.hexdigest()


def _keep(job: UploadJob, facts: dict[str, Any], known: Path) -> None:
    """Whole or not at all; others may be doing the same."""
    known.parent.mkdir(parents=True, exist_ok=True)
    place = Path(tempfile.mkdtemp(dir=known.parent))
    shutil.copyfile(job.kept, place / "kept")
    shutil.copyfile(job.mesh, place / "mesh")
    shutil.copyfile(job.thumbnail, place / "thumbnail")
    (place / "facts").write_text(json.dumps(facts), "utf-8")
    try:
        place.rename(known)
    except OSError:
        shutil.rmtree(place)

"""Landmarks that this run has proposed before are not searched for again: the same scan has the same proposals.

Files lie beside the remembered uploads.  Tests of the proposals themselves do not use this.
"""

import hashlib
import json
import os
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

from breastrig.core.assets import asset_folder
from breastrig.use.landmarks import ProposeJob
from helpers.remembered_uploads import FOLDER


def propose_once(job: ProposeJob) -> dict[str, Any]:
    """As `propose_on_file`."""
    from breastrig.use.landmarks import propose_on_file

    if FOLDER not in os.environ:
        return propose_on_file(job)
    known = Path(os.environ[FOLDER], _key(job))
    if known.is_file():
        return dict(json.loads(known.read_text("utf-8")))
    found = propose_on_file(job)
    known.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile("w", dir=known.parent, encoding="utf-8", delete=False) as file:
        json.dump(found, file)
    Path(file.name).replace(known)
    return found


def _key(job: ProposeJob) -> str:
    """Of everything that the proposals depend on."""
    total = hashlib.sha256(b"proposals")
    total.update(repr(replace(job, scan=Path())).encode())
    model = job.model or asset_folder("model") / "torso.glb"
    for file in (model, model.with_suffix(".json"), job.scan):
        total.update(hashlib.sha256(file.read_bytes()).digest())
    return total.hexdigest()

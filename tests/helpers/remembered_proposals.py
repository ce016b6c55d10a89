"""Landmarks that were proposed on a scan before in this run are not looked for again: the same scan has the same ones.

The page asks for them whenever a scan is opened, which nearly every browser test does with the same one.  What is
remembered was found by the service's own function in its own process.
"""

import hashlib
import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from breastrig.core.assets import asset_folder
from breastrig.workflow.propose_on_scan import ProposeJob, propose_on_file
from helpers.remembered_uploads import FOLDER


def propose_once(job: ProposeJob) -> dict[str, Any]:
    """As `propose_on_file`."""
    if FOLDER not in os.environ:
        return propose_on_file(job)
    known = Path(os.environ[FOLDER], _key(job))
    if not known.is_file():
        found = propose_on_file(job)
        known.parent.mkdir(parents=True, exist_ok=True)
        making = known.with_suffix(f".{os.getpid()}")
        making.write_text(json.dumps(found), "utf-8")
        making.rename(known)
    again: dict[str, Any] = json.loads(known.read_text("utf-8"))
    return again


def _key(job: ProposeJob) -> str:
    """Of everything that the answer depends on."""
    total = hashlib.sha256(f"proposals {replace(job, scan=Path())!r}".encode())
    model = job.model or asset_folder("model") / "torso.glb"
    for file in (model, model.with_suffix(".json"), job.scan):
        total.update(hashlib.sha256(file.read_bytes()).digest())
    return total.hexdigest()

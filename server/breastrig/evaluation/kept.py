"""Finished cases on disk, so that an evaluation that was broken off goes on where it was.

DIR/cases/PRESET/PATIENT--STANCE.json holds a case's numbers beside the key of what they were made from (bytes of
scan, landmarks and truth, model, preset, plan, program version), the .npz beside it the fitted vertices.  A file
with another key counts as absent.
"""

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadInput
from breastrig.evaluation.cohort import Case

SCHEMA = "breastrig/evaluated-case@1"


@dataclass(frozen=True)
class Kept:
    """The folder of finished cases."""

    folder: Path

    def _path(self, case: Case, preset: str) -> Path:
        return self.folder / preset / f"{case.patient}--{case.name}.json"

    def load(self, case: Case, preset: str, key: str) -> dict[str, Any] | None:
        """The numbers, or None when they are not there or were made from something else."""
        path = self._path(case, preset)
        try:
            document = json.loads(path.read_text("utf-8"))
            found = document["schema"] == SCHEMA and document["key"] == key
            return dict(document["numbers"]) if found else None
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def save(self, case: Case, preset: str, key: str, numbers: dict[str, Any], vertices: Array | None) -> None:
        """Writes whole or not at all; vertices (V, 3) m in the scan's own frame."""
        path = self._path(case, preset)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            if vertices is not None:
                with open(path.with_suffix(".part"), "wb") as stream:
                    np.savez_compressed(stream, vertices_m=vertices)
                os.replace(path.with_suffix(".part"), path.with_suffix(".npz"))
            document = {"schema": SCHEMA, "key": key, "numbers": numbers}
            path.with_suffix(".part").write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", "utf-8")
            os.replace(path.with_suffix(".part"), path)
        except OSError as error:
            raise BadInput(
                f"{path} cannot be written ({error.strerror}); free space or choose another folder."
            ) from error

    def vertices(self, case: Case, preset: str) -> Array:
        """(V, 3) m, the fitted surface in the scan's own frame."""
        with np.load(self._path(case, preset).with_suffix(".npz")) as archive:
            return np.asarray(archive["vertices_m"], dtype=np.float64)

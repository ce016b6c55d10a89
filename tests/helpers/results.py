"""result.json of a fit that found nothing, for tests that need one without a fit."""

import json
from datetime import date
from pathlib import Path
from typing import Any

from breastrig.core.documents import json_bytes
from breastrig.files.result import DRAWING, HASHED, RESULT, ResultFile, patient_of, read_result

NOTHING = {"mean": None, "std": None, "max": None, "p95": None}
TO_LANDMARKS = {"mean": None, "std": None, "max": None, "min": None, "each": {}}


def result_document(**changes: Any) -> dict[str, Any]:
    """The document with these entries; of the scan, the model and the verdict what is named of them."""
    plain: dict[str, Any] = {
        "schema": "breastrig/result@1",
        "scan": {"vertices": 204, "triangles": 384, "unit": "mm", "sha256": "ab" * 32},
        "model": {"name": "toy", "sha256": "cd" * 32, "vertices": 204, "bones": 4, "blendshapes": 4},
        "stance": "standing",
        "stance_reason": "As asked for.",
        "preset": "default",
        "refined": False,
        "converged": False,
        "stop_reason": "Stalled.",
        "iterations": 3,
        "timing_s": {"solve": 0.5, "total": 1.0},
        "surface_distance_mm": NOTHING | {"coverage": 0.0},
        "scan_to_model_mm": NOTHING,
        "landmark_distance_mm": TO_LANDMARKS,
        "landmarks": {},
        "landmarks_picked": {},
        "parameters": {"bones": [], "blendshapes": {}},
        "notes": [],
        "versions": {"breastrig": "0"},
    }
    nested = {name: plain[name] | value for name, value in changes.items() if name in ("scan", "model")}
    return plain | changes | nested


def result_file(**changes: Any) -> ResultFile:
    """The same as the package has it."""
    return ResultFile.model_validate(result_document(**changes))


def without_hashes(folder: Path) -> Path:
    """The folder of a fit as versions before hashes left it; its files may be changed then."""
    document = json.loads((folder / "result.json").read_text("utf-8"))
    assert document.pop("files")
    assert document.pop("fields")
    (folder / "result.json").write_text(json.dumps(document), "utf-8")
    return folder


def write_patient(folder: Path, code: str, scanned: date | None) -> str:
    """Gives a fit's folder a patient, as one that `breastrig fit` wrote has; the code."""
    patient = patient_of(code, scanned)
    result = read_result(folder).model_copy(update={"patient": patient})
    drawing = json.loads((folder / DRAWING).read_bytes()) | {"patient": patient.code}
    (folder / DRAWING).write_bytes(json_bytes(drawing))
    files = {name: (folder / name).read_bytes() for name in HASHED if result.files}
    (folder / RESULT).write_bytes((result.beside(files) if files else result).content())
    return patient.code

"""Whose a fit's folder is: the patient's code and the scan's day, which are in result.json."""

import json
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from breastrig.core.errors import BadInput
from breastrig.core.identity import CODE_CHARACTERS, random_code
from breastrig.core.private_files import read_ordinary, write_private
from breastrig.core.stances import Stance
from breastrig.workflow.folder.fit_file_names import RESULT
from breastrig.workflow.folder.fit_files import json_bytes
from breastrig.workflow.folder.fit_folder import RESULT_BYTES

PATIENT = "patient"  # key of result.json


class _Part(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True)


class _Patient(_Part):
    code: Annotated[str, Field(max_length=CODE_CHARACTERS)] = ""
    given: bool = False  # by a person; otherwise it is random
    scanned: date | None = None


class _Result(_Part):
    stance: Stance
    patient: _Patient = _Patient()


@dataclass(frozen=True)
class FolderPatient:
    """Of one fit."""

    stance: str
    code: str
    given: bool
    scanned: str  # ISO 8601 day; empty: not known


def write_patient(folders: list[Path], code: str, scanned: list[date | None]) -> str:
    """Writes the code, or a random one for all of them, into each folder's result.json; the code."""
    given = " ".join(code.split())[:CODE_CHARACTERS]
    chosen = given or random_code()
    for folder, day in zip(folders, scanned, strict=True):
        document: dict[str, Any] = json.loads((folder / RESULT).read_bytes())
        patient = {"code": chosen, "given": bool(given), **({"scanned": day.isoformat()} if day else {})}
        write_private(folder / RESULT, json_bytes(document | {PATIENT: patient}))
    return chosen


def patient_of(folder: Path) -> FolderPatient:
    """Whose fit it is; no code in results of other versions.  BadInput for a folder that is no fit."""
    try:
        result = _Result.model_validate_json(read_ordinary(folder / RESULT, RESULT_BYTES))
    except OSError as error:
        raise BadInput(f"There is no fit in {folder.name[:100]}; give a folder that `breastrig fit` wrote.") from error
    except ValidationError as error:
        raise BadInput(f"{folder.resolve().name}/result.json is damaged; fit the scan again.") from error
    day = result.patient.scanned
    return FolderPatient(
        result.stance, result.patient.code, result.patient.given, "" if day is None else day.isoformat()
    )

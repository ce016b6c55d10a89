"""A folder of virtual or real patients: PATIENT/STANCE/{scan.ply, landmarks.json, case.json, truth.ply}.

A coloured case has scan.zip (mesh, material, texture) instead of scan.ply, and ink.json, the true lines of ink; where
they lie in the other stance says ink_in_STANCE.json.  Colour is all that is measured of it.

case.json says the unit and the stance; truth.ply, the clean surface in the scan's frame, may be missing;
PATIENT/patient.json states the family, and of warped bodies whether their breasts hang.  Bodies that share their origin
with the template (MakeHuman) flatter it and are always reported apart from independent ones.
"""

import json
from dataclasses import dataclass
from pathlib import Path

from breastrig.core.errors import BadInput


@dataclass(frozen=True)
class Case:
    """One scan of one patient."""

    patient: str
    name: str  # of the stance's folder
    stance: str  # standing | supine
    family: str  # independent | makehuman
    unit: str
    folder: Path
    hanging: bool | None = None  # whether its breasts were made to hang; None: nobody says
    group: str = ""  # development | validation | test; empty: the cohort is not divided

    @property
    def held_out(self) -> bool:
        """Whether it is of the test set, which only `evaluate --test` reads."""
        return self.group == TEST

    @property
    def teaches(self) -> bool:
        """Whether numbers are estimated from it; the other groups measure the result."""
        return self.group not in (VALIDATION, TEST)

    @property
    def coloured(self) -> bool:
        """Whether its colours are measured."""
        return not (self.folder / PLAIN).is_file()

    @property
    def scan(self) -> Path:
        """The file of the scan."""
        return self.folder / (COLOURED if self.coloured else PLAIN)


PLAIN, COLOURED = "scan.ply", "scan.zip"
DEVELOPMENT, VALIDATION, TEST = GROUPS = ("development", "validation", "test")
EARLIER = {
    "choose": DEVELOPMENT,
    "report": VALIDATION,
    "sealed": VALIDATION,
}  # in folders of 0.2.0; the last were looked at seven times


def _document(path: Path) -> dict[str, object]:
    try:
        document = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise BadInput(f"{path} cannot be read as JSON; a cohort folder needs it.") from error
    if not isinstance(document, dict):
        raise BadInput(f"{path} must hold a JSON object.")
    return document


def _group(patient: dict[str, object], name: str) -> str:
    """The group that patient.json names, else the ending of the folder's name."""
    ending = name.rpartition("_")[2]
    group = str(patient.get("half", ending if ending in (*GROUPS, *EARLIER) else ""))
    return EARLIER.get(group, group)


def _hanging(patient: dict[str, object]) -> bool | None:
    """Whether a warped body was made with hanging breasts (virtual/warped/numbers.py); None where not recorded."""
    numbers = patient.get("numbers")
    if not isinstance(numbers, dict) or "nipples_over_folds" not in numbers:
        return None
    return numbers["nipples_over_folds"] is not None


def read_cohort(folder: Path) -> tuple[Case, ...]:
    """All cases of a cohort folder, in the order of their names; BadInput when there are none."""
    cases = []
    for place in sorted({scan.parent for name in (PLAIN, COLOURED) for scan in folder.glob(f"*/*/{name}")}):
        about = _document(place / "case.json")
        file = place.parent / "patient.json"
        patient = _document(file) if file.is_file() else {}
        if not (place / "landmarks.json").is_file():
            raise BadInput(f"{place} has no landmarks.json; every case of a cohort needs one.")
        cases.append(
            Case(
                patient=place.parent.name,
                name=place.name,
                stance=str(about.get("stance", place.name)),
                family="makehuman" if "makehuman" in json.dumps(patient).lower() else "independent",
                unit=str(about.get("unit", "auto")),
                folder=place,
                hanging=_hanging(patient),
                group=_group(patient, place.parent.name),
            )
        )
    if not cases:
        raise BadInput(f"{folder} holds no scans; a cohort has PATIENT/STANCE/scan.ply (or scan.zip) in it.")
    return tuple(cases)

"""Writes the virtual cohort in the form that `breastrig evaluate` reads."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from breastrig.core.version import __version__
from breastrig_studies.virtual.bodies import Bodies, VirtualPatient, read_bodies
from breastrig_studies.virtual.case_files import UNITS, write_case, write_json
from breastrig_studies.virtual.scan import scan_body

SEED = 20_261_121


def make_cohort(folder: Path, progress: Callable[[str], None], patients: Sequence[str] | None = None) -> None:
    """PATIENT/patient.json and PATIENT/STANCE/{scan.ply, landmarks.json, case.json, truth.ply} in the folder.

    The same bytes each time on one machine; `patients` names those wanted, all when None.  About a minute on
    one core for all seven in both stances.  Patients that are there already, of these bodies and this version, stay.
    """
    bodies = read_bodies()
    for index, patient in enumerate(bodies.patients):
        if patients is not None and patient.name not in patients:
            continue
        if not _is_there(folder / patient.name, bodies):
            _write_patient(folder / patient.name, bodies, patient, index, progress)


def _is_there(folder: Path, bodies: Bodies) -> bool:
    """patient.json is written last, so where it is and names the same maker, all is there."""
    try:
        about = json.loads((folder / "patient.json").read_text("utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(about, dict) and about.get("made_by") == _made_by(bodies)


def _made_by(bodies: Bodies) -> dict[str, str]:
    return {"breastrig": __version__, "bodies_sha256": bodies.sha256}


def _write_patient(
    folder: Path, bodies: Bodies, patient: VirtualPatient, index: int, progress: Callable[[str], None]
) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "patient.json").unlink(missing_ok=True)
    for number, body in enumerate(patient.bodies):
        random = np.random.default_rng((SEED, index, number))  # each scan its own: none depends on those before it
        scan = scan_body(bodies, body, random)
        unit = UNITS[(index + number) % len(UNITS)]
        write_case(folder / body.stance, body, bodies.faces, scan, unit, random, {"seed": [SEED, index, number]})
        progress(f"{patient.name} {body.stance}: {len(scan.faces)} triangles")
    write_json(
        folder / "patient.json",
        {"family": "makehuman", "virtual": True, "origin": bodies.origin, "licence": bodies.licence}
        | {key: value for key, value in patient.about.items() if key != "name"}
        | {"made_by": _made_by(bodies)},
    )

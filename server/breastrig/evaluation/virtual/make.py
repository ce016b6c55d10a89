"""Writes the virtual cohort in the form that `breastrig evaluate` reads."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from breastrig import __version__
from breastrig.core.arrays import Array, Integers
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.units import METRES_PER_UNIT
from breastrig.evaluation.virtual.bodies import Bodies, VirtualPatient, read_bodies
from breastrig.evaluation.virtual.scan import scan_body

SEED = 20_261_121
UNITS = ("m", "mm")  # by turns, so that both are read
SHIFT = 0.5  # m, how far from its origin a scan may lie


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
        placed = _placed(unit, random)
        place = folder / body.stance
        place.mkdir(parents=True, exist_ok=True)
        _write_ply(place / "scan.ply", _moved(scan.vertices, placed), scan.faces)
        _write_ply(place / "truth.ply", _moved(body.vertices, placed), bodies.faces)
        names = sorted(body.landmarks)
        places = np.array([body.landmarks[name] for name in names])
        gaps, _ = cKDTree(scan.vertices).query(places)
        _write_json(
            place / "landmarks.json",
            {
                "schema": "breastrig/landmarks@1",
                "unit": unit,
                "landmarks": {
                    name: [round(x, 6) for x in at]
                    for name, at in zip(names, _moved(places, placed).tolist(), strict=True)
                },
            },
        )
        _write_json(
            place / "case.json",
            {
                "unit": unit,
                "stance": body.stance,
                "body_mm_to_scan": (placed @ np.diag([1e-3, 1e-3, 1e-3, 1.0])).tolist(),
                "landmark_gap_mm": {
                    n: round(1e3 * float(gap), 1) for n, gap in zip(names, np.atleast_1d(gaps), strict=True)
                },
                "vertices": len(scan.vertices),
                "triangles": len(scan.faces),
                "scan_to_truth_mm": round(1e3 * scan.error, 3),
                "seed": [SEED, index, number],
                "notice": LIMITS_OF_USE,
            },
        )
        progress(f"{patient.name} {body.stance}: {len(scan.faces)} triangles")
    _write_json(
        folder / "patient.json",
        {"family": "makehuman", "virtual": True, "origin": bodies.origin, "licence": bodies.licence}
        | {key: value for key, value in patient.about.items() if key != "name"}
        | {"made_by": _made_by(bodies)},
    )


def _placed(unit: str, random: np.random.Generator) -> Array:
    """(4, 4) from body coordinates (m) into a scan's own frame and unit, turned and shifted at random."""
    result = np.eye(4)
    result[:3, :3] = Rotation.from_quat(random.standard_normal(4)).as_matrix()  # uniform over all
    result[:3, 3] = random.uniform(-SHIFT, SHIFT, 3)
    result[:3] /= METRES_PER_UNIT[unit]
    return result


def _moved(points: Array, placed: Array) -> Array:
    return np.asarray(points @ placed[:3, :3].T + placed[:3, 3])


def _write_ply(path: Path, vertices: Array, faces: Integers) -> None:
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    path.write_bytes(mesh.export(file_type="ply", include_attributes=False))


def _write_json(path: Path, content: dict[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=1) + "\n", "utf-8")

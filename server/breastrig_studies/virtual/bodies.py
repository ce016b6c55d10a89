"""The stored bodies of the virtual cohort: true skins and landmarks, no scans.

All patients share one mesh, so that a vertex is the same point of the skin in both stances (and the corresponding one
in all patients). model_assets/make_cohort.py writes the files.
"""

import hashlib
import io
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadInput
from breastrig.geometry.boundary import boundary_loops
from breastrig.geometry.surface_points import SurfacePoints

SCHEMA = "breastrig/virtual-cohort@1"

PACKAGE = Path(__file__).resolve().parents[1]


@dataclass(frozen=True, eq=False)
class VirtualBody:
    """One patient in one stance, in body coordinates (m, +X left, +Y head, +Z front)."""

    stance: str  # standing | supine
    vertices: Array  # (V, 3) m
    landmarks: dict[str, Array]  # (3,) m
    table: float | None  # m, z of the table under the back


@dataclass(frozen=True, eq=False)
class VirtualPatient:
    """One patient in both stances."""

    name: str
    about: dict[str, Any]  # size, age, measured girths and volumes
    bodies: tuple[VirtualBody, ...]


@dataclass(frozen=True, eq=False)
class Bodies:
    """All patients and the mesh that they share."""

    faces: Integers  # (F, 3), open at neck, arms and hips
    scanned: Booleans  # (V,) False on the forearms, which whoever scans crops
    origin: str
    licence: str
    sha256: str  # of bodies.npz
    patients: tuple[VirtualPatient, ...]


def cohort_folder() -> Path:
    """The folder of the seven virtual patients: in the installed package, or in the checkout."""
    packaged = PACKAGE / "assets" / "cohort"
    return packaged if packaged.is_dir() else PACKAGE.parent.parent / "model_assets" / "cohort"


def read_bodies(folder: Path | None = None) -> Bodies:
    """The bodies of the folder, or of the package's; BadInput when the files are not there or not of this kind."""
    folder = folder or cohort_folder()
    try:
        about = json.loads((folder / "patients.json").read_text("utf-8"))
        data = (folder / "bodies.npz").read_bytes()
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            stored = {name: archive[name] for name in archive.files}
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise BadInput(f"{folder} does not hold the virtual cohort (bodies.npz, patients.json): {error}") from error
    if about.get("schema") != SCHEMA:
        raise BadInput(f"{folder}/patients.json is of the schema {about.get('schema')!r}; this program reads {SCHEMA}.")
    vertices = float(stored["step_m"]) * stored["vertices"].astype(np.float64)
    faces = stored["faces"].astype(np.int64)
    sha256 = hashlib.sha256(data).hexdigest()
    patients = []
    for index, each in enumerate(about["patients"]):
        points = SurfacePoints(stored["landmark_faces"][index], stored["landmark_barycentric"][index])
        bodies = []
        for stance, skin in zip(about["stances"], vertices[index], strict=True):
            places = points.positions(skin, faces)
            landmarks = dict(zip(about["landmarks"], places, strict=True))
            table = float(stored["table_m"][index]) if stance == "supine" else None
            bodies.append(VirtualBody(stance, skin, landmarks, table))
        patients.append(VirtualPatient(each["name"], each, tuple(bodies)))
    return Bodies(faces, stored["scanned"], about["origin"], about["license"], sha256, tuple(patients))


def closed(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """The mesh with a lid over each opening appended, so that no camera looks into the body."""
    for loop in boundary_loops(faces):
        middle = np.full(len(loop), len(vertices))
        vertices = np.concatenate([vertices, vertices[loop].mean(axis=0, keepdims=True)])
        faces = np.concatenate([faces, np.stack([np.roll(loop, -1), loop, middle], axis=1)])
    return vertices, faces

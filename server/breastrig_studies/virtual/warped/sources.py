"""The bodies that are warped: the seven of the cohort and, where a folder of cases is given, its patients.

A source is one patient in both stances on one mesh, so that a vertex is the same point of the skin in both. All are
moved into the cohort's coordinates (navel and shoulders at the same place), because the simulated session is planned in
them. No source serves both halves: constants are chosen on one half and reported on the other.
"""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadInput
from breastrig.geometry.boundary import boundary_loops
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.surface_points import SurfacePoints
from breastrig_studies.virtual.bodies import read_bodies

DEVELOPMENT, VALIDATION = "development", "validation"
HALF_OF_PATIENT = {"patient_a": DEVELOPMENT, "patient_c": DEVELOPMENT, "patient_b": VALIDATION, "patient_d": VALIDATION}
NAVEL_HEIGHT, SHOULDER_DEPTH = 0.15, 0.032  # m, y of the navel and z of the acromia of the cohort's patients
CROPPED = 0.07  # m from the end of the arm, which whoever scans leaves out
ARM_AWAY = 0.19  # m from the midline; openings beyond are the arms' ends
TRUNK = 0.12  # m from the midline, where a lying back touches the table


@dataclass(frozen=True, eq=False)
class Lying:
    """The source on a table, in body coordinates."""

    kind: str  # supine | supine_physics
    vertices: Array  # (V, 3) m
    table: float  # m, z of the table


@dataclass(frozen=True, eq=False)
class Source:
    """One patient, standing and lying, in body coordinates (m, +X left, +Y head, +Z front)."""

    name: str
    half: str  # development | validation
    family: str  # makehuman | independent
    origin: str
    licence: str
    faces: Integers  # (F, 3)
    scanned: Booleans  # (V,) False on the forearms
    standing: Array  # (V, 3) m
    lying: tuple[Lying, ...]  # one or more models of the same patient lying down
    names: tuple[str, ...]  # of the landmarks
    points: SurfacePoints  # the landmarks, as points of the skin
    sha256: str

    def landmarks(self, vertices: Array) -> dict[str, Array]:
        """(3,) m by name: the landmarks of this skin with other vertices (V, 3)."""
        return dict(zip(self.names, self.points.positions(vertices, self.faces), strict=True))


def read_sources(data: Path | None = None) -> tuple[Source, ...]:
    """The cohort's patients and, when `data` is given, those of that folder; BadInput when a file does not fit."""
    return (*_of_the_cohort(), *(() if data is None else _of_a_folder(data)))


def _of_the_cohort() -> list[Source]:
    bodies = read_bodies()
    found = []
    for index, patient in enumerate(bodies.patients):
        standing, supine = (next(b for b in patient.bodies if b.stance == s) for s in ("standing", "supine"))
        assert supine.table is not None
        found.append(
            _source(
                f"cohort_{patient.name}",
                DEVELOPMENT if index % 2 == 0 else VALIDATION,
                "makehuman",
                (bodies.origin, bodies.licence, bodies.sha256),
                (bodies.faces, bodies.scanned),
                standing.vertices,
                [Lying("supine", supine.vertices, supine.table)],
                standing.landmarks,
            )
        )
    return found


def _of_a_folder(folder: Path) -> list[Source]:
    """The folder's patients whose half is fixed (HALF_OF_PATIENT); others are left out."""
    names = [name for name in HALF_OF_PATIENT if (folder / name / "standing" / "truth.ply").is_file()]
    if not names:
        raise BadInput(f"{folder} holds none of {', '.join(HALF_OF_PATIENT)} with standing/truth.ply.")
    return [_patient(folder / name) for name in names]


def _patient(folder: Path) -> Source:
    about = _document(folder / "patient.json")
    standing, faces, landmarks = read_body(folder / "standing")
    lying = []
    for kind in ("supine", "supine_physics"):
        if (folder / kind / "truth.ply").is_file():
            vertices, same, _ = read_body(folder / kind)
            if not np.array_equal(same, faces):
                raise BadInput(f"{folder / kind / 'truth.ply'} has other triangles than the standing one.")
            table = float(vertices[np.abs(vertices[:, 0]) < TRUNK, 2].min())
            lying.append(Lying(kind, vertices, table))
    if not lying:
        raise BadInput(f"{folder} has no supine/truth.ply; a warped body needs both stances.")
    digest = hashlib.sha256()
    for each in (standing, *(lie.vertices for lie in lying)):
        digest.update(np.round(1e6 * each).astype(np.int64).tobytes())
    return _source(
        folder.name,
        HALF_OF_PATIENT[folder.name],
        "makehuman" if "makehuman" in json.dumps(about).lower() else "independent",
        (str(about.get("origin", "")), str(about.get("licence", "")), digest.hexdigest()),
        (faces, _without_arm_ends(standing, faces)),
        standing,
        lying,
        landmarks,
    )


def _source(
    name: str,
    half: str,
    family: str,
    provenance: tuple[str, str, str],
    mesh: tuple[Integers, Booleans],
    standing: Array,
    lying: list[Lying],
    landmarks: dict[str, Array],
) -> Source:
    """The source in the cohort's coordinates, with the landmarks as points of the skin."""
    shoulders = 0.5 * (landmarks["acromion_L"] + landmarks["acromion_R"])
    shift = np.array([0.0, NAVEL_HEIGHT - landmarks["umbilicus"][1], SHOULDER_DEPTH - shoulders[2]])
    names = tuple(sorted(landmarks))
    near = ClosestPointSearch(standing, mesh[0]).query(np.array([landmarks[each] for each in names]))
    moved = tuple(Lying(each.kind, each.vertices + shift, each.table + shift[2]) for each in lying)
    points = near.on_mesh
    return Source(
        name, half, family, provenance[0], provenance[1], *mesh, standing + shift, moved, names, points, provenance[2]
    )


def _document(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise BadInput(f"{path} cannot be read as JSON; a source of warped bodies needs it.") from error
    if not isinstance(document, dict):
        raise BadInput(f"{path} must hold a JSON object.")
    return document


def read_body(folder: Path) -> tuple[Array, Integers, dict[str, Array]]:
    """((V, 3) m, (F, 3), landmarks (3,) m) in body coordinates: case.json's matrix leads from body mm to the scan."""
    try:
        back = np.linalg.inv(np.array(_document(folder / "case.json")["body_mm_to_scan"], dtype=np.float64))
        mesh = trimesh.load(folder / "truth.ply", process=False)
        vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)
        places = _document(folder / "landmarks.json")["landmarks"]
    except (KeyError, OSError, ValueError, AttributeError) as error:
        raise BadInput(f"{folder} is no case of a virtual patient (case.json, truth.ply, landmarks.json).") from error

    def in_body(points: Array) -> Array:
        return np.asarray(1e-3 * (points @ back[:3, :3].T + back[:3, 3]))

    return in_body(vertices), faces, {name: in_body(np.array(at)) for name, at in places.items()}


def _without_arm_ends(vertices: Array, faces: Integers) -> Booleans:
    """(V,) False within CROPPED along the skin of the openings at the ends of the arms."""
    ends = [loop for loop in boundary_loops(faces) if abs(vertices[loop, 0].mean()) > ARM_AWAY]
    if not ends:
        return np.ones(len(vertices), dtype=np.bool_)
    i, j = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    lengths = np.linalg.norm(vertices[i] - vertices[j], axis=1)
    ways = coo_array((lengths, (i, j)), shape=(len(vertices), len(vertices))).tocsr()
    ways = ways.maximum(ways.T)  # coo sums doubled edges only within one direction, which each triangle has once
    return np.asarray(dijkstra(ways, directed=False, indices=np.concatenate(ends), min_only=True) > CROPPED)

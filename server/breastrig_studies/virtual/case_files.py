"""The files of one scan of a virtual body: PATIENT/STANCE/{scan.ply, truth.ply, landmarks.json, case.json}."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from breastrig.core.arrays import Array, Integers
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.units import METRES_PER_UNIT
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.scan import SimulatedScan

UNITS = ("m", "mm")  # by turns, so that both are read
SHIFT = 0.5  # m, how far from its origin a scan may lie


def write_case(
    place: Path,
    body: VirtualBody,
    skin: Integers,
    scan: SimulatedScan,
    unit: str,
    random: np.random.Generator,
    more: dict[str, Any],
) -> None:
    """Everything of one stance with (F, 3) triangles `skin`, in a frame drawn here; case.json also says `more`."""
    placed = placed_at_random(unit, random)
    place.mkdir(parents=True, exist_ok=True)
    write_ply(place / "scan.ply", moved(scan.vertices, placed), scan.faces)
    write_known(place, body, skin, scan, unit, placed, more)


def write_known(
    place: Path,
    body: VirtualBody,
    skin: Integers,
    scan: SimulatedScan,
    unit: str,
    placed: Array,
    more: dict[str, Any],
) -> None:
    """Writes a scan's ground truth in the frame of (4, 4) `placed`: truth.ply, landmarks.json, case.json."""
    write_ply(place / "truth.ply", moved(body.vertices, placed), skin)
    names = sorted(body.landmarks)
    places = np.array([body.landmarks[name] for name in names])
    gaps, _ = cKDTree(scan.vertices).query(places)
    write_json(
        place / "landmarks.json",
        {
            "schema": "breastrig/landmarks@1",
            "unit": unit,
            "landmarks": {
                name: [round(x, 6) for x in at] for name, at in zip(names, moved(places, placed).tolist(), strict=True)
            },
        },
    )
    write_json(
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
            **more,
            "notice": LIMITS_OF_USE,
        },
    )


def placed_at_random(unit: str, random: np.random.Generator) -> Array:
    """(4, 4) from body coordinates (m) into a scan's own frame and unit, turned and shifted at random."""
    result = np.eye(4)
    result[:3, :3] = Rotation.from_quat(random.standard_normal(4)).as_matrix()  # uniform over all
    result[:3, 3] = random.uniform(-SHIFT, SHIFT, 3)
    result[:3] /= METRES_PER_UNIT[unit]
    return result


def moved(points: Array, placed: Array) -> Array:
    """(M, 3) body coordinates (m) -> the frame and unit that (4, 4) `placed` leads to."""
    return np.asarray(points @ placed[:3, :3].T + placed[:3, 3])


def write_ply(path: Path, vertices: Array, faces: Integers) -> None:
    """(V, 3) vertices and (F, 3) triangles, binary."""
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    path.write_bytes(mesh.export(file_type="ply", include_attributes=False))


def write_json(path: Path, content: dict[str, Any]) -> None:
    """One value a line, so that people can read it."""
    path.write_text(json.dumps(content, indent=1) + "\n", "utf-8")

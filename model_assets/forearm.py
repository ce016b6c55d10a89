"""A rig of another body part, by data only: a forearm with a wrist (docs/how-to/own_rig.md walks through it).

    python model_assets/forearm.py FOLDER [--bodies N]

writes forearm.glb with what stands beside it, a scan of somebody's forearm and its landmarks (mm); with --bodies also N
forearms that the rig cannot quite show, in FOLDER/bodies, from which `breastrig model learn` learns.
"""

import argparse
import json
from pathlib import Path

import numpy as np
import trimesh

from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import Bone, DrawnShape, Joint, Landmark, Length, ModelDrawing, Rig, Shape
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.rig.skinning import pose
from breastrig_studies.output.rig_files import write_rig

SEGMENTS, RINGS, LENGTH = 24, 30, 0.34  # around, along, m: from the elbow to the knuckles
WRIST = 0.24  # m from the elbow
PLACES = {  # around (rad, 0 is the palm's side) and along (m)
    "elbow_crease": ("Elbow crease", 0.0, 0.01),
    "radial_styloid": ("Tip of the radius", 1.6, 0.235),
    "ulnar_styloid": ("Tip of the ulna", -2.2, 0.23),
    "wrist_crease": ("Wrist crease", 0.0, 0.245),
    "middle_knuckle": ("Knuckle of the middle finger", np.pi, 0.335),
}


def forearm_rig(name: str = "forearm") -> Rig:
    """Two bones, four shapes, five landmarks, and one drawing if any."""
    around = 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    along = np.linspace(0.0, LENGTH, RINGS)
    hand = _step(along, WRIST - 0.02, WRIST + 0.05)
    wide = 0.046 - 0.016 * _step(along, 0.08, WRIST) + 0.012 * hand
    deep = 0.043 - 0.020 * _step(along, 0.08, WRIST) - 0.008 * hand
    x, z = wide[:, None] * np.sin(around), deep[:, None] * np.cos(around)
    ulna = np.exp(-((along[:, None] - 0.23) ** 2) / 2e-4 - (np.cos(around - PLACES["ulnar_styloid"][1]) - 1.0) ** 2 * 8)
    y = np.broadcast_to(along[:, None], x.shape)
    template = np.stack([x * (1.0 + 0.25 * ulna), y, z * (1.0 + 0.25 * ulna)], axis=-1).reshape(-1, 3)
    ring, k = np.meshgrid(np.arange(RINGS - 1), np.arange(SEGMENTS), indexing="ij")
    a, b = (ring * SEGMENTS + k).ravel(), (ring * SEGMENTS + (k + 1) % SEGMENTS).ravel()
    faces = np.concatenate([np.stack([a, b, b + SEGMENTS], 1), np.stack([a, b + SEGMENTS, a + SEGMENTS], 1)])
    hand_share = _step(template[:, 1], WRIST - 0.03, WRIST + 0.03)
    upper, lower = 1.0 - _step(template[:, 1], 0.05, 0.2), _step(template[:, 1], 0.05, 0.2)
    flat = template * [1.0, 0.0, 1.0]
    shapes = {
        "thick_upper": flat * 0.2 * upper[:, None],
        "thick_lower": flat * 0.2 * lower[:, None],
        "flat_wrist": flat * [0.1, 0.0, -0.2] * hand_share[:, None],
        "long": template * [0.0, 0.1, 0.0],
    }
    low, high = np.full(3, 0.8), np.full(3, 1.25)
    at = {each: _vertex(template, *PLACES[each][1:]) for each in PLACES}
    corner = {each: _corner(faces, vertex) for each, vertex in at.items()}
    line = [_corner(faces, _vertex(template, 0.0, height)) for height in np.linspace(0.15, 0.24, 8)]
    incision = SurfacePoints(np.array([face for face, _ in line]), np.array([weights for _, weights in line]))
    return Rig(
        name=name,
        template=template,
        faces=faces.astype(np.int64),
        uv=np.stack([np.tile(np.arange(SEGMENTS) / SEGMENTS, RINGS), template[:, 1] / LENGTH], axis=1),
        blendshapes=np.array(list(shapes.values())),
        skin_weights=np.stack([1.0 - hand_share, hand_share], axis=1),
        bones=(
            Bone("radius", None, np.zeros(3), np.eye(3), low, high, "radius"),
            Bone("hand", 0, np.array([0.0, WRIST, 0.0]), np.eye(3), low, high, "hand"),
        ),
        joints=(Joint(0, 1, np.array([0.0, WRIST, 0.0]), 0.4, 0.003, 1.2),),
        shapes=tuple(Shape(each, "body", -1.0, 1.0, 0.5, each, each.replace("_", " ")) for each in shapes),
        landmarks=tuple(
            Landmark(each, label, "", f"The {label.lower()}, in its middle.", True, each, *corner[each])
            for each, (label, *_) in PLACES.items()
        ),
        drawings=(ModelDrawing("incision", "Incision", (DrawnShape("palmar", "Palmar", False, "#203080", incision),)),),
        mirror_vertices=np.arange(len(template)),
        regions={"wrist": np.flatnonzero(np.abs(template[:, 1] - WRIST) < 0.03)},
        sha256="",
        lengths=(Length("radius", "Length of the radius", "elbow_crease", "radial_styloid"),),
    )


def bent(rig: Rig, angle: float, weights: np.ndarray) -> RigParameters:
    """The wrist bent by an angle (rad) towards the palm, with weights (4,) of the shapes."""
    x = rest_parameters(rig)
    turn = trimesh.transformations.rotation_matrix(angle, [1.0, 0.0, 0.0])[:3, :3]
    return RigParameters(np.array([np.eye(3), turn]), x.translations, x.scales, weights)


def posed_forearm(rig: Rig) -> tuple[np.ndarray, RigParameters]:
    """(V, 3) m of somebody's forearm, thicker than most with a bent wrist, and its parameters."""
    x = bent(rig, 0.3, np.array([0.4, 0.2, -0.3, 0.1]))
    return pose(rig, x), x


def write_forearm(folder: Path) -> tuple[Path, Path, Path]:
    """The .glb, a scan (PLY, mm) and its landmarks."""
    rig = forearm_rig()
    write_rig(rig, folder)
    skin, _ = posed_forearm(rig)
    return folder / "forearm.glb", *write_scan(folder, rig, skin, skin)


def write_bodies(folder: Path, count: int) -> None:
    """A cohort: forearms with muscles that no shape of the rig has, scanned with a camera's noise."""
    rig = forearm_rig()
    for number in range(count):
        rng = np.random.default_rng(number)
        skin = pose(rig, bent(rig, rng.normal(0.1, 0.25), np.clip(rng.normal(0.0, 0.4, 4), -1.0, 1.0)))
        wave, phase = rng.normal(0.0, 25.0, (4, 3)), rng.uniform(0.0, 2.0 * np.pi, 4)
        bulge = 0.0008 * np.sin(skin @ wave.T + phase).sum(axis=1)
        true = skin + bulge[:, None] * trimesh.Trimesh(skin, rig.faces, process=False).vertex_normals
        place = folder / f"forearm_{number:02d}" / "standing"
        place.mkdir(parents=True, exist_ok=True)
        write_scan(place, rig, true, true + rng.normal(0.0, 0.0004, true.shape))
        trimesh.Trimesh(1e3 * true, rig.faces, process=False).export(place / "truth.ply")
        (place / "case.json").write_text(json.dumps({"unit": "mm", "stance": "standing"}))


def write_scan(folder: Path, rig: Rig, skin: np.ndarray, seen: np.ndarray) -> tuple[Path, Path]:
    """The `seen` vertices (V, 3) m as a scan, landmarks on `skin`: scan.ply and landmarks.json, mm."""
    scan, places = folder / "scan.ply", folder / "landmarks.json"
    trimesh.Trimesh(*trimesh.remesh.subdivide(1e3 * seen, rig.faces), process=False).export(scan)
    points = 1e3 * rig.landmark_points().positions(skin, rig.faces)
    named = {name: point.tolist() for name, point in zip(rig.landmark_names, points, strict=True)}
    places.write_text(json.dumps({"schema": "breastrig/landmarks@1", "unit": "mm", "landmarks": named}))
    return scan, places


def _step(values: np.ndarray, low: float, high: float) -> np.ndarray:
    t = np.clip((values - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _vertex(template: np.ndarray, around: float, along: float) -> int:
    direction = np.stack([np.sin(around) * 0.03, along, np.cos(around) * 0.03])
    return int(np.linalg.norm(template - direction, axis=1).argmin())


def _corner(faces: np.ndarray, vertex: int) -> tuple[int, np.ndarray]:
    face = int(np.flatnonzero((faces == vertex).any(axis=1))[0])
    return face, (faces[face] == vertex).astype(np.float64)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--bodies", type=int, default=0)
    options = parser.parse_args()
    write_forearm(options.folder)
    write_bodies(options.folder / "bodies", options.bodies)

"""A small rig that has everything a rig can have: a torso-sized tube, symmetric, with rotated rest frames.

204 vertices, 4 bones in a branching chain with non-uniform scale limits, 4 shapes (one of each kind, one pair),
3 landmarks, 1 drawing with an open and a closed line.  No files.
"""

from functools import lru_cache

import numpy as np

from breastrig.geometry.rotations import exp_so3
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import Bone, DrawnShape, Joint, Landmark, Length, ModelDrawing, Rig, Shape

SEGMENTS, RINGS = 12, 17
HEIGHT = 0.5  # m
MIRROR = np.array([-1.0, 1.0, 1.0])


@lru_cache(maxsize=1)
def toy_rig() -> Rig:
    """The rig; always the same object."""
    template, faces, mirror = _tube()
    chest_up = _smooth(template[:, 1], 0.15, 0.35)
    front = np.clip(template[:, 2] / 0.1, 0.0, 1.0)
    outwards = template * [1.0, 0.0, 1.0]
    bump = {
        side: np.exp(-(((template - [x, 0.35, 0.1]) / 0.06) ** 2).sum(1)) for side, x in (("L", 0.07), ("R", -0.07))
    }
    blendshapes = np.array(
        [
            bump["L"][:, None] * [0.1, -0.2, 1.0] * 0.04,
            bump["R"][:, None] * [-0.1, -0.2, 1.0] * 0.04,
            outwards * 0.1,
            (chest_up * front)[:, None] * [0.0, 0.3, -1.0] * 0.03,
        ]
    )
    return Rig(
        name="toy",
        template=template,
        faces=faces,
        uv=np.stack([np.tile(np.arange(SEGMENTS) / SEGMENTS, RINGS), template[:, 1] / HEIGHT], axis=1),
        blendshapes=blendshapes,
        skin_weights=_skin_weights(template),
        bones=(
            _bone("pelvis", None, [0.0, 0.05, 0.0], [0.0, 0.0, 0.0], "pelvis"),
            _bone("chest", 0, [0.0, 0.22, -0.02], [0.2, 0.0, 0.0], "chest"),
            _bone("shoulder_L", 1, [0.08, 0.42, 0.0], [0.1, 0.2, -0.5], "shoulder_R"),
            _bone("shoulder_R", 1, [-0.08, 0.42, 0.0], [0.1, -0.2, 0.5], "shoulder_L"),
        ),
        joints=(
            Joint(0, 1, np.array([0.0, 0.22, -0.02]), 0.2, 0.005, 0.9),
            Joint(1, 2, np.array([0.05, 0.40, 0.0]), 0.3, 0.005, 0.9),
            Joint(1, 3, np.array([-0.05, 0.40, 0.0]), 0.3, 0.005, 0.9),
        ),
        shapes=(
            Shape("bump_L", "soft", 0.0, 1.0, 0.5, "bump_R", "Left bump"),
            Shape("bump_R", "soft", 0.0, 1.0, 0.5, "bump_L", "Right bump"),
            Shape("wide", "body", -1.0, 1.0, 0.5, "wide", "Width"),
            Shape("flat", "gravity", 0.0, 1.0, 0.5, "flat", "Flattened when lying"),
        ),
        landmarks=(
            _landmark("suprasternal_notch", "suprasternal_notch", _face_near(template, faces, [0.0, 0.45, 0.12])),
            _landmark("nipple_L", "nipple_R", _face_near(template, faces, [0.07, 0.35, 0.12])),
            _landmark("nipple_R", "nipple_L", _face_near(template, faces, [-0.07, 0.35, 0.12])),
        ),
        drawings=(_drawing(template, faces),),
        mirror_vertices=mirror,
        regions={
            "breast_L": np.flatnonzero(bump["L"] > 0.3).astype(np.int64),
            "breast_R": np.flatnonzero(bump["R"] > 0.3).astype(np.int64),
        },
        sha256="0" * 64,
        lengths=(Length("notch_nipple", "Notch to nipple", "suprasternal_notch", "nipple"),),
    )


def _tube() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rings of an ellipse that bulges to the front and tapers upwards; diagonals mirrored too."""
    angles = 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS  # 0 is the front, growing to the patient's left
    heights = np.linspace(0.0, HEIGHT, RINGS)
    widths = 0.16 - 0.04 * np.cos(2.0 * np.pi * heights / HEIGHT) * 0.5
    depth = np.where(np.cos(angles) > 0, 0.12, 0.09)
    x = widths[:, None] * np.sin(angles)
    z = np.broadcast_to(depth * np.cos(angles), x.shape) + 0.02 * np.sin(np.pi * heights / HEIGHT)[:, None]
    y = np.broadcast_to(heights[:, None], x.shape)
    template = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    column = np.arange(SEGMENTS)
    mirror = (np.arange(RINGS)[:, None] * SEGMENTS + (-column) % SEGMENTS).ravel()
    template = 0.5 * (template + template[mirror] * MIRROR)  # symmetric to the last bit
    faces = []
    for ring in range(RINGS - 1):
        for k in range(SEGMENTS):
            a, b = ring * SEGMENTS + k, ring * SEGMENTS + (k + 1) % SEGMENTS
            c, d = a + SEGMENTS, b + SEGMENTS
            faces += [[a, b, d], [a, d, c]] if k < SEGMENTS // 2 else [[a, b, c], [b, d, c]]
    return template, np.array(faces, np.int64), mirror.astype(np.int64)


def _skin_weights(template: np.ndarray) -> np.ndarray:
    """(V, 4): smooth, symmetric, up to four bones on a vertex."""
    chest = _smooth(template[:, 1], 0.12, 0.32)
    shoulders = _smooth(template[:, 1], 0.32, 0.5) * 0.8
    left = 0.5 + 0.5 * np.tanh(template[:, 0] / 0.05)
    weights = np.stack(
        [1.0 - chest, chest * (1.0 - shoulders), chest * shoulders * left, chest * shoulders * (1.0 - left)], axis=1
    )
    return weights / weights.sum(axis=1, keepdims=True)


def _bone(name: str, parent: int | None, origin: list[float], turn: list[float], mirror: str) -> Bone:
    low, high = np.array([0.7, 0.8, 0.7]), np.array([1.4, 1.25, 1.4])
    return Bone(name, parent, np.array(origin), exp_so3(np.array(turn)), low, high, mirror)


def _landmark(name: str, mirror: str, face: int) -> Landmark:
    label = name.replace("_", " ")
    return Landmark(name, label, "", f"Centre of the triangle called {label}.", True, mirror, face, np.ones(3) / 3)


def _face_near(template: np.ndarray, faces: np.ndarray, point: list[float]) -> int:
    return int(np.linalg.norm(template[faces].mean(axis=1) - point, axis=1).argmin())


def _drawing(template: np.ndarray, faces: np.ndarray) -> ModelDrawing:
    """A line up the middle of the front, and a closed one around the left bump."""
    # the quads right of the front column: their edge on the column is corners a, c of every second triangle
    edge_faces = [2 * SEGMENTS * ring + 1 for ring in range(6, 14)]  # triangle (a, d, c) of the column k = 0
    line = SurfacePoints(np.repeat(edge_faces, 2), np.tile([[1.0, 0, 0], [0.5, 0, 0.5]], (len(edge_faces), 1)))
    ring_faces, ring_weights = [], []
    for row, column, corner in (
        (8, 0, 0),
        (8, 1, 0),
        (8, 2, 0),
        (10, 2, 0),
        (12, 2, 0),
        (12, 1, 0),
        (12, 0, 0),
        (10, 0, 0),
    ):
        ring_faces.append(2 * (row * SEGMENTS + column))
        weights = np.full(3, 0.1)
        weights[corner] = 0.8
        ring_weights.append(weights)
    circle = SurfacePoints(np.array(ring_faces), np.array(ring_weights))
    return ModelDrawing(
        "lumpectomy",
        "Lumpectomy (toy)",
        (
            DrawnShape("sternum", "Sternum", False, "#1f5fbf", line),
            DrawnShape("breast_L", "Left breast", True, "#101010", circle),
        ),
    )


def _smooth(values: np.ndarray, low: float, high: float) -> np.ndarray:
    t = np.clip((values - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)

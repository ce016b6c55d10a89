"""Scans of warped bodies: mostly ordinary; else with a poor sensor, with large holes, or of only a part.

A part is cut out of the ordinary scan in body coordinates, as a scan that was broken off or taken from one side.
"""

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.depth_fusion import without_small_pieces
from breastrig_studies.virtual.scan import SMALLEST_PIECE, VOXEL, Circumstances, SimulatedScan, scan_skin

POOR_NOISE, POOR_VOXEL = 2.0, 0.008  # times, m
EVERY = 2  # of the cohort's views, because there are many bodies: half the time; 1.1-1.3 mm of error, not 0.85
HOLES = (2, 4)  # how many
HOLE = (0.030, 0.045)  # m, radius
ASIDE = 0.04  # m beyond the midline, from where a scan of one side only begins


def scan_captured(
    body: VirtualBody, skin: Integers, scanned: Booleans, capture: str, random: np.random.Generator
) -> SimulatedScan:
    """The scan of a body with (F, 3) triangles `skin`, (V,) bool `scanned`, in body coordinates."""
    poor = capture == "poor_sensor"
    holes = _large_holes(body, scanned, random) if capture == "large_holes" else None
    about = Circumstances(POOR_NOISE if poor else 1.0, POOR_VOXEL if poor else VOXEL, EVERY, holes)
    whole = scan_skin(body, skin, scanned, random, about)
    kept = shown(whole.vertices, body.landmarks, capture)
    if kept.all():
        return whole
    vertices, faces, _ = without_small_pieces(
        whole.vertices, whole.faces[kept[whole.faces].all(axis=1)], SMALLEST_PIECE
    )
    return SimulatedScan(vertices, faces, whole.error)


def shown(vertices: Array, landmarks: dict[str, Array], capture: str) -> Booleans:
    """(V,) bool: which points of an ordinary scan a capture shows."""
    middle = 0.5 * (landmarks["suprasternal_notch"][0] + landmarks["xiphoid"][0])
    level = np.mean([at[1] for name, at in landmarks.items() if name.startswith("nipple")])
    match capture:
        case "left_half":
            return np.asarray(vertices[:, 0] > middle)
        case "one_side":
            return np.asarray(vertices[:, 0] < middle - ASIDE)
        case "above_nipples":
            return np.asarray(vertices[:, 1] > level)
        case "below_nipples":
            return np.asarray(vertices[:, 1] < level)
        case _:
            return np.ones(len(vertices), dtype=np.bool_)


def _large_holes(body: VirtualBody, scanned: Booleans, random: np.random.Generator) -> Array:
    """(M, 4) m: centres on the front between navel and notch, wherever the landmarks are, and radii."""
    low, high = body.landmarks["umbilicus"][1], body.landmarks["suprasternal_notch"][1]
    height = body.vertices[:, 1]
    front = np.flatnonzero(scanned & (body.vertices[:, 2] > 0.03) & (height > low) & (height < high))
    centres = body.vertices[random.choice(front, int(random.integers(HOLES[0], HOLES[1] + 1)), replace=False)]
    return np.column_stack([centres, random.uniform(*HOLE, len(centres))])

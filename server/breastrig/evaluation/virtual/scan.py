"""The scan of a virtual woman: depth images with their errors, fused to one surface, cropped as people crop."""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.evaluation.virtual.bodies import Bodies, VirtualBody, closed
from breastrig.evaluation.virtual.depth_camera import take
from breastrig.evaluation.virtual.depth_fusion import fuse, without_small_pieces
from breastrig.evaluation.virtual.session import plan_session, table_top
from breastrig.geometry.closest_point import ClosestPointSearch

VOXEL = 0.0055  # m, the resolution of tablet scanning programs at body size
SMALLEST_PIECE = 80  # triangles; smaller ones are what scanning programs throw away


@dataclass(frozen=True, eq=False)
class SimulatedScan:
    """In body coordinates."""

    vertices: Array  # (V, 3) m
    faces: Integers  # (F, 3)
    error: float  # m, mean distance from the scan to the true surface


def scan_body(bodies: Bodies, body: VirtualBody, random: np.random.Generator) -> SimulatedScan:
    """One scan of one stance; the same state of the generator gives the same scan."""
    session = plan_session(body, bodies.scanned, random)
    vertices, faces = closed(body.vertices, bodies.faces)
    kept = np.concatenate([bodies.scanned, np.zeros(len(vertices) - len(body.vertices), dtype=np.bool_)])
    if body.table is not None:
        top, squares = table_top(body.table)
        faces = np.concatenate([faces, len(vertices) + squares])
        vertices = np.concatenate([vertices, top])
        kept = np.concatenate([kept, np.ones(len(top), dtype=np.bool_)])
    images = take(vertices, faces, session.views, session.camera, random, session.blind_spots)
    seen, triangles = fuse(images, session.low, session.high, VOXEL)
    nearest = ClosestPointSearch(vertices, faces).query(seen)
    share = np.einsum("mc,mc->m", nearest.barycentric, kept[faces[nearest.faces]].astype(np.float64))
    inside = (share > 0.5)[triangles].all(axis=1)
    seen, triangles, used = without_small_pieces(seen, triangles[inside], SMALLEST_PIECE)
    return SimulatedScan(seen, triangles, float(nearest.distances[used].mean()))

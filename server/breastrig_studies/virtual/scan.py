"""The scan of a virtual patient: depth images with their errors, fused to one surface, cropped as people crop."""

from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig_studies.virtual.bodies import Bodies, VirtualBody, closed
from breastrig_studies.virtual.depth_camera import take
from breastrig_studies.virtual.depth_fusion import ENOUGH, fuse, without_small_pieces
from breastrig_studies.virtual.session import plan_session, table_top

VOXEL = 0.0055  # m, the resolution of tablet scanning programs at body size
SMALLEST_PIECE = 80  # triangles; smaller ones are what scanning programs throw away


@dataclass(frozen=True, eq=False)
class SimulatedScan:
    """A simulated scan, in body coordinates."""

    vertices: Array  # (V, 3) m
    faces: Integers  # (F, 3)
    error: float  # m, mean distance from the scan to the true surface


@dataclass(frozen=True, eq=False)
class Circumstances:
    """Unusual circumstances of a scan."""

    noisier: float = 1.0  # times the sensor's noise
    voxel: float = VOXEL  # m
    every: int = 1  # 2: only every second view of the session, and half as many need to have seen a place
    holes: Array | None = None  # (M, 4): centre and radius (m) of more skin that gives no answer


def scan_body(bodies: Bodies, body: VirtualBody, random: np.random.Generator) -> SimulatedScan:
    """One scan of one stance; the same state of the generator gives the same scan."""
    return scan_skin(body, bodies.faces, bodies.scanned, random, Circumstances())


def scan_skin(
    body: VirtualBody, skin: Integers, scanned: Booleans, random: np.random.Generator, about: Circumstances
) -> SimulatedScan:
    """The scan of any (F, 3) mesh of a body; vertices outside (V,) bool `scanned` are cropped."""
    session = plan_session(body, scanned, random)
    camera = replace(session.camera, noise=about.noisier * session.camera.noise)
    spots = session.blind_spots if about.holes is None else np.concatenate([session.blind_spots, about.holes])
    vertices, faces = closed(body.vertices, skin)
    kept = np.concatenate([scanned, np.zeros(len(vertices) - len(body.vertices), dtype=np.bool_)])
    if body.table is not None:
        top, squares = table_top(body.table)
        faces = np.concatenate([faces, len(vertices) + squares])
        vertices = np.concatenate([vertices, top])
        kept = np.concatenate([kept, np.ones(len(top), dtype=np.bool_)])
    images = take(vertices, faces, session.views[:: about.every], camera, random, spots)
    seen, triangles = fuse(images, session.low, session.high, about.voxel, ENOUGH / about.every)
    nearest = ClosestPointSearch(vertices, faces).query(seen)
    share = np.einsum("mc,mc->m", nearest.barycentric, kept[faces[nearest.faces]].astype(np.float64))
    inside = (share > 0.5)[triangles].all(axis=1)
    seen, triangles, used = without_small_pieces(seen, triangles[inside], SMALLEST_PIECE)
    return SimulatedScan(seen, triangles, float(nearest.distances[used].mean()))

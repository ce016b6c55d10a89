"""Other methods on the same scans, by trimesh: a rigid ICP and the free-form nricp_amberg.

Both start where our fit starts, from the landmarks' similarity.  nricp_amberg is Amberg, Romdhani and Vetter,
Optimal step nonrigid ICP algorithms for surface registration, 2007; it is given the landmarks too.  Both match
with the scan's vertices, because trimesh's exact search needs a package that nothing else here needs.
"""

from collections.abc import Callable

import numpy as np
import trimesh
from scipy.spatial import cKDTree
from trimesh.registration import icp, nricp_amberg

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.landmark_check import start_from_landmarks
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose

Peer = Callable[[Rig, ScanTarget, dict[str, Array]], Array]
REACH = 0.05  # m, as far as our own fit looks
POINTS = 4000  # of the scan


def rigid_icp(rig: Rig, target: ScanTarget, landmarks: dict[str, Array]) -> Array:
    """(V, 3) m: the start turned, shifted and scaled as one piece, so that the scan near it lies on it."""
    start = pose(rig, start_from_landmarks(rig, landmarks))
    scan = target.vertices[:: max(1, len(target.vertices) // POINTS)]
    near = cKDTree(start).query(scan)[0] < REACH
    matrix, _, _ = icp(scan[near], start, max_iterations=50, reflection=False, scale=True)
    return np.asarray(trimesh.transform_points(start, np.linalg.inv(matrix)))


def nricp(rig: Rig, target: ScanTarget, landmarks: dict[str, Array]) -> Array:
    """(V, 3) m: the start bent freely."""
    points = rig.landmark_points(tuple(landmarks))
    start = trimesh.Trimesh(pose(rig, start_from_landmarks(rig, landmarks)), rig.faces, process=False)
    moved = nricp_amberg(
        start,
        trimesh.Trimesh(target.vertices, target.faces, process=False),
        source_landmarks=(np.asarray(points.faces), np.asarray(points.barycentric)),
        target_positions=np.array(list(landmarks.values())),
        use_faces=False,
        distance_threshold=REACH,
    )
    return np.asarray(moved)


PEERS: dict[str, Peer] = {"rigid_icp": rigid_icp, "nricp_amberg": nricp}

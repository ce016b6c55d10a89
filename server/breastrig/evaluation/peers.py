"""Other methods on the same scans, by trimesh: a rigid ICP and the free-form nricp_amberg.

Both start where our fit starts (a similarity on the landmarks) and get what they can use.  nricp_amberg is Amberg,
Romdhani and Vetter, Optimal step nonrigid ICP algorithms for surface registration, 2007.
"""

import time
from collections.abc import Callable

import numpy as np
import trimesh
from trimesh.registration import icp, nricp_amberg

from breastrig.evaluation.registration import Registration
from breastrig.evaluation.subject import Subject
from breastrig.fitting.landmark_check import start_from_landmarks
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose

Peer = Callable[[Rig, Subject], Registration]
DISTANCE = 0.05  # m, as far as our own fit looks


def rigid_icp(rig: Rig, subject: Subject) -> Registration:
    """The start moved as one piece (turn, shift, one scale)."""
    start = pose(rig, start_from_landmarks(rig, subject.landmarks))
    mesh = trimesh.Trimesh(subject.target.vertices, subject.target.faces, process=False)
    began = time.perf_counter()
    # from the scan to the model: the scan is the part that is wholly matched; then turned round
    model = trimesh.Trimesh(start, rig.faces, process=False)
    near, _ = subject.target.vertex_tree.query(start)
    points = start[near < DISTANCE]
    matrix, _, _ = icp(points, mesh, max_iterations=50, reflection=False, scale=True)
    moved = trimesh.transform_points(model.vertices, matrix)
    return Registration(np.asarray(moved), time.perf_counter() - began, 50, "Stopped by trimesh.")


def nricp(rig: Rig, subject: Subject) -> Registration:
    """The start bent freely, landmarks included."""
    names = tuple(subject.landmarks)
    points = rig.landmark_points(names)
    start = trimesh.Trimesh(pose(rig, start_from_landmarks(rig, subject.landmarks)), rig.faces, process=False)
    mesh = trimesh.Trimesh(subject.target.vertices, subject.target.faces, process=False)
    began = time.perf_counter()
    moved = nricp_amberg(
        start,
        mesh,
        source_landmarks=(np.asarray(points.faces), np.asarray(points.barycentric)),
        target_positions=np.array(list(subject.landmarks.values())),
        use_faces=True,
        distance_threshold=DISTANCE,
    )
    return Registration(np.asarray(moved), time.perf_counter() - began, 0, "Stopped by trimesh.")


PEERS: dict[str, Peer] = {"rigid_icp": rigid_icp, "nricp_amberg": nricp}

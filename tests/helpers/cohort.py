"""Patients for evaluations, made with the rig itself: small scans, whose truth is the scan."""

import json
from pathlib import Path

import numpy as np
import trimesh

from breastrig.geometry.normals import face_normals
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.rig.skinning import pose

BEHIND = -0.3  # of a triangle's normal towards the front: a camera that went around the front saw no more
FEW = ("suprasternal_notch", "xiphoid", "acromion_L", "acromion_R", "nipple_L", "nipple_R", "umbilicus")


def write_case(
    folder: Path,
    rig: Rig,
    parameters: RigParameters,
    stance: str,
    names: tuple[str, ...] | None = None,
    behind: float = BEHIND,
) -> None:
    """scan, truth, true landmarks (all, or those named) and case.json of one posed rig, in metres."""
    folder.mkdir(parents=True)
    vertices = pose(rig, parameters)
    seen = face_normals(vertices, rig.faces)[:, 2] > behind
    for name, faces in (("scan.ply", rig.faces[seen]), ("truth.ply", rig.faces)):
        trimesh.Trimesh(vertices, faces, process=False).export(folder / name)
    places = rig.landmark_points().positions(vertices, rig.faces)
    named = {name: place.tolist() for name, place in zip(rig.landmark_names, places, strict=True)}
    named = {name: named[name] for name in names or rig.landmark_names}
    landmarks = {"schema": "breastrig/landmarks@1", "unit": "m", "landmarks": named}
    (folder / "landmarks.json").write_text(json.dumps(landmarks))
    (folder / "case.json").write_text(json.dumps({"unit": "m", "stance": stance}))


def write_patient(
    folder: Path,
    rig: Rig,
    seed: int,
    family: str,
    stances: tuple[str, ...] = ("standing", "supine"),
    names: tuple[str, ...] | None = None,
) -> None:
    """One body of moderate shapes, another in each stance."""
    rng = np.random.default_rng(seed)
    for stance in stances:
        rest = rest_parameters(rig)
        sigmas = np.array([shape.sigma for shape in rig.shapes])
        weights = 0.4 * rng.normal(size=len(sigmas)) * sigmas
        weights = np.clip(weights, [shape.min for shape in rig.shapes], [shape.max for shape in rig.shapes])
        posed = RigParameters(rest.rotations, rest.translations, rest.scales, weights)
        write_case(folder / stance, rig, posed, stance, names)
    (folder / "patient.json").write_text(json.dumps({"family": family}))

"""Patients for evaluations, made with the rig itself: small scans, whose truth is the scan."""

import json
from pathlib import Path

import numpy as np
import trimesh

from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.rig.skinning import pose


def write_case(folder: Path, rig: Rig, parameters: RigParameters, stance: str) -> None:
    """scan, truth, true landmarks and case.json of one posed rig, in metres."""
    folder.mkdir(parents=True)
    vertices = pose(rig, parameters)
    for name in ("scan.ply", "truth.ply"):
        trimesh.Trimesh(vertices, rig.faces, process=False).export(folder / name)
    places = rig.landmark_points().positions(vertices, rig.faces)
    named = {name: place.tolist() for name, place in zip(rig.landmark_names, places, strict=True)}
    landmarks = {"schema": "breastrig/landmarks@1", "unit": "m", "landmarks": named}
    (folder / "landmarks.json").write_text(json.dumps(landmarks))
    (folder / "case.json").write_text(json.dumps({"unit": "m", "stance": stance}))


def write_patient(
    folder: Path, rig: Rig, seed: int, family: str, stances: tuple[str, ...] = ("standing", "supine")
) -> None:
    """One body of moderate shapes, another in each stance."""
    rng = np.random.default_rng(seed)
    for stance in stances:
        rest = rest_parameters(rig)
        sigmas = np.array([shape.sigma for shape in rig.shapes])
        weights = 0.4 * rng.normal(size=len(sigmas)) * sigmas
        weights = np.clip(weights, [shape.min for shape in rig.shapes], [shape.max for shape in rig.shapes])
        posed = RigParameters(rest.rotations, rest.translations, rest.scales, weights)
        write_case(folder / stance, rig, posed, stance)
    (folder / "patient.json").write_text(json.dumps({"family": family}))

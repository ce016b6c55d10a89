"""Is the body found however the scan lies, without any landmark?

The scan is turned over the whole sphere and shifted, as it was scanned and, where the true surface tells body from
table, with everything but the body taken away.  Right or wrong is judged from the landmarks: the similarity from
the model's resting landmarks to the fitted ones against the one to the true ones.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from breastrig.core.arrays import Array
from breastrig.core.errors import BreastRigError
from breastrig.core.stances import AUTO
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.prepare_scan import prepared
from breastrig.fitting.recipe import Recipe
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig.scan.clean import Surface, compact
from breastrig_studies.studies.case import Scene, ready

BODY = 0.015  # m from the true surface; farther triangles are table or noise
SHIFT = 1.0  # m, at most along each axis: scanners put their origin anywhere
WRONG = np.cos(np.radians(45.0))  # an axis farther off than this would show the patient the wrong way
SEED = 24


def without_table(scene: Scene) -> Scene:
    """The scene with the triangles near the true surface only."""
    assert scene.truth is not None
    faces, vertices = scene.target.faces, scene.target.vertices
    near = scene.truth.query(vertices).distances < BODY
    kept = faces[near[faces].all(axis=1)]
    surface = Surface(*compact(vertices, kept), ())
    return replace(scene, whole=surface, target=ready(ScanTarget(surface.vertices, surface.faces)))


def turned(scene: Scene, rotation: Array, shift: Array) -> Scene:
    """The scan at another place."""
    moved = replace(scene.whole, vertices=scene.whole.vertices @ rotation.T + shift)
    scanned = prepared(moved, AUTO)
    landmarks = {name: rotation @ place + shift for name, place in scene.landmarks.items()}
    return Scene(scene.case, ready(scanned.target), moved, landmarks, None)


def wrong_way(rig: Rig, vertices: Array, true: dict[str, Array]) -> dict[str, bool]:
    """Whether each axis of the fitted body is reversed, for (V, 3) m vertices and the true landmarks (3,) m."""
    names = tuple(true)
    points = rig.landmark_points(names)
    rest = points.positions(rig.template, rig.faces)
    fitted = umeyama(rest, points.positions(vertices, rig.faces)).rotation
    known = umeyama(rest, np.array([true[name] for name in names])).rotation
    left, up, front = (float(fitted[:, axis] @ known[:, axis]) for axis in range(3))
    return {"up": bool(up < WRONG), "facing": bool(front < WRONG), "sides": bool(left < 0.0)}


def random_turns(scene: Scene, rig: Rig, recipe: Recipe, rotations: int) -> dict[str, Any]:
    """One trial a rotation, for the scan as it is and, lying and known, without the table."""
    rng = np.random.default_rng(SEED)
    turns = Rotation.random(rotations, rng).as_matrix().reshape(-1, 3, 3)
    shifts = rng.uniform(-SHIFT, SHIFT, (rotations, 3))
    variants = {"as_scanned": scene}
    if scene.case.stance == "supine" and scene.truth is not None:
        variants["without_table"] = without_table(scene)
    trials: list[dict[str, Any]] = []
    for variant, of in variants.items():
        for rotation, shift in zip(turns, shifts, strict=True):
            about: dict[str, Any] = {"variant": variant, "failed": None}
            try:
                now = turned(of, rotation, shift)
                start = now.start(rig, {})
                about["stance"] = now.found_stance(rig, recipe, start)
                fit = now.fitted(rig, recipe, {}, start=start, stance=about["stance"])
                back = (fit.vertices - shift) @ rotation
                about |= wrong_way(rig, back, of.landmarks) | of.numbers(rig, back)
            except BreastRigError as error:
                about["failed"] = str(error)
            trials.append(about)
    return {"trials": trials}

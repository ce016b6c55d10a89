"""Verdicts on a scan under a condition of virtual/as_captured.py, with its landmarks and without.

The landmarks that are given, and measured, are those on the remaining scan; clothes leave the landmarks below them
there.
"""

import zlib
from dataclasses import replace
from typing import Any

import numpy as np

from breastrig.core.errors import BadInput
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.recipe import Recipe
from breastrig.rig.model import Rig
from breastrig.scan.clean import Surface
from breastrig_studies.studies.case import Scene, TrueLandmarks
from breastrig_studies.studies.trust.asked import answer
from breastrig_studies.virtual.as_captured import as_captured

ON_SCAN = 0.025  # m; under hair and hanging breasts no scan is nearer


def captured_scene(scene: Scene, condition: str) -> Scene:
    """The case under a condition."""
    random = np.random.default_rng(zlib.crc32(f"{scene.case.patient}/{scene.case.name}/{condition}".encode()))
    target, true = scene.target, dict(scene.landmarks)
    vertices, faces, marks = as_captured(condition, target.vertices, target.faces, true, random)
    changed = ScanTarget(vertices, faces)
    away = np.atleast_1d(changed.vertex_tree.query(np.array([*marks.values()]))[0])
    seen = {name: at for (name, at), far in zip(marks.items(), away, strict=True) if far < ON_SCAN}
    whole = Surface(vertices, faces, ())
    return replace(scene, target=changed, whole=whole, landmarks=TrueLandmarks(seen), truth=None)


def captured(scene: Scene, rig: Rig, recipe: Recipe, condition: str) -> dict[str, Any]:
    """{"all", "none": as `answer` says it}."""
    changed = captured_scene(scene, condition)
    found = {}
    for kind, picks in (("all", dict(changed.landmarks)), ("none", {})):
        try:
            found[kind] = answer(changed, rig, recipe, picks)
        except BadInput as error:
            found[kind] = {"level": "refused", "reasons": [str(error)]}
    return found

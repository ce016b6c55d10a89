"""Landmarks proposed from the scan alone: a fit without any, its landmarks laid on the skin, a confidence each.

The confidence is 1 / (1 + (e / 10 mm)²) with the error e that proposals of that landmark had on the dev scans:
landmarks with a form of their own (breastbone, nipples, folds) are found, those on a smooth slope (shoulder tip,
navel of a slim belly) slide.  It is halved where the scan shows no skin, and it falls when the body's
orientation was not clear.
"""

from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.match import MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.orientation import start_from_scan
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.stance import found_stance
from breastrig.geometry.normals import vertex_normals
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose
from breastrig.scan.orient import Frame

EXPECTED_ERROR = {  # m, mean over the ten dev scans; names without their side
    "suprasternal_notch": 0.009,
    "mid_sternum": 0.007,
    "xiphoid": 0.007,
    "midclavicle": 0.013,
    "acromion": 0.021,
    "nipple": 0.007,
    "inframammary_fold": 0.009,
    "umbilicus": 0.018,
}
UNKNOWN_ERROR = 0.02  # m, for landmarks of other rigs
USEFUL = 0.01  # m; a proposal this far off still saves the user a search: confidence one half
LEAST = 0.01  # confidence; 0.1 m off, which no longer pulls at anything
CLEAR_MARGIN = 0.1  # of start_from_scan; the dev scans have 0.08 to 0.19
ON_SKIN = MatchRules(method="tree", max_distance=0.015, max_angle=np.pi / 3)


def expected_error(confidence: float) -> float:
    """m, how far off a landmark of this confidence (0 to 1) is expected to be: 1 is a person's own pick."""
    return USEFUL * float(np.sqrt(1.0 / max(confidence, LEAST) - 1.0))


@dataclass(frozen=True, eq=False)
class Proposal:
    """Where a landmark probably is."""

    point: Array  # (3,) m, in the target's frame
    confidence: float  # 0 to 1
    on_scan: bool  # on skin that the scan shows


def propose_landmarks(rig: Rig, target: ScanTarget, frame: Frame, recipe: Recipe) -> dict[str, Proposal]:
    """All landmarks of the rig on a scan whose front is about known."""
    start = start_from_scan(rig, target, frame.fronts)
    task = FitTask(rig, target, start.parameters, recipe, {})
    *_, last = fit_iterates(replace(task, stance=found_stance(task, frame)[0]))
    vertices = pose(rig, last.parameters)
    points = rig.landmark_points()
    places, normals = (points.positions(of, rig.faces) for of in (vertices, vertex_normals(vertices, rig.faces)))
    found = match(target, places, normals / np.linalg.norm(normals, axis=1, keepdims=True), ON_SKIN)
    seen = np.zeros(len(places), dtype=np.bool_)
    seen[found.vertices] = True
    places[found.vertices] = found.points
    clear = float(np.clip(start.margin / CLEAR_MARGIN, 0.0, 1.0))
    proposals = {}
    for k, name in enumerate(rig.landmark_names):
        error = EXPECTED_ERROR.get(name.removesuffix("_L").removesuffix("_R"), UNKNOWN_ERROR)
        trust = clear / (1.0 + (error / USEFUL) ** 2) * (1.0 if seen[k] else 0.5)
        proposals[name] = Proposal(places[k], round(trust, 2), bool(seen[k]))
    return proposals

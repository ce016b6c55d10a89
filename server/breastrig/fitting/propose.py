"""Landmarks proposed from the scan alone: a fit without any, its landmarks laid on the skin, a confidence each.

The confidence is 1 / (1 + (e / 10 mm)²) with the error e that proposals of that landmark are expected to have:
landmarks with a form of their own (breastbone, nipples, folds) are found, those on a smooth slope (shoulder tip,
navel of a slim belly) slide.  It is halved where the scan shows no skin, and it falls when the body's
orientation was not clear.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.match import MatchRules, match
from breastrig.fitting.fit import FitIterate, fit_iterates
from breastrig.fitting.prepare_scan import PreparedScan
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.scan_orientation import ScanOrientation, orientation_task, scan_orientation
from breastrig.geometry.normals import vertex_normals
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose

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

    point: Array  # (3,) m, in the scan's frame
    confidence: float  # 0 to 1
    on_scan: bool  # on skin that the scan shows


def propose_landmarks(
    rig: Rig, scan: PreparedScan, recipe: Recipe, orientation: ScanOrientation | None = None
) -> dict[str, Proposal]:
    """All landmarks of the rig on a scan; `orientation` when it is known already."""
    begun: tuple[FitIterate, ...] = ()
    if orientation is None:
        orientation, task, begun = scan_orientation(rig, scan, recipe)
    else:
        task = orientation_task(rig, scan, orientation, recipe)
    *_, last = begun or fit_iterates(task)
    vertices = pose(rig, last.parameters)
    points = rig.landmark_points()
    places, normals = (points.positions(of, rig.faces) for of in (vertices, vertex_normals(vertices, rig.faces)))
    found = match(scan.target, places, normals / np.linalg.norm(normals, axis=1, keepdims=True), ON_SKIN)
    seen = np.zeros(len(places), dtype=np.bool_)
    seen[found.vertices] = True
    places[found.vertices] = found.points
    clear = float(np.clip(orientation.margin / CLEAR_MARGIN, 0.0, 1.0))
    proposals = {}
    for k, name in enumerate(rig.landmark_names):
        error = recipe.landmark_errors(name).proposal
        trust = clear / (1.0 + (error / USEFUL) ** 2) * (1.0 if seen[k] else 0.5)
        proposals[name] = Proposal(places[k], round(trust, 2), bool(seen[k]))
    return proposals

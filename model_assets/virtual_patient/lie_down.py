"""A whole body laid on the table: arms as they are for a scan, breasts, belly and back as gravity leaves them."""

import numpy as np
from scipy.spatial import cKDTree
from virtual_patient.body import Body, Turns
from virtual_patient.lying import Tissue, back_on_table, belly_lying, breasts_lying, chest_wall

Array = np.ndarray

FOOTPRINT = 0.06  # share of the breast field from which on skin belongs to the breast
SLIDING = 0.09  # m around the breasts within which the skin slides along


def lie_down(body: Body, turns: Turns, tissue: Tissue, navel_height: float, behind: float) -> tuple[Array, float]:
    """((V, 3) m in body coordinates, the table's z in m); behind that depth (m) neither breast nor belly moves."""
    posed, _ = body.posed(turns)
    footprint = body.breasts > FOOTPRINT
    away, _ = cKDTree(posed[footprint]).query(posed)
    region = (away < SLIDING) & (body.arms < 0.3) & (posed[:, 2] > behind)
    wall = chest_wall(posed, body.faces, footprint)
    result = breasts_lying(posed, body.faces, wall, region, tissue)
    trunk = np.clip(1.0 - 3.0 * body.arms, 0.0, 1.0)
    result = belly_lying(result, trunk, navel=np.array([0.0, navel_height, 0.0]), back=behind, tissue=tissue)
    return back_on_table(result, tissue)

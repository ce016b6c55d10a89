"""A whole body laid on the table: arms as they are for a scan, breasts, belly and back as gravity leaves them."""

import numpy as np
from scipy.spatial import cKDTree
from virtual_patient.body import Body, Turns
from virtual_patient.lying import Tissue, back_on_table, belly_lying, breasts_lying, chest_wall

from breastrig.geometry.rotations import exp_so3

Array = np.ndarray

FOOTPRINT = 0.06  # share of the breast field from which on skin belongs to the breast
SLIDING = 0.09  # m around the breasts within which the skin slides along


def lie_down(body: Body, turns: Turns, tissue: Tissue, navel_height: float, behind: float) -> tuple[Array, float]:
    """((V, 3) m in body coordinates, the table's z in m); behind that depth (m) neither breast nor belly moves."""
    return back_on_table(sagged(body, turns, tissue, navel_height, behind), tissue)


def sagged(body: Body, turns: Turns, tissue: Tissue, navel_height: float, behind: float) -> Array:
    """(V, 3) m: breasts and belly as they are lying, the back still round."""
    posed, _ = body.posed(turns)
    footprint = body.breasts > FOOTPRINT
    away, _ = cKDTree(posed[footprint]).query(posed)
    region = (away < SLIDING) & (body.arms < 0.3) & (posed[:, 2] > behind)
    wall = chest_wall(posed, body.faces, footprint)
    result = breasts_lying(posed, body.faces, wall, region, tissue)
    trunk = np.clip(1.0 - 3.0 * body.arms, 0.0, 1.0)
    return belly_lying(result, trunk, navel=np.array([0.0, navel_height, 0.0]), back=behind, tissue=tissue)


def at_rest(vertices: Array, trunk: Array, waist: float) -> Array:
    """(V, 3) m: pitched so that the back of the (V,) bool trunk is as low above the waist's height as below it."""
    result = vertices
    for _ in range(5):  # the lowest points change a little with the pitch
        low, high = (
            result[trunk & half][result[trunk & half][:, 2].argmin()]
            for half in (vertices[:, 1] < waist, vertices[:, 1] >= waist)
        )
        pitch = np.arctan2(high[2] - low[2], high[1] - low[1])
        result = (result - low) @ exp_so3(np.array([pitch, 0.0, 0.0])) + low  # points are rows: this turns by -pitch
    return result

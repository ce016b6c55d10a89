"""The arms of a warped body moved as nobody of its source holds them: supine ones along her sides.

Where the arms are is the plainest sign of a stance, and each source has it in one way only.  The edges of the arms are
turned by a share of what turns them from one stance to the other (stances.py); the trunk with its breasts stays.
"""

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_array, diags_array
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from breastrig.core.arrays import Array
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.warped.body import WarpedBody
from breastrig_studies.virtual.warped.stances import carrier

INSIDE, BLEND = 0.035, 0.06  # m: where a supine body's arm begins beside its shoulder's tip, and becomes all arm
HELD, LOOSE = 10.0, 1e-9  # of vertices to their places, for edges of weight 1
ALONG = (0.65, 1.0)  # share of the way to hanging arms; on a table the trunk is wider
LOWER = (-0.07, 0.25)  # rad, by which elbows lie lower than the hanging ones
AWAY = (0.5, 1.1)  # share of the way to the arms of the supine source


def with_arms_along(body: WarpedBody, random: np.random.Generator) -> VirtualBody:
    """Lying, her arms along her sides."""
    return _moved(body, body.supine, body.standing, float(random.uniform(*ALONG)), float(random.uniform(*LOWER)))


def with_arms_away(body: WarpedBody, random: np.random.Generator) -> VirtualBody:
    """Standing, her arms away from her."""
    return _moved(body, body.standing, body.supine, float(random.uniform(*AWAY)), 0.0)


def _moved(body: WarpedBody, of: VirtualBody, to: VirtualBody, share: float, lower: float) -> VirtualBody:
    by = carrier(of.vertices, to.vertices, body.source.faces)
    i, j = by.edges.T
    weight = _arm(body.supine)
    on_edge = 0.5 * (weight[i] + weight[j])
    turned = Rotation.from_rotvec(Rotation.from_matrix(by.rotations).as_rotvec() * (share * on_edge)[:, None])
    lowered = Rotation.from_rotvec(np.outer(lower * on_edge, [1.0, 0.0, 0.0]))
    wanted = (lowered * turned).apply(of.vertices[j] - of.vertices[i])
    rows, count = np.arange(len(i)), len(weight)
    values, columns = np.repeat([-1.0, 1.0], len(i)), np.concatenate([i, j])
    ends = coo_array((values, (np.tile(rows, 2), columns)), shape=(len(i), count)).tocsr()
    hold = np.where(weight == 0.0, HELD, LOOSE)
    solver = splu((ends.T @ ends + diags_array(hold)).tocsc())
    vertices = solver.solve(np.ascontiguousarray(ends.T @ wanted + hold[:, None] * of.vertices))
    places = {name: at for name, at in body.source.landmarks(vertices).items() if name in of.landmarks}
    return replace(of, vertices=vertices, landmarks=places)


def _arm(lying: VirtualBody) -> Array:
    """(V,) 0 on the trunk to 1 on the arms, distinguished where they lie away."""
    sides = lying.vertices[:, 0]
    tips = np.where(sides > 0.0, lying.landmarks["acromion_L"][0], -lying.landmarks["acromion_R"][0])
    share = np.clip((np.abs(sides) - tips + INSIDE) / BLEND, 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))

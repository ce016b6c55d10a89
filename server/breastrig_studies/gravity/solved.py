"""The left breast of one body at rest in four positions: unloaded, standing, supine and prone.

Stiffness is drawn from published values (tissue.toml): it cannot be known of a patient who was only scanned.
"""

from contextlib import suppress

import numpy as np

from breastrig.core.arrays import Array
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.model import Rig
from breastrig.volume.breast_skin import breast_skins
from breastrig.volume.known_volume import known_volume
from breastrig.volume.tetrahedra import nodes_between
from breastrig_studies.gravity.soft_breast import DIRECTIONS, G, drawn, published, soft_breast
from breastrig_studies.gravity.statics import NoEquilibrium

STIFFER, TRIES = 2.0, 4
TILT = np.radians(5.0)  # standard deviation of how a trunk leans in any position


def solved(rig: Rig, vertices: Array, rng: np.random.Generator) -> dict[str, Array]:
    """Displacements (m) from (V, 3) m standing vertices, by position: of the left breast's skin and of its nodes.

    The tissue is made STIFFER, each time, where it does not come to rest: a breast with this shape is not so soft.
    Raises NoEquilibrium after TRIES.
    """
    table, soft, left = published(), soft_breast(rig, "L"), breast_skins(rig)[0]
    stiffness = drawn(table, rng.normal(size=4))
    wall = carried_wall(rig, vertices, float(rng.uniform(*table["depth"]["range"])))
    down, *others = (exp_so3(TILT * rng.normal(size=3)) @ (G * np.array(way)) for way in DIRECTIONS.values())
    points = nodes_between(rig, vertices, wall)[soft.nodes]
    for factor in STIFFER ** np.arange(TRIES):
        with suppress(NoEquilibrium):
            body = soft.body(points, stiffness.times(factor)).resting(down)
            ways = {"unloaded": np.zeros(3)} | dict(zip(("supine", "prone"), others, strict=True))
            moves = {name: body.at_rest(way, None, down) for name, way in ways.items()}
            return (
                {f"{name}_skin": soft.on(left.skin, moved) for name, moved in moves.items()}
                | {f"{name}_nodes": moved for name, moved in moves.items()}
                | {"given": vertices, "points": points, "stiffness": np.array([factor, *vars(stiffness).values()])}
            )
    raise NoEquilibrium("This shape does not stand, however stiff it is.")


def carried_wall(rig: Rig, vertices: Array, thickness: float) -> Array:
    """(V, 3) m: the rig's chest wall under a body of which only the (V, 3) m skin is known, `thickness` times as deep.

    It lies under the skin without the breasts.
    """
    known, count = known_volume(rig), len(rig.template)
    inwards = known.points[count : 2 * count] - known.chest.of(rig.template)
    return np.asarray(known.chest.of(vertices) + thickness * inwards)

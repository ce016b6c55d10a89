"""The areolae on a fitted scan with a texture: for the measures, whether or not they placed the nipples.

Colours of vertices are left out: their triangles are as large as the differences that matter.
"""

from collections.abc import Mapping

from breastrig.colour.areolae import ObservedAreola
from breastrig.colour.features.observation import Observation
from breastrig.core.arrays import Array
from breastrig.core.stances import SIDES
from breastrig.fitting.observed.landmarks import areola_of, expectations
from breastrig.rig.model import Rig
from breastrig.scan.scan import Scan

KNOWN = 0.006  # m, root mean square error of a fitted or picked nipple
NIPPLES = {f"nipple_{side}": side for side in SIDES}


def observed_areolae(
    rig: Rig,
    vertices: Array,
    picked: Mapping[str, Array],
    scan: Scan,
    observed: Mapping[str, Observation] | None = None,
) -> dict[str, ObservedAreola | None]:
    """Side -> the areola there, None where none is seen; empty for a scan without a texture.

    `vertices` (V, 3) m is the fitted model; landmarks count as `picked`.  `observed` is what was seen before the fit.
    """
    sides = {name: side for name, side in NIPPLES.items() if name in rig.landmark_names}
    if scan.colour_kind != "texture" or not sides:
        return {}
    from breastrig.colour.features.observe import observed_landmarks  # loads image filters

    if observed is None:
        body, expected = expectations(rig, vertices, dict.fromkeys(sides, KNOWN), picked)
        observed = observed_landmarks(scan, expected, body[:, 0], body[:, 1])
    found: dict[str, ObservedAreola | None] = {}
    for name, side in sides.items():
        found[side] = areola_of(observed[name]) if name in observed else None
    return found

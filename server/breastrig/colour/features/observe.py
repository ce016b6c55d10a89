"""Finds landmarks by colour on one scan, near the places where the body's form expects them.

Colour gives a precise place but not always its identity, the form the reverse. So features are searched near expected
places only, a place that the form excludes is not taken, and a landmark that cannot be seen (covered, reconstructed
without pigment, outside of the scan) is left to the form. Each side is searched at its own expected place, and both are
dropped where they would be swapped or coincide.
"""

from collections.abc import Mapping

import numpy as np

from breastrig.colour.features.crosses import between_crosses, marked_by_crosses
from breastrig.colour.features.limits import Features, features
from breastrig.colour.features.navel import find_navel
from breastrig.colour.features.nipple import find_nipple
from breastrig.colour.features.observation import (
    BETWEEN_CROSSES,
    CROSSED,
    NAVEL,
    NIPPLES,
    Expectation,
    Observation,
)
from breastrig.colour.features.patch import ColouredSkin
from breastrig.core.arrays import Array
from breastrig.core.errors import BreastRigError
from breastrig.scan.scan import Scan


def observed_landmarks(
    scan: Scan, expected: Mapping[str, Expectation], left: Array, up: Array
) -> dict[str, Observation]:
    """The `expected` landmarks that the colours show.

    Empty for a scan without any, with one colour everywhere, or with a broken picture. `left` and `up` (3,) are the
    body's unit directions in the scan's frame.
    """
    if not scan.shows_colour:
        return {}
    try:
        skin = ColouredSkin(scan)
    except BreastRigError:
        return {}
    found = _nipples(skin, expected, left, up, features())
    if NAVEL in expected:
        form = expected[NAVEL]
        navel = find_navel(skin, form.place, form.outwards, up, form.spread, features().navel)
        if navel is not None:
            found[NAVEL] = navel
    on_midline = {name: expected[name] for name in CROSSED if name in expected}
    crosses = marked_by_crosses(
        scan,
        {name: each.place for name, each in on_midline.items()},
        {name: each.spread for name, each in on_midline.items()},
        left,
        features().crosses,
        skin.image,
    )
    found |= crosses
    if BETWEEN_CROSSES in expected and len(crosses) == len(CROSSED):
        form = expected[BETWEEN_CROSSES]
        notch, xiphoid = (crosses[name] for name in CROSSED)
        middle = between_crosses(skin, notch, xiphoid, form.outwards, features().crosses.between)
        if middle is not None and np.linalg.norm(middle.place - form.place) < features().crosses.farthest * form.spread:
            found[BETWEEN_CROSSES] = middle
    return found


def _nipples(
    skin: ColouredSkin, expected: Mapping[str, Expectation], left: Array, up: Array, limits: Features
) -> dict[str, Observation]:
    rules, seen = limits.areola, {}
    for name in NIPPLES.values():
        if name not in expected:
            continue
        form = expected[name]
        spread = max(form.spread, rules.least_spread)
        nipple = find_nipple(skin, form.place, form.outwards, up, spread, rules)
        if nipple is not None:
            seen[name] = nipple
    if len(seen) == len(NIPPLES):
        apart = seen[NIPPLES["L"]].place - seen[NIPPLES["R"]].place
        if apart @ left < rules.least_apart:
            return {}
    return seen

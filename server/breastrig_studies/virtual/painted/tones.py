"""Colours of skin and of marks on it, in CIE Lab (D65): invented within the ranges of the literature.

Skin darkens and reddens towards the areola; how much of either depends on the tone. Each patient's colours are drawn
around those of the tone.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array

TONES = (1, 2, 3, 4, 5, 6)  # after Fitzpatrick
SKIN = {  # L, a, b
    1: (79.0, 8.0, 13.0),
    2: (74.0, 10.0, 16.0),
    3: (67.0, 12.0, 19.0),
    4: (58.0, 13.0, 21.0),
    5: (45.0, 13.0, 19.0),
    6: (33.0, 10.0, 13.0),
}
AREOLA = {  # shift from the skin: the lighter the skin the redder, the darker the darker
    1: (-8.0, 8.0, 1.0),
    2: (-10.0, 8.0, 1.0),
    3: (-12.0, 7.0, 0.0),
    4: (-13.0, 6.0, -1.0),
    5: (-11.0, 3.0, -3.0),
    6: (-8.0, 1.0, -3.0),
}
INKS = {  # the marker's own colour as a screen shows it, and its Lab on paper
    "violet": ("#4b2a7b", (27.0, 33.0, -39.0)),
    "black": ("#1f1d22", (11.0, 1.0, -3.0)),
    "blue": ("#22409a", (30.0, 20.0, -50.0)),
    "green": ("#1d6a48", (39.0, -31.0, 14.0)),
    "red": ("#a32430", (36.0, 50.0, 27.0)),
}


@dataclass(frozen=True, eq=False)
class Palette:
    """One patient's colours, (3,) Lab each."""

    tone: int
    skin: Array
    areola: Array
    nipple: Array
    mole: Array
    crease: Array  # of navel and folds


def draw_palette(tone: int, random: np.random.Generator) -> Palette:
    """A palette around the colours of a tone; some areolae are hardly darker than the skin, some much."""
    skin = np.array(SKIN[tone]) + random.normal(0.0, (1.8, 1.0, 1.3))
    areola = skin + np.array(AREOLA[tone]) * random.uniform(0.65, 1.5) + random.normal(0.0, (0.8, 0.8, 0.8))
    return Palette(
        tone=tone,
        skin=skin,
        areola=areola,
        nipple=areola + np.array([-0.05 * skin[0], 2.0, 0.0]),
        mole=np.array([0.45 * skin[0], 8.0, 10.0]),
        crease=np.array([0.55 * skin[0], skin[1] + 4.0, skin[2]]),
    )

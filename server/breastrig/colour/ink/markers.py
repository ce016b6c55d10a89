"""Which marker drew a stroke: its usual colour, from what it takes of the skin's light.

A thin line in a blurred picture is skin and ink mixed.  Whatever the share of the ink, the light that is missing, as a
share of the skin's in red, green and blue, has the direction of 1 - ink / skin.  This direction is compared with those
of the five markers that surgeons use, on skin as bright as this patient's where it is well lit.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array


@dataclass(frozen=True)
class Marker:
    name: str
    color: str  # "#rrggbb", how it is shown
    light: tuple[float, float, float]  # linear, of dry ink on paper


MARKERS = (
    Marker("violet", "#5b2a86", (0.07, 0.02, 0.18)),
    Marker("black", "#1c1c1e", (0.012, 0.012, 0.013)),
    Marker("blue", "#1f49a5", (0.012, 0.05, 0.31)),
    Marker("green", "#13694a", (0.006, 0.12, 0.06)),
    Marker("red", "#b3202a", (0.42, 0.012, 0.02)),
)


def marker_of(added: Array, skin: Array) -> Marker:
    """Of a stroke that adds densities (3,) to well-lit skin of densities (3,), red, green, blue."""
    missing = 1.0 - np.exp(-np.asarray(added))
    inks = 1.0 - np.array([marker.light for marker in MARKERS]) / np.exp(-np.asarray(skin))
    likeness = inks @ missing / np.linalg.norm(inks, axis=1)
    return MARKERS[int(np.argmax(likeness))]

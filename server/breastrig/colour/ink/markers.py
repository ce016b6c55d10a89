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


DOUBT = 0.012  # likenesses this close say nothing; a faint stroke is then of the marker that drew most
EXPOSURES = np.geomspace(0.25, 1.0, 9)  # light that white would send back in the picture; 1 is its brightest


def markers_of(added: Array, lengths: Array, skin: Array) -> list[Marker]:
    """Of N strokes that add densities (N, 3) over (N,) m to well-lit skin of densities (3,), red, green, blue.

    How bright the picture is as a whole is not known beforehand; the exposure under which the strokes look most
    like markers is taken, the same for all.
    """
    if not len(added):
        return []
    missing = 1.0 - np.exp(-added)
    missing /= np.maximum(np.linalg.norm(missing, axis=1, keepdims=True), 1e-9)
    light = np.array([marker.light for marker in MARKERS])
    inks = 1.0 - EXPOSURES[:, None, None] * light / np.exp(-skin)  # (E, 5, 3)
    inks /= np.linalg.norm(inks, axis=2, keepdims=True)
    likeness = np.einsum("eki,ni->enk", inks, missing)
    exposure = int(np.argmax(likeness.max(axis=2) @ lengths))
    looks = likeness[exposure]
    used = np.bincount(looks.argmax(axis=1), lengths, len(MARKERS))
    possible = looks >= looks.max(axis=1, keepdims=True) - DOUBT
    return [MARKERS[number] for number in np.where(possible, used, -1.0).argmax(axis=1)]

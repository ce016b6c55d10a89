"""Which of the marks that two scans share agree, and how much surer lines are near them.

The map without marks is off by a field that changes over some centimetres: at each mark it shows, but for the error of
the mark itself and for a share that no mark nearby knows.  So each mark is predicted from the others (kriging, leaving
it out); the one that is farthest from that, in standard deviations, is asked about and left out where no error explains
it, and the rest is looked at again.  The same field says how much of a line's variance is left beside the marks.

Evidence: docs/decisions/0034.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.drawings.skin_maps.settings import SkinMapSettings


@dataclass(frozen=True)
class SharedMarks:
    """The marks that two scans have under the same names."""

    followed: tuple[str, ...] = ()
    asked: tuple[tuple[str, float], ...] = ()  # contradicts the rest, with how far it is from there (m)


def agreeing(names: tuple[str, ...], places: Array, off: Array, settings: SkinMapSettings) -> SharedMarks:
    """The M marks at (M, 3) m places that are (M, 3) m off where the map expects them, apart from contradicting ones.

    How far maps are off differs between women: the others say it, Student's t (with mark_freedom before any is known).
    """
    kept, asked = list(range(len(names))), list[tuple[str, float]]()
    while kept:
        spread = np.full(len(kept), settings.mark_spread)
        inverse = np.linalg.inv(_covariance(places[kept], spread, settings))
        alone = np.diag(inverse)
        from_others = inverse @ off[kept] / alone[:, None]  # each one's distance from what the others say
        squares = np.sum(from_others**2, axis=1) * alone
        of_others = np.sum(off[kept] * (inverse @ off[kept])) - squares
        freedom = settings.mark_freedom + 2.0 * (len(kept) - 1)  # two axes of the skin
        deviations = np.sqrt(squares * freedom / (settings.mark_freedom + of_others))
        worst = int(deviations.argmax())
        if deviations[worst] <= settings.mark_limit:
            break
        asked.append((names[kept.pop(worst)], float(np.linalg.norm(from_others[worst]))))
    return SharedMarks(tuple(names[k] for k in kept), tuple(asked))


def left_over(points: Array, places: Array, spread: Array, settings: SkinMapSettings) -> Array:
    """(P,) share of the map's variance that is left at (P, 3) m points beside M marks at (M, 3) m.

    `spread` (M,) m is the map's standard deviation at the marks, on an axis of the skin.
    """
    between = settings.mark_share * _alike(points, places, settings) * spread
    explained = np.einsum("pm,mp->p", between, np.linalg.solve(_covariance(places, spread, settings), between.T))
    return np.asarray(1.0 - explained)


def _covariance(places: Array, spread: Array, settings: SkinMapSettings) -> Array:
    """(M, M) m² of what the map is off at the marks, on an axis."""
    shared = settings.mark_share * _alike(places, places, settings) * np.outer(spread, spread)
    return np.asarray(shared + np.diag((1.0 - settings.mark_share) * spread**2 + settings.mark_error**2))


def _alike(points: Array, places: Array, settings: SkinMapSettings) -> Array:
    """(P, M) correlations, 1 at the same place."""
    gaps = np.linalg.norm(points[:, None] - places, axis=2) / settings.mark_length
    return np.asarray(np.exp(-gaps))

"""Landmarks as programs give and get them: names with places in the scan's unit and frame."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from breastrig.core.arrays import Array, frozen
from breastrig.core.errors import BadLandmarks
from breastrig.core.units import METRES_PER_UNIT
from breastrig.interface.model import Model, loaded
from breastrig.interface.one_thread import one_thread
from breastrig.interface.scan import Scan, ScanSource
from breastrig.scan.landmark_files import landmark_confidences, read_landmarks
from breastrig.workflow.propose_on_scan import propose_on_scan


@dataclass(frozen=True, eq=False)
class Proposal:
    """Where a landmark probably is."""

    point: Array  # (3,) in the scan's unit and frame
    confidence: float  # 0 to 1; a person's own pick is 1
    on_scan: bool  # on skin that the scan shows


Landmarks = Mapping[str, ArrayLike | Proposal] | str | Path | None


def propose_landmarks(scan: Scan | str | Path, *, units: str = "auto", model: Model = None) -> dict[str, Proposal]:
    """A first guess of every landmark of the model, to be checked by a person: name -> Proposal.

    Each `point` (3,) is in the scan's unit and frame.  `units` belongs to a path, as in `read_scan`.  `fit` takes the
    answer, whole or in part, as its landmarks; they then pull as hard as their confidence says.

    Raises BadScan or another BadInput with one sentence.
    """
    found, _ = ScanSource(scan, units).read()
    with one_thread():
        proposals = propose_on_scan(loaded(model), found)
    return {
        name: Proposal(frozen(each.point / found.metres_per_unit), each.confidence, each.on_scan)
        for name, each in proposals.items()
    }


def landmarks_in_mm(given: Landmarks, scan: ScanSource) -> tuple[dict[str, list[float]], dict[str, float]]:
    """Places in mm in the scan's frame, and the confidences that stand beside them.

    A file without a unit of its own has the scan's; only then, or for places that a program gives, the scan is read.
    """
    if given is None:
        return {}, {}
    if isinstance(given, str | Path):
        places, unit = read_landmarks(Path(given))
        metres = METRES_PER_UNIT[unit] if unit else scan.read()[0].metres_per_unit
        found = {name: [1e3 * metres * float(value) for value in place] for name, place in places.items()}
        return found, landmark_confidences(Path(given))
    metres = scan.read()[0].metres_per_unit
    confidences = {name: each.confidence for name, each in given.items() if isinstance(each, Proposal)}
    return {name: _in_mm(name, each, 1e3 * metres) for name, each in given.items()}, confidences


def _in_mm(name: str, given: ArrayLike | Proposal, mm_per_unit: float) -> list[float]:
    try:
        place = np.asarray(given.point if isinstance(given, Proposal) else given, dtype=np.float64)
    except (TypeError, ValueError):
        place = np.zeros(0)
    if place.shape != (3,):
        raise BadLandmarks(f"The landmark {name} needs three finite numbers x y z.")
    return [mm_per_unit * float(value) for value in place]

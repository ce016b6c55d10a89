"""Landmarks: as programs give and get them, names with places in the scan's unit and frame; and proposed on a scan.

`propose_on_file` is the service's way in: it runs in a process of its own, as reading does, because the file is
untrusted; it gives back nothing but names and numbers.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from breastrig.core.arrays import Array, frozen
from breastrig.core.errors import BadLandmarks, BadScan
from breastrig.core.one_thread import one_thread
from breastrig.core.picks import Picks
from breastrig.core.proposed import why_not_proposed
from breastrig.core.stances import AUTO
from breastrig.fitting import propose
from breastrig.fitting.hypotheses import ScanOrientation, orientation_from
from breastrig.fitting.prepare_scan import prepared_scan
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.scan.hand_cuts import without_hand_cuts
from breastrig.scan.landmarks.landmark_files import landmarks_of_file
from breastrig.scan.read import coloured_scan
from breastrig.scan.scan import Scan as ScanInMetres
from breastrig.use.scan import Scan, ScanSource
from breastrig.use.values.model import Model, loaded


@dataclass(frozen=True, eq=False)
class Proposal:
    """A proposed landmark."""

    point: Array  # (3,) in the scan's unit and frame
    confidence: float  # 0 to 1; a person's own pick is 1
    on_scan: bool  # on skin that the scan shows; false where a breast or the scan's end hides it, and skin is near
    error: float | None = None  # in the scan's unit: the radius that holds the true place with 90 %; None: not known
    reason: str | None = None  # what shows it beside the body's form, as "areola seen"


class Proposals(dict[str, Proposal]):
    """Name -> Proposal; `not_proposed` says of every other landmark of the model why it is not there, in a sentence."""

    def __init__(self, proposed: Mapping[str, Proposal], not_proposed: Mapping[str, str]) -> None:
        super().__init__(proposed)
        self.not_proposed = MappingProxyType(dict(not_proposed))


Landmarks = Mapping[str, ArrayLike | Proposal] | str | Path | None
NOTHING: Mapping[str, ArrayLike] = MappingProxyType({})


def propose_landmarks(scan: Scan | str | Path, *, units: str = "auto", model: Model = None) -> Proposals:
    """A first guess of every landmark that the scan shows, to be checked by a person: name -> Proposal.

    Each `point` (3,) and its `error` are in the scan's unit and frame.  `units` belongs to a path, as in `read_scan`.
    `fit` takes the answer, whole or in part, as its landmarks, but is not pulled by what is only proposed: it comes
    from the same scan.  What a person has checked is given as a place: `proposal.point`.
    The answer's `not_proposed` names the other landmarks, each with a sentence why.

    Raises BadScan or another BadInput with one sentence.
    """
    found, _ = ScanSource(scan, units).read()
    with one_thread():
        guesses = propose_on_scan(loaded(model), found)
    why = {name: why_not_proposed(each.to_skin, each.error) for name, each in guesses.items()}
    proposed = {
        name: Proposal(
            frozen(each.point / found.metres_per_unit),
            each.confidence,
            each.on_scan,
            None if each.error is None else each.error / found.metres_per_unit,
            each.reason,
        )
        for name, each in guesses.items()
        if why[name] is None
    }
    return Proposals(proposed, {name: reason for name, reason in why.items() if reason is not None})


def landmarks_in_mm(
    given: Landmarks,
    scan: ScanSource,
    certain: Sequence[str] = (),
    marks: Mapping[str, ArrayLike] = NOTHING,
    scale: float = 1.0,
) -> Picks:
    """Places in mm, the confidences that stand beside them, and what is certain: `certain` and what the file names.

    `marks` are in the scan's unit and frame, and join those of the file; `scale` as in `landmarks_of_file`.

    A file without a unit of its own has the scan's; only then, or for places that a program gives, the scan is read.
    Raises BadLandmarks.
    """
    if isinstance(certain, str):
        raise BadLandmarks(f'certain must be a list of landmarks\' names, as in ["{certain[:100]}"].')
    found = Picks()
    if isinstance(given, str | Path):
        found = landmarks_of_file(Path(given), lambda: scan.read()[0].measured, scale=scale)
    found = replace(found, certain=(*found.certain, *certain))
    given = {} if given is None or isinstance(given, str | Path) else given
    if not given and not marks:
        return found
    if twice := found.marks_mm.keys() & marks.keys():
        raise BadLandmarks(f'The mark "{min(twice)}" stands twice, in the file and beside it; keep one.')
    metres = scan.read()[0].metres_per_unit
    own = {name: _in_mm("mark", name, each, 1e3 * metres) for name, each in marks.items()}
    confidences = {name: each.confidence for name, each in given.items() if isinstance(each, Proposal)}
    places_mm = {name: _in_mm("landmark", name, each, 1e3 * metres) for name, each in given.items()}
    return replace(
        found,
        points_mm=found.points_mm | places_mm,
        confidence=found.confidence | confidences,
        marks_mm=found.marks_mm | own,
    )


def _in_mm(kind: str, name: str, given: ArrayLike | Proposal, mm_per_unit: float) -> list[float]:
    try:
        place = np.asarray(given.point if isinstance(given, Proposal) else given, dtype=np.float64)
    except (TypeError, ValueError):
        place = np.zeros(0)
    if place.shape != (3,):
        raise BadLandmarks(f"The {kind} {name} needs three finite numbers x y z.")
    return [mm_per_unit * float(value) for value in place]


@dataclass(frozen=True)
class ProposeJob:
    """A scan to be searched for landmarks."""

    scan: Path
    file_type: str
    units: str
    model: Path | None = None  # None: the torso of the package
    orientation: dict[str, Any] | None = None  # what the upload has found, see fitting/hypotheses.py
    cuts: tuple[dict[str, Any], ...] = ()  # by hand, see scan/hand_cuts.py


def propose_on_scan(
    rig: Rig, scan: ScanInMetres, orientation: ScanOrientation | None = None
) -> dict[str, propose.Proposal]:
    """All landmarks of the rig, points in metres in the scan's own frame; `orientation` when it is known already."""
    ready = prepared_scan(scan, AUTO, None if orientation is None else orientation.frame)
    return propose.propose_landmarks(rig, ready, load_recipe("default"), orientation, scan)


def propose_on_file(job: ProposeJob) -> dict[str, Any]:
    """{name: {point (mm), confidence, on_scan, error_mm, reason, to_skin_mm}}, ready for JSON.

    Raises a BreastRigError with a sentence.
    """
    try:
        rig = read_rig(job.model or default_rig_path())
        scan = without_hand_cuts(coloured_scan(job.scan, job.file_type, job.units), job.cuts)
        proposals = propose_on_scan(rig, scan, orientation_from(job.orientation, rig))
    except MemoryError as error:
        raise BadScan("Finding landmarks on this scan needs more memory than it may use; simplify it first.") from error
    return {
        name: {
            "point": [round(1e3 * float(value), 3) for value in proposal.point],
            "confidence": proposal.confidence,
            "on_scan": proposal.on_scan,
            "error_mm": None if proposal.error is None else round(1e3 * proposal.error, 1),
            "reason": proposal.reason,
            "to_skin_mm": round(1e3 * proposal.to_skin, 1),
        }
        for name, proposal in proposals.items()
    }

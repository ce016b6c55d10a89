"""Landmarks proposed on one scan: from a scan to points in its own frame.

`propose_on_file` is the service's way in: it runs in a process of its own, as reading does, because the file is
untrusted; it gives back nothing but names and numbers.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from breastrig.core.errors import BadScan
from breastrig.core.stances import AUTO
from breastrig.fitting.hypotheses import ScanOrientation, orientation_from
from breastrig.fitting.prepare_scan import prepared_scan
from breastrig.fitting.propose import Proposal, propose_landmarks
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.scan.hand_cuts import without_hand_cuts
from breastrig.scan.read import coloured_scan
from breastrig.scan.scan import Scan


@dataclass(frozen=True)
class ProposeJob:
    """A scan to be searched for landmarks."""

    scan: Path
    file_type: str
    units: str
    model: Path | None = None  # None: the torso of the package
    orientation: dict[str, Any] | None = None  # what the upload has found, see fitting/hypotheses.py
    cuts: tuple[dict[str, Any], ...] = ()  # by hand, see scan/hand_cuts.py


def propose_on_scan(rig: Rig, scan: Scan, orientation: ScanOrientation | None = None) -> dict[str, Proposal]:
    """All landmarks of the rig, points in metres in the scan's own frame; `orientation` when it is known already."""
    ready = prepared_scan(scan, AUTO, None if orientation is None else orientation.frame)
    return propose_landmarks(rig, ready, load_recipe("default"), orientation, scan)


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

"""Whether two fits can be of one body: lengths between bones that no stance changes, against what they may be off.

Of nine pairs of stances of one body (four virtual patients and the example, picked and not) the first two lengths
changed by up to 19 and 11 mm, no more than their errors allow; of twenty pairs of two picked bodies fourteen differ by
more.  Shoulders come up to 115 mm nearer when the arms are raised lying down, so they count between standing scans.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.workflow.folder.fit_folder import FitFolder


@dataclass(frozen=True)
class Bone:
    """A length that belongs to a body."""

    start: str
    end: str
    said: str
    change: float  # m, by which it may differ between two scans of one body, apart from the landmarks' errors
    standing_only: bool = False


BONES = (
    Bone("suprasternal_notch", "xiphoid", "from the notch to the xiphoid", 0.012),
    Bone("suprasternal_notch", "umbilicus", "from the notch to the umbilicus", 0.025),  # the spine bends
    Bone("acromion_L", "acromion_R", "between the shoulders", 0.025, standing_only=True),
)


def body_doubt(a: FitFolder, b: FitFolder) -> str | None:
    """A sentence where the two are not likely to be of one patient; None where nothing says so, or it is not known."""
    (there, off_there), (here, off_here) = _landmarks(a), _landmarks(b)
    known = there.keys() & off_there.keys() & here.keys() & off_here.keys()
    stands = a.stance == b.stance == "standing"
    for bone in BONES:
        if not {bone.start, bone.end} <= known or (bone.standing_only and not stands):
            continue
        first, second = (float(np.linalg.norm(places[bone.start] - places[bone.end])) for places in (there, here))
        offs = [off[end] for off in (off_there, off_here) for end in (bone.start, bone.end)]
        allowed = float(np.hypot(np.linalg.norm(offs), bone.change))
        if abs(first - second) > allowed:
            return (
                f"Are both scans of one patient? It is {1e3 * first:.0f} mm {bone.said} on the {a.stance} scan and "
                f"{1e3 * second:.0f} mm on the {b.stance} one; {1e3 * allowed:.0f} mm are explained by their errors. "
                "Check the scans, or these landmarks."
            )
    return None


def _landmarks(fit: FitFolder) -> tuple[dict[str, Array], dict[str, float]]:
    """(3,) m places, as picked or seen, else of the model; and m, the radii that hold the true ones with 90 %."""
    model = {name: fit.metres_per_unit * np.array(place) for name, place in fit.result.landmarks.items()}
    radii = fit.result.landmark_uncertainty_mm
    return model | fit.seen | fit.landmarks, {name: 1e-3 * radius for name, radius in radii.items()}

"""Whether two fits can be of one body: lengths between bones that no stance changes, against what they may be off.

Of nine pairs of stances of one body (four virtual patients and the example, picked and not) the first two lengths
changed by up to 19 and 11 mm, no more than their errors allow; of twenty pairs of two picked bodies fourteen differ by
more.  Shoulders come up to 115 mm nearer when the arms are raised lying down, so they count between standing scans.

Without picks those errors explain everything.  The model's own proportions say more: of eleven virtual women, standing
and lying, scans of one differed by up to 5.2 % from notch to umbilicus and 8.7 % in the pelvis's breadth, found without
and with landmarks; the limits are a quarter above.  Half of the pairs of two women exceed them (76 of 138 without
landmarks), none of the 19 of one: like proportions go unnoticed.  Prone scans show too little of a trunk.
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
    Bone("suprasternal_notch", "xiphoid", "from the notch to the xiphoid", 0.018),  # its skin slides when lying
    Bone("suprasternal_notch", "umbilicus", "from the notch to the umbilicus", 0.025),  # the spine bends
    Bone("acromion_L", "acromion_R", "between the shoulders", 0.025, standing_only=True),
)


LONGER, BROADER = 0.065, 0.11  # natural logarithm of the ratio
KNOWN_WITHIN_MM = 60.0  # 90 % radius of a place beyond which the model's proportions say nothing of this patient


def body_doubt(a: FitFolder, b: FitFolder) -> str | None:
    """A sentence where the two are not likely to be of one patient; None where nothing says so, or it is not known."""
    if a.result.scan.sha256 == b.result.scan.sha256 and a.stance != b.stance and not _is_predicted(a, b):
        both = f"{a.stance} and as {b.stance}"
        return f"Both fits are of the same scan file, as {both}. Choose the scan of the other stance."
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
    return _proportions(a, b, (there, here), (off_there, off_here))


def _proportions(
    a: FitFolder, b: FitFolder, places: tuple[dict[str, Array], ...], offs: tuple[dict[str, float], ...]
) -> str | None:
    ends = ("suprasternal_notch", "umbilicus")
    is_known = all(1e3 * off.get(end, np.inf) < KNOWN_WITHIN_MM for off in offs for end in ends)
    if "prone" in (a.stance, b.stance) or _is_predicted(a, b) or not is_known:
        return None
    lengths = [float(np.linalg.norm(place[ends[0]] - place[ends[1]])) for place in places]
    if abs(np.log(lengths[0] / lengths[1])) > LONGER:
        return (
            f"Are both scans of one patient? It is {1e3 * lengths[0]:.0f} mm from the notch to the umbilicus on the "
            f"{a.stance} scan and {1e3 * lengths[1]:.0f} mm on the {b.stance} one. Check the scans, or these landmarks."
        )
    breadths = [bone.scale[0] for fit in (a, b) for bone in fit.result.parameters.bones if bone.name == "pelvis"]
    if len(breadths) == 2 and abs(np.log(breadths[0] / breadths[1])) > BROADER:
        more = 100.0 * abs(breadths[0] / breadths[1] - 1.0)
        return (
            f"Are both scans of one patient? The pelvis differs by {more:.0f} % in breadth between the {a.stance} and "
            f"the {b.stance} scan. Check the scans."
        )
    return None


def _is_predicted(a: FitFolder, b: FitFolder) -> bool:
    return a.result.predicted or b.result.predicted


def _landmarks(fit: FitFolder) -> tuple[dict[str, Array], dict[str, float]]:
    """(3,) m places, as picked or seen, else of the model; and m, the radii that hold the true ones with 90 %."""
    model = {name: fit.metres_per_unit * np.array(place) for name, place in fit.result.landmarks.items()}
    radii = fit.result.landmark_uncertainty_mm
    return model | fit.seen | fit.landmarks, {name: 1e-3 * radius for name, radius in radii.items()}

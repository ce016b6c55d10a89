"""What two fits say of the marks that both of their scans have: followed, asked about, or on one of them alone."""

from typing import Any

from breastrig.core.errors import BadDrawing
from breastrig.drawings.skin_maps.skin_map import shared_marks
from breastrig.use.folder.fit_folder import FitFolder


def marks_between(source: FitFolder, goal: FitFolder) -> dict[str, Any]:
    """{followed: names, asked: [{name, says}], unpaired: names} of the marks of both scans.

    Empty without any, and where a fit is off its scan.
    """
    a, b = source.fitted_scan, goal.fitted_scan
    if not a.marks and not b.marks:
        return {}
    try:
        found = shared_marks(source.rig, a, b)
    except BadDrawing:  # which is said of each line
        return {}
    asked = [{"name": name, "says": _question(name, off, source, goal)} for name, off in found.asked]
    return {"followed": list(found.followed), "asked": asked, "unpaired": sorted(a.marks.keys() ^ b.marks.keys())}


def _question(name: str, off: float, source: FitFolder, goal: FitFolder) -> str:
    return (
        f"The mark {name} is {1e3 * off:.0f} mm from where the {source.stance} scan and all other marks expect it on "
        f"the {goal.stance} scan, and was not followed. Is it the same place on both?"
    )

"""The stances in which a patient may be scanned, and the sides of the body, which are the patient's own."""

from typing import Literal, get_args

Stance = Literal["standing", "supine", "prone"]  # prone: of a breast MRI, on the front, breasts hanging, arms overhead

AUTO = "auto"  # it is to be found
STANDING, SUPINE, PRONE = "standing", "supine", "prone"
STANCES = (AUTO, *get_args(Stance))

SIDES = {"L": "left", "R": "right"}
OUTWARDS = {"L": 1.0, "R": -1.0}  # along the patient's left: away from the median plane


def split_side(name: str) -> tuple[str, str]:
    """nipple_L: (nipple, L); xiphoid, which has no side: (xiphoid, "")."""
    stem, _, side = name.rpartition("_")
    return (stem, side) if stem and side in SIDES else (name, "")


def sides_of(asked: str) -> tuple[str, ...]:
    """The sides, L, R or both, of a drawing's `side`."""
    return tuple(SIDES) if asked == "both" else (asked,)

"""Names of lines and landmarks for people."""

import re
from collections.abc import Collection, Sequence

from breastrig.core.stances import SIDES, split_side

LINES = {  # lines of the patterns, and of the plan, without their side
    "wise": "Wise pattern",
    "wise_fold": "New fold",
    "areola": "Areola to keep",
    "new_nipple": "New nipple",
    "tumour": "Tumour",
    "vertical": "Vertical pattern",
    "periareolar": "Outer ring",
    "mastectomy": "Mastectomy ellipse",
}


def sided(name: str) -> tuple[str, str]:
    """wise_fold_L: (wise_fold, left); xiphoid: (xiphoid, "")."""
    stem, dot, more = name.partition(" ")  # "tumour_L 2", "cut (standing)"
    stem, side = split_side(stem)
    return stem + dot + more, SIDES.get(side, "")


def spoken(name: str) -> str:
    """tumour_L: Tumour, left; suprasternal_notch: Suprasternal notch."""
    stem, side = sided(name)
    head, space, more = stem.partition(" ")
    words = LINES.get(head) or head.replace("_", " ")
    words = words[:1].upper() + words[1:] + space + more
    return f"{words}, {side}" if side else words


PARAMETER = re.compile(r" \([a-z]+(?:_[a-z]+)+\)")  # which a sentence names for programs: (limb_mm)


def plainly(sentence: str, landmarks: Collection[str] = ()) -> str:
    """The sentence without internal names: no (limb_mm), and Left nipple for nipple_L."""

    def words(found: re.Match[str]) -> str:
        stem, side = sided(found[0])
        text = f"{side} {stem}".lstrip().replace("_", " ")
        return text if found.start() else text[:1].upper() + text[1:]

    names = "|".join(map(re.escape, landmarks))
    without = PARAMETER.sub("", sentence)
    return re.sub(rf"\b(?:{names})\b", words, without) if names else without


def spoken_together(names: Sequence[str]) -> list[str]:
    """nipple_L and nipple_R: nipple on both sides."""
    sides: dict[str, list[str]] = {}
    for name in names:
        stem, side = sided(name)
        sides.setdefault(stem.replace("_", " "), []).append(side)
    return [stem + (" on both sides" if len(found) > 1 else f" {found[0]}".rstrip()) for stem, found in sides.items()]

"""Marks: named places on the skin beside the model's landmarks, as moles, dots and ends of pen lines.

A name that a landmark has, or nearly has, is no mark's: nobody could say later which of the two was meant.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches

from breastrig.core.errors import BadLandmarks
from breastrig.core.picks import Picks
from breastrig.scan.landmarks.names import by_known_names, known_name

NEAR = 0.85  # of difflib's ratio: nippel_L and nipple_l2 are near nipple_L (0.87, 0.94), mid_sternum_dot is not (0.84)
LISTED = 12  # names in one sentence


def with_marks(picks: Picks, known: Mapping[str, Iterable[str]]) -> Picks:
    """The picks under the names of `known` landmarks (name -> synonyms), with the marks that stand among them apart.

    Raises BadLandmarks for a name that stands twice, and for a mark's that a landmark has or nearly has.
    """
    points = by_known_names(picks.points_mm, known)
    others = {name: place for name, place in points.items() if name not in known} if picks.open_names else {}
    check_mark_names((*others, *picks.marks_mm), known)
    if twice := others.keys() & picks.marks_mm.keys():
        raise BadLandmarks(f'The mark "{min(twice)}" stands twice; keep one.')
    certain = tuple(known_name(name, known) for name in picks.certain)
    return replace(
        picks,
        points_mm={name: place for name, place in points.items() if name not in others},
        certain=certain,
        confidence=by_known_names(picks.confidence, known),
        marks_mm={**others, **picks.marks_mm},
        open_names=False,
    )


def check_mark_names(names: Iterable[str], known: Mapping[str, Iterable[str]]) -> None:
    """Raises BadLandmarks for a name that cannot be shown, and for one that is a landmark's or near one."""
    folded = {landmark.casefold(): landmark for landmark in known}
    for name in names:
        if name != name.strip() or not name or not name.isprintable():
            raise BadLandmarks("A mark in these landmarks has no proper name; give each mark a name of its own.")
        meant = known_name(name, known)
        near = [meant] if meant in known else get_close_matches(name.casefold(), folded, n=1, cutoff=NEAR)
        if near:
            landmark = folded.get(near[0], near[0])
            raise BadLandmarks(
                f'Is "{name}" the landmark {landmark}? If so, name it {landmark}; if not, give the mark another name.'
            )


def listed(names: Sequence[str]) -> str:
    """The names for a sentence, the first ones of many."""
    more = [f"{len(names) - LISTED} more"] if len(names) > LISTED else []
    return ", ".join([*names[:LISTED], *more])

"""Numbers that differ from the right to the left: `areola_mm_left=38` beside `areola_mm=42`, which holds for the other.

Only parameters are written so; each breast is constructed by its own landmarks in any case.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from breastrig.core.stances import SIDES
from breastrig.drawings.clock import FittedSkin
from breastrig.rig.model import DrawnShape

SIDE_BY_WORD = {word: side for side, word in SIDES.items()}
Parameters = Mapping[str, float | str]


class Drawable(Protocol):
    """What draws itself on a skin."""

    def drawn(self, skin: FittedSkin) -> tuple[DrawnShape, ...]:
        """Its lines."""


OneSided = TypeVar("OneSided", bound=Drawable)


@dataclass(frozen=True)
class Apart(Generic[OneSided]):
    """A pattern of both breasts whose numbers differ: one of each side."""

    sides: tuple[tuple[str, OneSided], ...]  # L, R

    def drawn(self, skin: FittedSkin) -> tuple[DrawnShape, ...]:
        """The lines of both sides; BadDrawing where one does not fit."""
        return tuple(shape for _, one in self.sides for shape in one.drawn(skin))


def parted(key: str) -> tuple[str, str]:
    """areola_mm_left: (areola_mm, L); areola_mm: (areola_mm, "")."""
    stem, _, word = key.rpartition("_")
    side = SIDE_BY_WORD.get(word, "")
    return (stem, side) if side else (key, "")


def are_apart(parameters: Parameters) -> bool:
    """Whether one of the parameters is of one side alone."""
    return any(parted(key)[1] for key in parameters)


def of_side(parameters: Parameters, side: str) -> dict[str, float | str]:
    """The parameters of a pattern of this side alone, under their own names."""
    both = {key: value for key, value in parameters.items() if not parted(key)[1]}
    own = {stem: value for key, value in parameters.items() for stem, of in [parted(key)] if of == side}
    return {**both, **own, "side": side}


def put_apart(values: Mapping[str, float], side: str) -> dict[str, float]:
    """Parameters as those of this side alone."""
    return {f"{key}_{SIDES[side]}": value for key, value in values.items()}

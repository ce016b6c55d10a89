"""A person's landmarks on one scan, as they are stored and given to a fit."""

from dataclasses import dataclass, field

Points = dict[str, list[float]]  # landmark name -> x, y, z in mm, scan frame


@dataclass(frozen=True)
class Picks:
    points_mm: Points = field(default_factory=dict)
    certain: tuple[str, ...] = ()  # names of those that a fit follows whatever all else says
    confidence: dict[str, float] = field(default_factory=dict)  # 0 to 1, of those that were proposed; absent: placed

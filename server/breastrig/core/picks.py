"""A person's landmarks and marks on one scan, as they are stored and given to a fit."""

from dataclasses import dataclass, field, replace

Points = dict[str, list[float]]  # name -> x, y, z in mm, scan frame


@dataclass(frozen=True)
class Picks:
    points_mm: Points = field(default_factory=dict)
    certain: tuple[str, ...] = ()  # names of those that a fit follows whatever all else says
    confidence: dict[str, float] = field(default_factory=dict)  # 0 to 1, of those that were proposed; absent: placed
    marks_mm: Points = field(default_factory=dict)  # places on the skin of any name: moles, dots, ends of pen lines
    open_names: bool = False  # whether points of names that no landmark has are marks, as in tables of other programs

    def times(self, factor: float) -> "Picks":
        """Each coordinate times the factor."""
        if factor == 1.0:
            return self
        points, marks = (
            {name: [factor * value for value in place] for name, place in each.items()}
            for each in (self.points_mm, self.marks_mm)
        )
        return replace(self, points_mm=points, marks_mm=marks)


PLACES = "one place", "another"  # in sentences, for ends of a length that have no name


@dataclass(frozen=True)
class Length:
    """A straight length that was measured on the patient, between two landmarks or marks."""

    start: str
    end: str
    mm: float

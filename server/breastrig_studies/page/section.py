"""The page as data: a question that a reader has, the answer in sentences with measured numbers, figures and tables.

Every number in a sentence is computed from the records or tables; none is written down.
"""

from dataclasses import dataclass

from breastrig_studies.page.figures import HEADINGS


@dataclass(frozen=True)
class Section:
    """One question with its answer."""

    anchor: str
    question: str
    about: str  # what was done, one or two sentences without numbers of the result
    answers: tuple[str, ...]  # one a family, with the numbers
    figures: tuple[str, ...] = ()
    tables: tuple[str, ...] = ()


def mm(number: float | None, digits: int = 2) -> str:
    """A length for a sentence."""
    return "not known" if number is None else f"{number:.{digits}f}\u00a0mm"


def capital(family: str) -> str:
    """The family, by its key or as tables have it, at the start of a sentence."""
    heading = HEADINGS[family.lower()]
    return heading[0].upper() + heading[1:]

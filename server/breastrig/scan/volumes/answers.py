"""A person's answers about a volume whose file leaves them open: frame, segments, series."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeGuard

from breastrig.core.errors import BadSettings

TakenAs = Literal["lesion", "tissue", "unused"]
TAKEN_AS: tuple[TakenAs, ...] = ("lesion", "tissue", "unused")
FORMS = ("sform", "qform")
MOST_SEGMENTS = 1000  # numbers in an answer; a label map has at most 255
MOST_CHARACTERS = 20_000  # of an answer as JSON
HOW = "say as what each segment is to be taken by its number: " + ", ".join(f"2={each}" for each in TAKEN_AS)


@dataclass(frozen=True)
class VolumeAnswers:
    """Checked by `checked_answers`."""

    frame: str | None = None  # sform, qform, or nibabel's axis codes: RAS
    segments: Mapping[int, TakenAs] = field(default_factory=dict)  # number -> as what it is to be taken
    series: str | None = None  # of several in DICOM files: a value of the question
    same_place: bool | None = None  # whether a file of lesions lies where the image does

    def __bool__(self) -> bool:
        return self != NOTHING_SAID

    @property
    def without_lesions(self) -> "VolumeAnswers":
        """Those about the image itself where segments and place are of a file of lesions."""
        return replace(self, segments={}, same_place=None)


NOTHING_SAID = VolumeAnswers()


def checked_answers(
    frame: str | None,
    segments: Mapping[Any, Any] | None = None,
    series: str | None = None,
    same_place: bool | str | None = None,
) -> VolumeAnswers:
    """The answers, with numbers as text where JSON has them so.  Raises BadSettings with a sentence."""
    chosen = {_number(number): _taken_as(what) for number, what in (segments or {}).items()}
    return VolumeAnswers(
        _frame(frame) if frame else None,
        chosen,
        series.strip().lower() if series else None,
        _yes_or_no(same_place),
    )


def segments_of_words(words: Iterable[str]) -> dict[int, TakenAs]:
    """Parses 2=lesion, ... Raises BadSettings with a sentence."""
    return {_number(number): _taken_as(what) for number, _, what in (word.partition("=") for word in words)}


def segments_of_json(text: str | None) -> dict[int, TakenAs]:
    """Parses {"2": "lesion", ...}. Raises BadSettings with a sentence."""
    if not text:
        return {}
    try:
        found = json.loads(text[:MOST_CHARACTERS])
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict) or len(found) > MOST_SEGMENTS:
        raise BadSettings(f'This is no answer about segments; {HOW}, as JSON: {{"2": "lesion"}}.')
    return {_number(number): _taken_as(what) for number, what in found.items()}


def _frame(text: str) -> str:
    letters = text.upper()
    if text.lower() in FORMS:
        return text.lower()
    if len(letters) == 3 and {frozenset(pair) & frozenset(letters) for pair in ("LR", "PA", "IS")} == {
        frozenset(letter) for letter in letters
    }:
        return letters
    raise BadSettings(
        "This is no frame; give sform, qform, or three letters that say where the voxels' axes grow to: "
        "RAS is right, front (anterior), head (superior)."
    )


def _yes_or_no(given: bool | str | None) -> bool | None:
    if given is None or isinstance(given, bool):
        return given
    if given not in ("yes", "no"):
        raise BadSettings("Whether lesions and image lie in the same place is said with yes or no.")
    return given == "yes"


def _number(given: Any) -> int:
    try:
        return int(str(given))
    except ValueError:
        raise BadSettings(f"A segment's number must be a whole number; {HOW}.") from None


def _taken_as(given: Any) -> TakenAs:
    if not _is_known(given):
        raise BadSettings(f"A segment can be lesion, tissue or unused; {HOW}.")
    return given


def _is_known(given: Any) -> TypeGuard[TakenAs]:
    return given in TAKEN_AS

"""Landmarks by the names that people write: other case, spaces, hyphens, left and right in words, Latin."""

import re
import unicodedata
from collections.abc import Iterable, Mapping
from typing import TypeVar

from breastrig.core.errors import BadLandmarks

SIDE_WORDS = {
    **dict.fromkeys(("l", "left", "lt", "links", "sinistra", "sinister"), "l"),
    **dict.fromkeys(("r", "right", "rt", "rechts", "dextra", "dexter"), "r"),
}
Value = TypeVar("Value")


def known_name(written: str, known: Mapping[str, Iterable[str]]) -> str:
    """The landmark that is meant, of those that are `known` with what else they are called; else what is written."""
    if written in known:
        return written
    wanted = _key(written)
    meant = {name for name, others in known.items() if wanted in {_key(name), *(_key(other) for other in others)}}
    return meant.pop() if len(meant) == 1 else written


def by_known_names(places: Mapping[str, Value], known: Mapping[str, Iterable[str]]) -> dict[str, Value]:
    """The same under known names.  BadLandmarks when two are one landmark."""
    found: dict[str, Value] = {}
    for written, place in places.items():
        name = known_name(written, known)
        if name in found:
            raise BadLandmarks(f'The landmark "{name}" stands twice in this file, once as "{written}"; keep one.')
        found[name] = place
    return found


def _key(text: str) -> tuple[str, str]:
    """(the words without spaces, signs and accents; the side)"""
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text)
    plain = unicodedata.normalize("NFKD", parted).encode("ascii", "ignore").decode().casefold()
    words = re.findall(r"[a-z]+|\d+", plain)
    sides = {SIDE_WORDS[word] for word in words if word in SIDE_WORDS}
    return "".join(word for word in words if word not in SIDE_WORDS), "".join(sorted(sides))

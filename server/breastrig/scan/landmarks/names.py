"""Recognises landmarks by their usual names: other case, spaces, hyphens, sides in words, Latin, German, French."""

import re
import tomllib
import unicodedata
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from breastrig.core.errors import BadLandmarks

WORDS = Path(__file__).with_name("names.toml")
SIDED = re.compile(r"(.+)_([LR])")  # a name of the model's
ELISION = re.compile(r"\b[ld]['\u2019]", re.IGNORECASE)  # l'ombilic
Value = TypeVar("Value")


def known_name(written: str, known: Mapping[str, Iterable[str]]) -> str:
    """The landmark of `known` (name -> synonyms) that a written name means; the written name where none fits."""
    if written in known:
        return written
    wanted = _key(written)
    meant = {
        name
        for name, others in known.items()
        if wanted in {_key(name), *(_key(other) for other in others), *_other_keys(name)}
    }
    return meant.pop() if len(meant) == 1 else written


def by_known_names(places: Mapping[str, Value], known: Mapping[str, Iterable[str]]) -> dict[str, Value]:
    """The values under known names. Raises BadLandmarks when two names mean the same landmark."""
    found: dict[str, Value] = {}
    for written, place in places.items():
        name = known_name(written, known)
        if name in found:
            raise BadLandmarks(f'The landmark "{name}" stands twice in this file, once as "{written}"; keep one.')
        found[name] = place
    return found


def _key(text: str) -> tuple[str, str]:
    """(the words without spaces, signs and accents; the side)"""
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", ELISION.sub("", text))
    plain = unicodedata.normalize("NFKD", parted).encode("ascii", "ignore").decode().casefold()
    words = re.findall(r"[a-z]+|\d+", plain)
    sides, ignored = _sides(), _words()["ignored"]["words"]
    rest = "".join(word for word in words if word not in sides and word not in ignored)
    return re.sub(r"([aou])e", r"\1", rest), "".join(sorted({sides[word] for word in words if word in sides}))


@lru_cache(maxsize=1)
def _words() -> dict[str, dict[str, Any]]:
    return tomllib.loads(WORDS.read_text("utf-8"))


@lru_cache(maxsize=1)
def _sides() -> dict[str, str]:
    """l or r for each word of a side."""
    return {word: side for side, words in _words()["sides"].items() for word in words}


@lru_cache(maxsize=256)
def _other_keys(name: str) -> frozenset[tuple[str, str]]:
    """The keys of a landmark's synonyms."""
    sided = SIDED.fullmatch(name)
    base, side = (sided[1], f" {sided[2]}") if sided else (name, "")
    return frozenset(_key(word + side) for word in _words()["landmarks"].get(base, ()))

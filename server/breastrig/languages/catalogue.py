"""The catalogue of one language: its msgids, made ready to be found again in finished sentences.

msgids have numbered places, {0}, or with the format that the program gives a number, {0:.1f}: only numbers stand there.
A .po file is read as it is, so that a checkout needs no compiled one; tests read it with Babel and find the same.
"""

import json
import re
from collections import defaultdict
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import resources
from typing import Literal, get_args

Language = Literal["en", "de"]
ENGLISH: Language = "en"
LANGUAGES: tuple[Language, ...] = get_args(Language)
PLACE = re.compile(r"\{(\d+)(:[^{}]*)?\}")
NUMBER = r"[-+−]?(?:\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?|nan|inf)"
ENTRY = re.compile(r'^msgid ((?:".*"\n)+)msgstr ((?:".*"\n?)+)', re.MULTILINE)


@dataclass(frozen=True)
class Message:
    """One msgid with places."""

    text: str  # the translation
    own: tuple[str, ...]  # what stands before, between and after the places
    places: tuple[tuple[str, bool], ...]  # number, whether a number stands there

    @cached_property
    def longest(self) -> str:
        return max(self.own, key=len)

    @cached_property
    def known(self) -> int:
        """Characters that are its own."""
        return sum(map(len, self.own))

    @cached_property
    def pattern(self) -> re.Pattern[str]:
        places = [f"({NUMBER})" if is_number else "(.*?)" for _, is_number in self.places]
        both = zip(map(re.escape, self.own), [*places, ""], strict=True)
        return re.compile("".join(own + place for own, place in both), re.DOTALL)

    def is_quoted(self, k: int) -> bool:
        """Whether quotation marks are around the k-th place: somebody's own word."""
        return self.own[k][-1:] in tuple('"“') and self.own[k + 1][:1] in tuple('"”')


@dataclass(frozen=True)
class Catalogue:
    """The messages of one language."""

    words: dict[str, str]  # those without places
    messages: dict[str, tuple[Message, ...]]  # by first word; "": those that begin with a place

    def like(self, text: str) -> tuple[Message, ...]:
        """The messages that may be this text."""
        return (*self.messages.get(text.partition(" ")[0], ()), *self.messages.get("", ()))


@cache
def catalogue(language: str) -> Catalogue:
    """The catalogue of one of LANGUAGES, read once."""
    words: dict[str, str] = {}
    messages: dict[str, list[Message]] = defaultdict(list)
    for msgid, text in entries(language).items():
        if PLACE.search(msgid):
            first, space, _ = PLACE.split(msgid)[0].partition(" ")
            messages[first if space else ""].append(_message(msgid, text))
        elif msgid and text:
            words[_plain(msgid)] = _plain(text)
    return Catalogue(words, {first: tuple(found) for first, found in messages.items()})


def entries(language: str) -> dict[str, str]:
    """All msgids with their translations, which are empty where there is none yet; none of English."""
    if language == ENGLISH:
        return {}
    file = resources.files(__package__).joinpath(language, "LC_MESSAGES", "breastrig.po")
    return {_joined(msgid): _joined(text) for msgid, text in ENTRY.findall(file.read_text("utf-8"))}


def _joined(lines: str) -> str:
    """The text of quoted lines; PO has the escapes of JSON."""
    return "".join(json.loads(line) for line in lines.splitlines())


def _plain(text: str) -> str:
    return text.replace("{{", "{").replace("}}", "}")


def _message(msgid: str, text: str) -> Message:
    parts = PLACE.split(msgid)
    return Message(text, tuple(map(_plain, parts[::3])), tuple(zip(parts[1::3], map(bool, parts[2::3]), strict=True)))

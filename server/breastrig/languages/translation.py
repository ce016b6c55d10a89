"""Finished English sentences in another language.

Of all ways to read a text as messages of the catalogue the one counts in which most characters are a message's own.
What no message is, stays English: a test finds it before anybody reads it (tests/languages).
"""

import re
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from breastrig.languages.catalogue import ENGLISH, Message, catalogue

LONGEST = 5000  # characters; longer texts are nobody's sentence
DEPTH = 6  # of messages in messages
QUOTED = re.compile(r'["“][^"”]*["”]')
END = re.compile(r"(?<=[.!?]) +")
LISTED = (" · ", "; ", ", or ", ", and ", ", ", " and ", " or ")
UNITS = frozenset(["mm", "cm", "m", "ml", "l", "g", "kg", "s", "min", "h", "MB", "kB", "GB", "deg", "x"])
NUMBER = re.compile(r"(?<![\d.,])\d[\d,]*(?:\.\d+)?(?![\d,]*\.?\d)")
DAY = re.compile(r"(?<![\d-])(\d{4})-(\d\d)-(\d\d)(?![\d-])")
WORD = re.compile(r"[^\W\d_]+")
GERMAN = str.maketrans(",.", ".,")
Reading = tuple[int, str]  # characters that are known, translation
IsField = Callable[[str, str], bool]


class Typed(str):
    """What a person has written: the same in every language."""


def said(text: str, language: str) -> str:
    """The text in the language; a number in it as the language writes it."""
    if language == ENGLISH or not text or len(text) > LONGEST:
        return text
    return _read(text, language, 0)[1]


def document_said(document: Any, language: str, is_field: IsField, name: str = "", is_said: bool = False) -> Any:
    """A JSON document with its texts under the names that `is_field` knows in the language, in lists too.

    is_field: called with the name of the object that holds a field ("" at the top) and the field's.
    """
    if isinstance(document, str):
        return said(document, language) if is_said and not isinstance(document, Typed) else document
    if isinstance(document, list | tuple) and not (document and isinstance(document[0], int | float)):
        return [document_said(each, language, is_field, name, is_said) for each in document]
    if isinstance(document, dict):
        return {
            key: document_said(value, language, is_field, key, is_field(name, key)) for key, value in document.items()
        }
    return document


@lru_cache(maxsize=4096)
def _read(text: str, language: str, depth: int) -> Reading:
    """The best reading of a text: as it is, as sentences one after another, or as a list."""
    core = text.strip(" :;,")
    if not core or text in (words := catalogue(language).words):
        return len(text), words[text] if core else text
    if core != text:
        start, _, end = text.partition(core)
        known, found = _read(core, language, depth)
        return known, start + found + end
    if QUOTED.fullmatch(text):
        return 1, text
    as_numbers = numbers_said(text, language)
    if as_numbers is not None:
        return 1, as_numbers
    ways = (_sentences(text, language, depth), _named(text, language, depth), _list(text, language, depth))
    return max(ways, key=_known)


def _known(reading: Reading) -> int:
    return reading[0]


def _sentence(text: str, language: str, depth: int) -> Reading:
    """The best reading as one message."""
    known = catalogue(language)
    lower = text[:1].lower() + text[1:]
    if text in known.words:
        return len(text), known.words[text]
    if lower in known.words:  # a word that begins a sentence
        found = known.words[lower]
        return len(text), found[:1].upper() + found[1:]
    if text + "." in known.words:
        return len(text), known.words[text + "."].removesuffix(".")
    likely = [message for message in known.like(text) if message.longest in text] if depth < DEPTH else []
    best = max((_filled(message, text, language, depth) for message in likely), key=_known, default=(0, text))
    if best[0] == 0 and text.endswith("."):
        count, found = _sentence(text[:-1], language, depth)
        return count, found + "."
    return best


def _filled(message: Message, text: str, language: str, depth: int) -> Reading:
    found = message.pattern.fullmatch(text)
    if found is None or not message.text:
        return 0, text
    known, values = message.known, {}
    for k, ((name, is_number), value) in enumerate(zip(message.places, found.groups(), strict=True)):
        if is_number:
            count, values[name] = len(value), number_said(value, language)
        elif message.is_quoted(k):
            count, values[name] = 0, value
        else:
            count, values[name] = _read(value, language, depth + 1)
        known += count
    return known, _put(message.text, values)


def _put(text: str, values: dict[str, str]) -> str:
    return re.sub(r"\{\{|\}\}|\{(\d+)(?::[^{}]*)?\}", lambda at: values[at[1]] if at[1] else at[0][0], text)


def _sentences(text: str, language: str, depth: int) -> Reading:
    """The best reading as several sentences, of which each may be several."""
    parts = END.split(text)
    best: list[Reading] = [(0, "")]
    for end in range(1, len(parts) + 1):
        ways = []
        for start in range(end - 1, -1, -1):  # rather short sentences than long ones
            known, found = _sentence(" ".join(parts[start:end]), language, depth)
            ways.append((best[start][0] + known, f"{best[start][1]} {found}".lstrip()))
        best.append(max(ways, key=_known))
    return best[-1]


def _named(text: str, language: str, depth: int) -> Reading:
    """What begins with a name that is known: Standing: ..."""
    name, colon, rest = text.partition(": ")
    known, found = _sentence(name, language, depth) if colon else (0, text)
    if not known:
        return 0, text
    more, read = _read(rest, language, depth)
    return known + more, f"{found}: {read}"


def _list(text: str, language: str, depth: int) -> Reading:
    """A list of words that are all known, else the text as it is."""
    for between in LISTED:
        parts = [_read(part, language, depth) for part in text.split(between)] if between in text else []
        if parts and all(count for count, _ in parts):
            joint = catalogue(language).words.get(between, between)
            return sum(map(_known, parts)), joint.join(found for _, found in parts)
    return 0, text


def number_said(text: str, language: str) -> str:
    """One number as Python formats it, 1,234.5, as the language writes it: 1.234,5."""
    return text.translate(GERMAN) if language == "de" else text


def numbers_said(text: str, language: str) -> str | None:
    """The text with its numbers and days (ISO 8601) in the language; None where it has other words than units."""
    if language != "de" or not {*WORD.findall(text)} <= UNITS:
        return None
    days = DAY.sub(r"\3.\2.\1", text)
    return days if days != text else NUMBER.sub(lambda found: number_said(found[0], language), text)

"""Numbers and days as each language writes them."""

import re

UNITS = frozenset(["mm", "cm", "m", "ml", "l", "g", "kg", "s", "min", "h", "MB", "kB", "GB", "deg", "x"])
NUMBER = re.compile(r"(?<![\d.,])\d[\d,]*(?:\.\d+)?(?![\d,]*\.?\d)")
DAY = re.compile(r"(?<![\d-])(\d{4})-(\d\d)-(\d\d)(?![\d-])")
WORD = re.compile(r"[^\W\d_]+")
GERMAN = str.maketrans(",.", ".,")


def number_said(text: str, language: str) -> str:
    """One number as Python formats it, 1,234.5, as the language writes it: 1.234,5."""
    return text.translate(GERMAN) if language == "de" else text


def numbers_said(text: str, language: str) -> str | None:
    """The text with its numbers and days (ISO 8601) in the language; None where it has other words than units."""
    if language != "de" or not {*WORD.findall(text)} <= UNITS:
        return None
    days = DAY.sub(r"\3.\2.\1", text)
    return days if days != text else NUMBER.sub(lambda found: number_said(found[0], language), text)

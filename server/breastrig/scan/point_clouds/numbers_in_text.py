"""Parses numbers in the text of scan files, with decimal points or commas, and words for missing numbers."""

import re
import warnings
from collections.abc import Sequence

import numpy as np

from breastrig.core.arrays import Array, Integers

# "Not a number" and "infinite" as C libraries on Windows write them (1.#IND00, -1.#QNAN, 1.#J, nan(ind)), also rounded.
NO_NUMBER = re.compile(rb"(?<!\S)[-+]?(?:1[.,]?[#$]\w*|nan\(\w*\))(?!\S)", re.IGNORECASE)
REMARK = re.compile(rb"(?<![.,])#.*")  # behind the numbers of a line; 1.#IND is none
SPACED_COMMA = re.compile(rb",[ \t]|[ \t],")


def with_points(rows: Sequence[bytes]) -> Sequence[bytes]:
    """The rows with decimal points and spaces: commas are decimals, as German programs write them, or separators.

    They separate where points or spaces stand beside them too; `1,5 2,5` has decimals.
    """
    if not any(b"," in row for row in rows):
        return rows
    separate = any(b"." in row for row in rows) or any(SPACED_COMMA.search(row) for row in rows[:100])
    separate = separate or not all(len(row.split()) > 1 for row in rows[:100])
    return [row.replace(b",", b" " if separate else b".") for row in rows]


def numbers(rows: Sequence[bytes]) -> tuple[Array, Integers]:
    """(all numbers, how many each row has), nan for words such as "nan"; ValueError for other words."""
    try:
        return _parsed(with_points(rows))
    except ValueError:
        mended = [NO_NUMBER.sub(b"nan", row) for row in rows]
        if mended == list(rows):
            raise
        return _parsed(with_points(mended))


def _parsed(rows: Sequence[bytes]) -> tuple[Array, Integers]:
    widths = np.fromiter((len(row.split()) for row in rows), np.int64, len(rows))
    total = int(widths.sum())
    if not total:
        return np.zeros(0), widths
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # words that are no numbers
            found = np.fromstring(b" ".join(rows).decode("latin-1"), np.float64, sep=" ")
    except DeprecationWarning as error:
        raise ValueError("a word that is no number") from error
    if len(found) != total:
        raise ValueError("a word that is no number")
    return found, widths


def first_columns(rows: Sequence[bytes], count: int) -> Array:
    """(N, count) of rows with at least so many numbers; ValueError where one has fewer."""
    found, widths = numbers(rows)
    if len(rows) and int(widths.min()) < count:
        raise ValueError("a row with too few numbers")
    starts = np.cumsum(widths) - widths
    return np.asarray(found[starts[:, None] + np.arange(count)])

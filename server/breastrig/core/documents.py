"""JSON that people can read, and tables as CSV that spreadsheet programs show and never run.

JSON is as `json.dumps(document, indent=1)` writes it, ten times faster where most of it is lists of numbers: Python's
own encoder in C does not indent, and the one that does goes number by number.  Here each list without lists or objects
in it goes through the fast one, which puts its commas at the ends of lines.

A cell of a table that begins with =, +, -, @, a tab or a carriage return is a formula to spreadsheets, and names come
from outside (OWASP, "CSV injection").  Such a text gets an apostrophe in front; numbers stay as they are.
"""

import csv
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Any

_CONTAINERS = (dict, list, tuple)
_NOT_FLAT = (*_CONTAINERS, str)  # a text may hold what stands between numbers
_text = json.JSONEncoder(allow_nan=False).encode


def indented(document: Any) -> str:
    """The JSON text, like `json.dumps(document, indent=1)`.

    ValueError for a number that is not finite, TypeError for a type that JSON lacks.
    """
    return _indented(document, "\n")


def json_bytes(document: Any) -> bytes:
    """The document as the bytes of a JSON file, indented by one; ValueError for a number that is not finite."""
    return (indented(document) + "\n").encode()


def _indented(value: Any, line: str) -> str:
    """`line` is the line break with the indentation of the value's own first line."""
    if not isinstance(value, _CONTAINERS) or not value:
        return _text(value)
    inner = line + " "
    if isinstance(value, dict):
        parts = [f"{_key(name)}: {_indented(each, inner)}" for name, each in value.items()]
        return f"{{{inner}{(',' + inner).join(parts)}{line}}}"
    if not any(isinstance(each, _NOT_FLAT) for each in value):
        return f"[{inner}{_text(value)[1:-1].replace(', ', ',' + inner)}{line}]"
    return f"[{inner}{(',' + inner).join(_indented(each, inner) for each in value)}{line}]"


def _key(name: Any) -> str:
    return _text(name) if isinstance(name, str) else _text({name: 0})[1:-4]


FORMULA = ("=", "+", "-", "@", "\t", "\r")


def csv_table(columns: Sequence[str], rows: Iterable[Mapping[str, object]]) -> bytes:
    """A header and the rows in UTF-8; a cell that a row lacks, or that is None, is empty."""
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, [_safe(name) for name in columns], lineterminator="\n")
    writer.writeheader()
    writer.writerows({_safe(name): _safe(row.get(name)) for name in columns} for row in rows)
    return text.getvalue().encode()


def _safe(cell: object) -> object:
    if not isinstance(cell, str) or not cell.startswith(FORMULA):
        return cell
    with suppress(ValueError):
        float(cell)
        return cell
    return f"'{cell}"

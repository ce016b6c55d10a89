"""Tables as CSV that spreadsheet programs show and never run.

A cell that begins with =, +, -, @, a tab or a carriage return is a formula to them, and names come from outside (OWASP,
"CSV injection").  Such a text gets an apostrophe in front; numbers stay as they are.
"""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress

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

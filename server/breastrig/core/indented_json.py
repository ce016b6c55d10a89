"""JSON as `json.dumps(document, indent=1)` writes it, ten times faster where most of it is lists of numbers.

Python's own encoder in C does not indent, and the one that does goes number by number.  Here each list without lists
or objects in it goes through the fast one, which puts its commas at the ends of lines.
"""

import json
from typing import Any

_CONTAINERS = (dict, list, tuple)
_NOT_FLAT = (*_CONTAINERS, str)  # a text may hold what stands between numbers
_text = json.JSONEncoder(allow_nan=False).encode


def indented(document: Any) -> str:
    """The same characters.  ValueError for a number that is not finite, TypeError for what JSON does not know."""
    return _indented(document, "\n")


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

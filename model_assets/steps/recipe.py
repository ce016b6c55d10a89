"""Recipes, and recipes that change another one: `base = "FILE"` names it, and what is written replaces what is there.

Tables are merged by key, lists of tables by `name`; `without` names entries of the base's lists that are left out.
"""

import tomllib
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any

Recipe = dict[str, Any]


def read_recipe(path: Path) -> tuple[Recipe, tuple[Path, ...]]:
    """The whole recipe and the files that it is made of, the base first.

    `frame` in it is the body that its lengths were written for: the base's (steps/frame.py).
    """
    own = tomllib.loads(path.read_text(encoding="utf-8"))
    if "base" not in own:
        return own | {"frame": own["body"]}, (path,)
    base, files = read_recipe(path.parent / own.pop("base"))
    for place, names in own.pop("without", {}).items():
        *tables, last = place.split(".")
        table = reduce(getitem, tables, base)
        table[last] = [entry for entry in table[last] if entry["name"] not in names]
    return _merged(base, own), (*files, path)


def _merged(base: Any, own: Any) -> Any:
    if isinstance(base, dict) and isinstance(own, dict):
        return base | {key: _merged(base[key], value) if key in base else value for key, value in own.items()}
    if _named(base) and _named(own):
        fresh = {entry["name"]: entry for entry in own}
        kept = [_merged(entry, fresh.pop(entry["name"], {})) for entry in base]
        return kept + list(fresh.values())
    return own


def _named(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(e, dict) and "name" in e for e in value)

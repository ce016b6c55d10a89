"""What this run has computed before is not computed again: the same function of the same values has the same answer.

The functions of FUNCTIONS are deterministic, and tests of doors, folders, reports and plans ask them the same few
questions over and over.  Answers are pickled files under a hash of function and values, in a folder of this run that
processes of all tests and of services' tasks find by FOLDER; another run, of changed code, begins with none.

A test that has something put into the rooms that compute (`monkeypatch`) computes all itself, and so does one with the
fixture `computed_anew`, where two computations are compared or counted.
"""

import functools
import hashlib
import importlib
import inspect
import os
import pickle
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from pydantic import BaseModel

from breastrig.core.assets import asset_folder
from breastrig.rig.model import Rig

FOLDER = "BREASTRIG_REMEMBERED_UPLOADS"  # environment; without it nothing is remembered
FUNCTIONS = {
    "breastrig.fitting.starts.rigid_search": ("rest_place",),
    "breastrig.fitting.solve": ("checked_iterates",),
    "breastrig.fitting.body.trunk_lengths": ("trunk_lengths",),
    "breastrig.fitting.body.refine": ("refined",),
    "breastrig.colour.features.observe": ("observed_landmarks",),
    "breastrig.scan.clean": ("clean",),
    "breastrig.scan.orient": ("propose_frame",),
    "breastrig.scan.around.background": ("without_background",),
    "breastrig.scan.images.read_volumes": ("pieces_of",),
    "breastrig.scan.images.skin.skin_of_image": ("skin_of_image",),
    "breastrig.drawings.plan_on_scan": ("_drawn",),
    "breastrig.drawings.transfer": ("transferred", "points_carried"),
    "breastrig.drawings.skin_maps.interior_map": ("moved_inside",),
    "breastrig.report.measures": ("measures",),
    "breastrig.report.volume": ("breast_volume",),
    "breastrig.report.pages.tape": ("tape_points",),
    "breastrig.volume.tetrahedra": ("volume_mesh",),
}
ABOVE = ("core", "rendering", "use", "batch", "cli", "api", "service", "execution", "storage", "index")  # or beside
DECIDES_NOTHING = {"known_opening"}  # an argument that only saves work
UNDRAWN = {"lines": (), "banded": ()}  # of a stance
LOOKS_PAST = {  # parts of a stance that a function does not look at
    "measures": UNDRAWN,
    "breast_volume": UNDRAWN | {"picked": {}, "seen": {}, "landmark_radii": {}, "areolae": {}, "joint": None},
}

changed: set[object] = set()  # by whom the rooms that compute are changed at the moment; nothing is remembered then
_rigs: WeakKeyDictionary[Rig, bytes] = WeakKeyDictionary()


def install() -> None:
    """From now on this process remembers."""
    for module, names in FUNCTIONS.items():
        for name in names:
            function = getattr(importlib.import_module(module), name)
            instead = _remembered(function)
            for other in [each for place, each in sys.modules.items() if place.startswith(("breastrig", "test"))]:
                for key in [key for key, value in vars(other).items() if value is function]:
                    setattr(other, key, instead)


def computes(place: str) -> bool:
    """Whether a module is one of those that FUNCTIONS may call."""
    package, _, room = place.partition(".")
    return package == "breastrig" and room.split(".")[0] not in ABOVE


def once(key: str, compute: Callable[[], Any]) -> Any:
    """What `compute` returns, or returned under this key before."""
    if FOLDER not in os.environ or changed:
        return compute()
    if (known := kept(key)) is not None:
        return known[0]
    found = compute()
    keep(key, found)
    return found


def key_of(*values: object) -> str:
    """A hash of everything that the values are made of; TypeError where one is no plain value."""
    total = hashlib.sha256()
    _tell(total, values)
    return total.hexdigest()


def key_of_job(kind: str, job: Any) -> str:
    """A hash of all that a task's answer depends on: its values, its scan's and its model's bytes, not its places."""
    values = {each.name: getattr(job, each.name) for each in fields(job)}
    model = values.pop("model") or asset_folder("model") / "torso.glb"
    plain = {name: value for name, value in values.items() if not isinstance(value, Path)}
    files = [file.read_bytes() for file in (job.scan, model, model.with_suffix(".json"))]
    return key_of(kind, plain, job.scan.suffix, *files)


def keep(key: str, found: object) -> None:
    """Whole or not at all; others may be doing the same."""
    file = Path(os.environ[FOLDER], key)
    file.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=file.parent, delete=False) as making:
        pickle.dump(found, making)
    Path(making.name).replace(file)


def kept(key: str) -> tuple[Any] | None:
    """What was kept under the key, alone in a tuple; None where nothing was."""
    try:
        return (pickle.loads(Path(os.environ[FOLDER], key).read_bytes()),)
    except FileNotFoundError:
        return None


def _remembered(function: Callable[..., Any]) -> Callable[..., Any]:
    """The same, which remembers; the iterates of a fit are remembered once it has come to its end."""
    named = inspect.signature(function)

    def key(*args: Any, **kwargs: Any) -> str | None:
        if FOLDER not in os.environ or changed:
            return None
        given = {k: v for k, v in named.bind(*args, **kwargs).arguments.items() if k not in DECIDES_NOTHING}
        if function.__name__ in LOOKS_PAST:
            given["stance"] = replace(given["stance"], **LOOKS_PAST[function.__name__])
        try:
            return key_of(function.__module__, function.__name__, given)
        except TypeError:
            return None

    @functools.wraps(function)
    def answer(*args: Any, **kwargs: Any) -> Any:
        known = key(*args, **kwargs)
        return function(*args, **kwargs) if known is None else once(known, lambda: function(*args, **kwargs))

    @functools.wraps(function)
    def iterates(*args: Any, **kwargs: Any) -> Iterator[Any]:
        known = key(*args, **kwargs)
        if known is None:
            yield from function(*args, **kwargs)
        elif before := kept(known):
            yield from before[0]
        else:
            found = []
            for each in function(*args, **kwargs):
                found.append(each)
                yield each
            keep(known, found)

    return iterates if inspect.isgeneratorfunction(function) else answer


def _tell(total: "hashlib._Hash", value: object) -> None:
    """Adds a value and all that it holds; TypeError for what is no value."""
    match value:
        case None | bool() | int() | float() | str() | bytes() | Enum() | Path() | np.generic():
            total.update(f"{type(value).__name__} {value!r}\n".encode())
        case np.ndarray():
            total.update(f"{value.dtype} {value.shape}\n".encode())
            total.update(np.ascontiguousarray(value).tobytes())
        case Rig():
            if value not in _rigs:
                _rigs[value] = key_of(*(getattr(value, each.name) for each in fields(Rig))).encode()
            total.update(_rigs[value])
        case BaseModel():
            _tell_parts(total, value, {name: getattr(value, name) for name in type(value).model_fields})
        case Mapping():
            _tell_parts(total, value, value)
        case list() | tuple():
            _tell_parts(total, value, dict(enumerate(value)))
        case set() | frozenset():
            _tell_parts(total, value, dict(enumerate(sorted(value))))
        case _ if is_dataclass(value) and not isinstance(value, type):
            public = (each.name for each in fields(value) if not each.name.startswith("_"))
            _tell_parts(total, value, {name: getattr(value, name) for name in public})
        case _:
            raise TypeError(type(value))


def _tell_parts(total: "hashlib._Hash", value: object, parts: Mapping[Any, Any]) -> None:
    total.update(f"{type(value).__name__} {len(parts)}\n".encode())
    for name, part in parts.items():
        _tell(total, name)
        _tell(total, part)

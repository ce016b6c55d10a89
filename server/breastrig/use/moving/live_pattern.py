"""A pattern that follows a hand, on the scan of one fit: what a process does that is kept for that fit.

The first question reads the fit's folder, half a second of work; what was read stays in the process's memory, so that
the next ones take a tenth of it.  The process serves one fit and ends with its deletion (execution/pool.py).
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.errors import BadInput
from breastrig.drawings.drawing_file import shape_document
from breastrig.drawings.handles.live_pattern import Drag, HandleOnScan, LivePattern, LiveSkin
from breastrig.geometry.polyline import length
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.use.folder.fit_folder import fit_folder_of


@dataclass(frozen=True)
class LiveQuestion:
    """A pattern that follows a hand; places are mm in the scan's frame."""

    name: str
    parameters: Mapping[str, float | str]
    side: str | None = None  # L, R: that one alone
    handle: str | None = None  # which is dragged
    to_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class LengthsQuestion:
    """The request for lengths along the skin, from each place to the next; mm in the scan's frame."""

    places_mm: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class PreparedFit:
    unit: str
    metres_per_unit: float
    skin: LiveSkin


_prepared: dict[str, PreparedFit] = {}  # of this process, by what the caller calls the fit: one at most


def live_pattern(fit: str, question: LiveQuestion | LengthsQuestion) -> dict[str, Any] | None:
    """The pattern with its handles, or lengths; None when this process has not read the fit yet.  Raises BadDrawing."""
    prepared = _prepared.get(fit)
    return None if prepared is None else _answer(prepared, question)


def read_and_live_pattern(
    fit: str, folder: Path, model: Path | None, question: LiveQuestion | LengthsQuestion
) -> dict[str, Any]:
    """The answer of `live_pattern` after reading the fit's folder. Raises BadInput for what is no fit."""
    rig = read_rig(model or default_rig_path())
    found = fit_folder_of(folder, rig)
    scan = found.fitted_scan
    _prepared.clear()
    _prepared[fit] = PreparedFit(found.unit, found.metres_per_unit, LiveSkin(rig, scan))
    return _answer(_prepared[fit], question)


def _answer(prepared: PreparedFit, question: LiveQuestion | LengthsQuestion) -> dict[str, Any]:
    if isinstance(question, LengthsQuestion):
        ways = prepared.skin.ways(1e-3 * np.array(question.places_mm))
        return {"legs": [{"mm": 1e3 * length(way), "points": np.round(1e3 * way, 3).tolist()} for way in ways]}
    x, y, z = (1e-3 * number for number in question.to_mm)
    drag = None if question.handle is None else Drag(question.handle, (x, y, z))
    try:
        found = prepared.skin.drawn(question.name, question.parameters, question.side, drag)
    except MemoryError as error:
        raise BadInput("This pattern needs more memory than it may use; give a smaller scan.") from error
    return _document(question.name, prepared, found)


def _document(name: str, prepared: PreparedFit, found: LivePattern) -> dict[str, Any]:
    return {
        "name": name,
        "parameters": dict(found.parameters),
        "unit": prepared.unit,
        "shapes": [shape_document(line, prepared.metres_per_unit) | {"label": label} for line, label in found.lines],
        "handles": [_handle(each) for each in found.handles],
        "limit": found.limit,
        "measured": {
            name: {side: round(value, 2) for side, value in each.items()} for name, each in found.measured.items()
        },
    }


def _handle(each: HandleOnScan) -> dict[str, Any]:
    return {
        "name": each.handle.name,
        "side": each.handle.side,
        "label": each.label,
        "at_mm": [round(1e3 * float(value), 3) for value in each.at],
        "grows": [round(float(value), 6) for value in each.handle.grows],
        "numbers": [asdict(number) | {"value": round(number.value, 2)} for number in each.numbers],
    }

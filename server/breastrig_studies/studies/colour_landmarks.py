"""The gain of colour for proposed landmarks: the same coloured scan with its colours and without, none given.

Also whether the errors hold, whether sides are ever exchanged, and how well the areolae's diameters are measured.
"""

import json
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from breastrig.colour.areolae import ObservedAreola
from breastrig.core.arrays import Array
from breastrig.core.units import METRES_PER_UNIT
from breastrig.fitting.observed.landmarks import NIPPLES
from breastrig.fitting.prepare_scan import prepared
from breastrig.fitting.propose import Proposal, propose_landmarks
from breastrig.fitting.recipe import Recipe
from breastrig.rig.model import Rig
from breastrig.scan.clean import clean
from breastrig.scan.read import read_scan
from breastrig_studies.cohort import Case
from breastrig_studies.studies.case import read_scene

NATURAL = "natural"  # a nipple that is neither covered nor reconstructed; case.json names the others


def colour_landmarks(cases: tuple[Case, ...], rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """{form, coloured: {name: mm}, held: {name: bool}, seen, states, exchanged, areolae, time_s}."""
    (case,) = cases
    true = read_scene(case).landmarks
    scan = read_scan(case.scan, None, case.unit, for_display=False)
    ready = prepared(clean(scan), "auto")
    began = time.process_time()
    form = propose_landmarks(rig, ready, recipe)
    middle = time.process_time()
    coloured = propose_landmarks(rig, ready, recipe, coloured=scan)
    ended = time.process_time()
    states = json.loads((case.folder / "case.json").read_text("utf-8")).get("nipples", {})
    return {
        "form": _gaps(form, true),
        "coloured": _gaps(coloured, true),
        "held": {name: _held(coloured[name], place) for name, place in true.items()},
        "seen": {name: each.reason for name, each in coloured.items() if each.reason not in (None, form[name].reason)},
        "states": {name: str(states.get(name, NATURAL)) for name in NIPPLES},
        "exchanged": exchanged(coloured, true),
        "areolae": _areolae(case, {name: coloured[name].areola for name in NIPPLES}),
        "time_s": round((ended - middle) - (middle - began), 3),
    }


def _gaps(found: Mapping[str, Proposal], true: Mapping[str, Array]) -> dict[str, float]:
    return {name: round(1e3 * float(np.linalg.norm(found[name].point - at)), 3) for name, at in true.items()}


def _held(found: Proposal, true: Array) -> bool | None:
    return None if found.error is None else bool(np.linalg.norm(found.point - true) <= found.error)


def exchanged(found: Mapping[str, Proposal], true: Mapping[str, Array]) -> bool:
    """Whether a nipple lies nearer to the other side's true place."""
    left, right = (name for name in NIPPLES)
    if left not in true or right not in true:
        return False
    own = [np.linalg.norm(found[name].point - true[name]) for name in (left, right)]
    other = [np.linalg.norm(found[a].point - true[b]) for a, b in ((left, right), (right, left))]
    return any(bool(beside < at) for at, beside in zip(own, other, strict=True))


def _areolae(case: Case, found: Mapping[str, ObservedAreola | None]) -> dict[str, dict[str, float | None]]:
    """Side -> {true_mm, found_mm, within_mm}; those whose true border skin.json has."""
    file = case.folder / "skin.json"
    if not file.is_file():
        return {}
    document = json.loads(file.read_text("utf-8"))
    metres = METRES_PER_UNIT[document["unit"]]
    rims = {shape["name"]: metres * np.array(shape["points"]) for shape in document["shapes"]}
    result: dict[str, dict[str, float | None]] = {}
    for name, side in NIPPLES.items():
        if f"areola_{side}" not in rims:
            continue
        seen = found.get(name)
        result[side] = {
            "true_mm": round(1e3 * true_diameter(rims[f"areola_{side}"]), 3),
            "found_mm": None if seen is None else round(1e3 * seen.diameter, 3),
            "within_mm": None if seen is None else round(1e3 * seen.half, 3),
        }
    return result


def true_diameter(rim: Array) -> float:
    """m, of the circle of the same area as a closed (P, 3) border, by the fan from its middle."""
    around = rim - rim.mean(axis=0)
    area = 0.5 * np.linalg.norm(np.cross(around, np.roll(around, -1, axis=0)), axis=1).sum()
    return 2.0 * float(np.sqrt(area / np.pi))

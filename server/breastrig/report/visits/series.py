"""Several visits of one patient in one stance as a document: measures at each, what changed, what is published."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import date
from functools import partial
from typing import Any

import numpy as np

from breastrig.core.errors import BadInput
from breastrig.core.stances import SIDES
from breastrig.report.measures import ALONG_SKIN, STRAIGHT, measures
from breastrig.report.stance import Stance
from breastrig.report.table import Row, Value, changes, flat_rows
from breastrig.report.visits.change import Change, change_between, visit_calibration
from breastrig.report.visits.symmetry import SHAPE, VOLUME, symmetry_rows
from breastrig.report.volume import vertices_within

PLOTTED = (
    ("volume", "volume"), (VOLUME, "ratio"), (SHAPE, "surface"),
    ("notch_nipple", STRAIGHT), ("nipple_fold", ALONG_SKIN), ("nipple_nipple", STRAIGHT),
)  # fmt: skip
PUBLISHED = tuple(  # context, never a verdict; another program measured them, standing
    {"measure": name, "unit": unit, "median": median, "low": low, "high": high, "source": "PMC5487698", "women": 200}
    | {
        "said": f"median {median:g} {unit}, middle half {low:g} to {high:g}: 200 women 1 to 6 years after "
        "breast-conserving treatment of one side (PMC5487698)"
    }
    for name, unit, median, low, high in ((VOLUME, "%", 87.0, 78.0, 93.0), (SHAPE, "mm", 5.9, 4.2, 8.0))
)
OVER_VISITS = "between the earlier and the later skin, laid on each other by the skin around the breasts"


@dataclass(frozen=True, eq=False)
class Visit:
    """One scan with its date and its fit."""

    scan: str
    date: str  # ISO 8601, a day
    label: str  # before, 6 weeks; may be empty
    stance: Stance
    verdict: str | None


def stance_document(visits: Sequence[Visit]) -> dict[str, Any]:
    """One stance's visits, the earliest first; each later one is compared with the first, and with the one before."""
    rows = [(found := measures(each.stance)) + tuple(symmetry_rows(each.stance, found)) for each in visits]
    pairs = sorted({(0, n) for n in range(1, len(visits))} | {(n - 1, n) for n in range(1, len(visits))})
    first = date.fromisoformat(visits[0].date)
    return {
        "stance": visits[0].stance.name,
        "visits": [
            {"scan": each.scan, "date": each.date, "label": each.label, "verdict": each.verdict}
            | {"days": (date.fromisoformat(each.date) - first).days}
            for each in visits
        ],
        "plotted": [list(key) for key in PLOTTED],
        "measures": [{"visit": n, **row} for n, own in enumerate(rows) for row in _flat(own)],
        "changes": [
            {"earlier": a, "later": b} | _compared((visits[a].stance, visits[b].stance), (rows[a], rows[b]))
            for a, b in pairs
        ],
    }


def _compared(stances: tuple[Stance, Stance], rows: tuple[Sequence[Row], Sequence[Row]]) -> dict[str, Any]:
    change, missing = None, ""
    try:
        change = change_between(*stances)
    except BadInput as error:
        missing = str(error)
    measured = _flat(changed_rows(*rows, change), is_change=True)
    return {"map": None if change is None else _map(change), "measures": measured, "missing": missing}


def changed_rows(before: Sequence[Row], after: Sequence[Row], change: Change | None) -> list[Row]:
    """Later less earlier, each with its band; volumes by `change`, and none where there is no such."""
    found, known = [], None if change is None else visit_calibration(change.earlier.rig)
    for row in changes(before, after):
        if row.measure == "volume":
            left, right = (None if change is None else change.volume(side) for side in SIDES)
            row = replace(row, left=left, right=right, method=OVER_VISITS, between=None, vague=(), not_known=())
        elif known is not None and row.unit == "mm" and row.measure != SHAPE:
            between = None if row.between is None else known.lengths * row.between
            row = replace(row.with_values(partial(_wider, times=known.lengths)), between=between)
        found.append(row)
    return found


def _wider(value: Value, times: float) -> Value:
    half = value.margin
    return value if half is None else Value(value.value, value.value - times * half, value.value + times * half)


def _map(change: Change) -> dict[str, Any]:
    """The map's numbers by side: of the seen skin the share of which a change is said, and the largest change said."""
    found: dict[str, Any] = {"untouched_spread_mm": round(1e3 * change.alignment.spread, 2)}
    for side, name in SIDES.items():
        inside = vertices_within(change.earlier.rig, side)
        seen = np.zeros(0, dtype=np.int64) if inside is None else np.flatnonzero(inside & np.isfinite(change.along))
        said = seen[change.said[seen]]
        most = said[np.abs(change.along[said]).argmax()] if len(said) else None
        found[name] = {
            "seen_share": None if inside is None else round(len(seen) / int(inside.sum()), 3),
            "half_band_mm": round(1e3 * change.half, 2) if len(seen) else None,
            "said_share": round(len(said) / len(seen), 3) if len(seen) else None,
            "largest_mm": None if most is None else round(1e3 * float(change.along[most]), 1),
        }
    return found


def _flat(rows: Sequence[Row], *, is_change: bool = False) -> list[dict[str, Any]]:
    return [
        {k: v for k, v in row.items() if k not in ("stance", "paths")} for row in flat_rows([("", rows)], is_change)
    ]

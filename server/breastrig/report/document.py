"""report.json: the numbers of one or two fitted stances, with what they were made by."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.version import __version__
from breastrig.files.result import ResultFile
from breastrig.report.resections.resection import Resection, WallUnder, no_wall, resection_numbers, resections
from breastrig.report.stance import Stance
from breastrig.report.table import Row, flat_rows

SCHEMA = "breastrig/report@1"
FROM_RESULT = (
    "stance", "stance_reason", "predicted", "preset", "refined", "scan", "model", "verdict", "converged", "stop_reason",
    "iterations", "surface_distance_mm", "scan_to_model_mm", "landmark_distance_mm", "model_alone",
    "line_error_mm", "landmark_uncertainty_mm", "landmarks_agreed", "not_calibrated",
    "landmarks_not_followed", "landmarks_unusual", "drawing_missing",
    "notes", "versions",
)  # fmt: skip  # no times: the same fit gives the same report
SIGNS = "difference is left less right; a row of two stances is the second less the first; sides are the patient's"


@dataclass(frozen=True)
class PlannedItem:
    """One item of the plan in words."""

    id: str
    name: str  # Reduction (Wise pattern), both sides
    values: tuple[tuple[str, str], ...] = ()  # (New areola, 44 mm)
    text: str = ""  # of a note
    said: str = ""  # why it cannot be shown
    is_drawn: bool = True  # here, so that its values are those of its lines; carried ones are as asked for


@dataclass(frozen=True, eq=False)
class Reported:
    """One stance of the report."""

    name: str  # as the report calls it
    stance: Stance
    result: ResultFile
    rows: tuple[Row, ...]
    plan: tuple[PlannedItem, ...] = ()
    lesions: tuple[Mapping[str, Any], ...] = ()  # as plan_document has them
    doubts: tuple[str, ...] = ()  # about the stances together: whether they are of one patient
    wall: WallUnder = no_wall  # asked only where lines enclose some of a breast
    drawn_mm: float | None = None  # line error of what is drawn here; None: nothing, or nothing is known of it
    depths: Mapping[str, float] = field(default_factory=dict)  # m, of the planned lines that say how deep they go

    @cached_property
    def resections(self) -> tuple[Resection, ...]:
        """What closed lines on the breasts enclose; none for a rig whose chest wall is not known."""
        return resections(self.stance, self.wall, self.depths)


def stance_said(result: ResultFile) -> str:
    """The stance's name in the report; one that was not scanned is "predicted"."""
    return f"{result.stance}, predicted" if result.predicted else result.stance


def stance_names(kinds: Sequence[str]) -> list[str]:
    """standing, supine; or standing A, standing B."""
    if len(kinds) == len(set(kinds)):
        return list(kinds)
    return [f"{kind} {letter}" for kind, letter in zip(kinds, "AB", strict=False)]


def report_document(stances: Sequence[Reported], with_plan: bool = True) -> dict[str, object]:
    """The document breastrig/report@1; `with_plan`: with what the plan's closed lines enclose."""
    return {
        "schema": SCHEMA,
        "notice": LIMITS_OF_USE,
        "breastrig": __version__,
        "stances": [
            {"name": one.name}
            | {key: said[key] for key in FROM_RESULT if key in said}
            | {"drawn_line_error_mm": one.drawn_mm}
            | _lesions(one)
            | (_resections(one) if with_plan else {})
            for one in stances
            for said in [one.result.document()]
        ],
        "doubts": list(stances[0].doubts),
        "signs": SIGNS,
        "measures": flat_rows([(one.name, one.rows) for one in stances]),
    }


def _lesions(one: Reported) -> dict[str, object]:
    """The lesions without data that only pictures need."""
    found = [{key: value for key, value in each.items() if key != "slices"} for each in one.lesions]
    return {"lesions": found} if found else {}


def _resections(one: Reported) -> dict[str, object]:
    """Of each closed line on a breast what it encloses, ml and grams; nothing where there is none."""
    grams = resection_numbers().density_g_per_ml
    found = [
        {
            "line": each.line,
            "side": each.side,
            "breast_ml": _ml(each.breast),
            "other_breast_ml": _ml(each.other_breast),
            "rows": [
                {
                    "depth_mm": None if row.depth is None else round(1e3 * row.depth, 1),
                    "planned": row.depth is not None and row.depth == one.depths.get(each.line),
                    "ml": _ml(row.volume),
                    "low_ml": None if row.band is None else _ml(row.band[0]),
                    "high_ml": None if row.band is None else _ml(row.band[1]),
                    "grams": round(1e6 * grams * row.volume, 1),
                    "share": round(row.share, 4),
                    "other_ml": _ml(row.other),
                    "left_ml": _ml(row.after),
                }
                for row in each.rows
            ],
        }
        for each in one.resections
    ]
    return {"resections": found, "g_per_ml": grams} if found else {}


def _ml(cubic_metres: float) -> float:
    return round(1e6 * cubic_metres, 1)

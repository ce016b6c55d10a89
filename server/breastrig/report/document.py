"""report.json: the numbers of one or two fitted stances, with what they were made by."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.version import __version__
from breastrig.files.result import ResultFile
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
    text: str = ""  # of a note, or why it cannot be shown
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
    drawn_mm: float | None = None  # line error of what is drawn here; None: nothing, or nothing is known of it


def stance_said(result: ResultFile) -> str:
    """The stance's name in the report; one that was not scanned is "predicted"."""
    return f"{result.stance}, predicted" if result.predicted else result.stance


def stance_names(kinds: Sequence[str]) -> list[str]:
    """standing, supine; or standing A, standing B."""
    if len(kinds) == len(set(kinds)):
        return list(kinds)
    return [f"{kind} {letter}" for kind, letter in zip(kinds, "AB", strict=False)]


def report_document(stances: Sequence[Reported]) -> dict[str, object]:
    """The document breastrig/report@1."""
    return {
        "schema": SCHEMA,
        "notice": LIMITS_OF_USE,
        "breastrig": __version__,
        "stances": [
            {"name": one.name}
            | {key: said[key] for key in FROM_RESULT if key in said}
            | {"drawn_line_error_mm": one.drawn_mm}
            | _lesions(one)
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

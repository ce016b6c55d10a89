"""The numbers of all cases as tables: the paper's Table 1 with truth columns, and the study of the landmarks."""

import csv
import io
from collections.abc import Iterable, Sequence
from typing import Any

TABLE_1: tuple[tuple[str, str], ...] = (  # heading, path into a case's numbers
    ("time_s", "time_s"),
    ("surface_mean_mm", "surface_mm.mean"),
    ("surface_std_mm", "surface_mm.std"),
    ("surface_max_mm", "surface_mm.max"),
    ("landmarks_mean_mm", "landmark_mm.mean"),
    ("landmarks_std_mm", "landmark_mm.std"),
    ("landmarks_max_mm", "landmark_mm.max"),
    ("landmarks_min_mm", "landmark_mm.min"),
    ("scan_to_model_mean_mm", "scan_to_model_mm.mean"),
    ("truth_mean_mm", "truth_mm.mean"),
    ("truth_p95_mm", "truth_mm.p95"),
    ("coverage", "surface_mm.coverage"),
    ("iterations", "iterations"),
)
LANDMARKS: tuple[tuple[str, str], ...] = (
    ("all_given_landmarks_mm", "landmark_mm.mean"),
    ("half_given_other_half_mm", "half_given_mm.mean"),
    ("none_given_landmarks_mm", "no_landmarks.landmark_mm"),
    ("all_given_surface_mm", "surface_mm.mean"),
    ("none_given_surface_mm", "no_landmarks.surface_mm"),
    ("click_error_landmarks_mm", "click_error.landmark_mm.mean"),
    ("click_error_truth_mm", "click_error.truth_mm.mean"),
    ("refined_surface_mm", "refined.surface_mm.mean"),
    ("refined_truth_mm", "refined.truth_mm.mean"),
)


def value(case: dict[str, Any], path: str) -> float | None:
    """The number at a dotted path; None when it is not known."""
    found: Any = case
    for key in path.split("."):
        found = found[key]
    return None if found is None else float(found)


def means(cases: Sequence[dict[str, Any]], columns: Iterable[tuple[str, str]]) -> list[float | None]:
    """The mean of each column over the cases that know it."""
    result: list[float | None] = []
    for _, path in columns:
        known = [number for number in (value(case, path) for case in cases) if number is not None]
        result.append(sum(known) / len(known) if known else None)
    return result


def groups(cases: Sequence[dict[str, Any]]) -> list[tuple[str, str, list[dict[str, Any]]]]:
    """(family, stance or "all", cases): independent bodies first, each stance and both together."""
    result = []
    for family in ("independent", "makehuman"):
        for stance in ("standing", "supine", "all"):
            chosen = [c for c in cases if c["family"] == family and stance in (c["stance"], "all")]
            if chosen:
                result.append((family, stance, chosen))
    return result


def _cell(number: float | None) -> str:
    return "" if number is None else f"{number:.4g}"


def as_csv(cases: Sequence[dict[str, Any]], columns: tuple[tuple[str, str], ...]) -> str:
    """One row a case, then the means of each family and stance."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["family", "patient", "case", "preset", *(heading for heading, _ in columns)])
    for case in cases:
        numbers = [_cell(value(case, path)) for _, path in columns]
        writer.writerow([case["family"], case["patient"], case["case"], case["preset"], *numbers])
    for family, stance, chosen in groups(cases):
        writer.writerow([family, "mean", stance, chosen[0]["preset"], *map(_cell, means(chosen, columns))])
    return text.getvalue()


def as_text(cases: Sequence[dict[str, Any]]) -> str:
    """The means for a terminal, one line a family and stance."""
    columns = (
        ("surface", "surface_mm.mean"),
        ("truth", "truth_mm.mean"),
        ("landmarks", "landmark_mm.mean"),
        ("half given", "half_given_mm.mean"),
        ("none given", "no_landmarks.landmark_mm"),
        ("refined truth", "refined.truth_mm.mean"),
        ("time s", "time_s"),
    )
    lines = [f"{'mean, mm':24s}" + "".join(f"{heading:>15s}" for heading, _ in columns)]
    for family, stance, chosen in groups(cases):
        row = "".join(f"{'-' if n is None else f'{n:.3f}':>15s}" for n in means(chosen, columns))
        lines.append(f"{f'{family}, {stance} ({len(chosen)})':24s}{row}")
    return "\n".join(lines)

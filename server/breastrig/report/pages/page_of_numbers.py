"""Page two: lengths, volumes, symmetry, landmarks and how the fit was made."""

from collections.abc import Sequence
from typing import Any

from breastrig.report.document import Reported
from breastrig.report.pages.page import MARGIN, QUIET, WIDTH, Align, Sheet
from breastrig.report.pages.page_landmarks import landmark_table
from breastrig.report.table import Row, Value, changes, number, with_band, with_margin

ROW = 4.7  # mm
GAP = 3.6  # mm between two tables
NAME = 40.0  # mm of a row's name
HALF = 0.5 * (WIDTH - 8.0)  # mm of a table beside another
VERDICTS = {"good": "good", "check": "check: see doubts and notes", "unusable": "unusable: see doubts and notes"}
Cell = tuple[float, float, str, Align]


def numbers_page(sheet: Sheet, stances: Sequence[Reported], top: float) -> float:
    """Draws the page; the y below its tables."""
    y = top
    for kind in ("straight", "along the skin"):
        y = _lengths(sheet, stances, kind, y)
    y = max(_volumes(sheet, stances, y), _ratios(sheet, stances, y))
    y = landmark_table(sheet, stances, y, GAP)
    return _settings(sheet, stances, y) + GAP


def _groups(stances: Sequence[Reported]) -> list[tuple[str, Sequence[Row]]]:
    groups: list[tuple[str, Sequence[Row]]] = [(one.name, one.rows) for one in stances]
    if len(stances) == 2:
        groups.append((f"change, {stances[0].name} to {stances[1].name}", changes(stances[0].rows, stances[1].rows)))
    return groups


def _lengths(sheet: Sheet, stances: Sequence[Reported], kind: str, y: float) -> float:
    shown = [row for row in stances[0].rows if row.kind == kind]
    if not shown:
        return y
    y = sheet.heading(MARGIN, y, f"Lengths, {kind} (mm, ± holds the true one nine times of ten)")
    groups = _groups(stances)
    width = (WIDTH - NAME) / len(groups)
    column = width / 3
    names: list[Cell] = []
    sides: list[Cell] = []
    for index, (name, _) in enumerate(groups):
        x = MARGIN + NAME + index * width
        names.append((x, width - 1.0, name, "R"))
        if len(groups) > 1:
            sheet.rule(y + 4.6, x + 4.0, width - 5.0)
        sides += [(x + k * column, column - 1.0, text, "R") for k, text in enumerate(("left", "right", "L - R"))]
    if len(groups) > 1:
        y = sheet.row(y, names, size=7.5, height=4.8)
    y = sheet.row(y, sides, size=7.0, shade=QUIET, height=4.4)
    for place, first in enumerate(shown):
        cells: list[Cell] = [(MARGIN + 1.0, NAME, first.label, "L")]
        for index, (_, rows) in enumerate(groups):
            x = MARGIN + NAME + index * width
            row = next((r for r in rows if (r.measure, r.kind) == (first.measure, kind)), None)
            cells += _length_cells(row, x, column, signed=index == 2)
        y = sheet.row(y, cells, band=(MARGIN, WIDTH) if place % 2 else None, height=ROW)
    return y + GAP


def _length_cells(row: Row | None, x: float, column: float, signed: bool) -> list[Cell]:
    if row is None:
        return []

    def text(value: Value | None) -> str:
        return number(value, "mm", signed=True) if signed else with_margin(value, "mm")

    if row.value is not None:
        return [(x, 2 * column - 1.0 - 0.5 * column, text(row.value), "R")]
    difference = None if row.difference is None else Value(row.difference)
    texts = (text(row.left), text(row.right), number(difference, "mm", signed=True))
    return [(x + k * column, column - 1.0, text, "R") for k, text in enumerate(texts)]


def _volumes(sheet: Sheet, stances: Sequence[Reported], y: float) -> float:
    found = [(one.name, row) for one in stances for row in one.rows if row.kind == "volume"]
    if not found:
        return y
    y = sheet.heading(MARGIN, y, "Volume (ml), with its band", HALF)
    column = (HALF - 20.0) / 2
    xs = [MARGIN + 20.0 + k * column for k in range(2)]
    y = sheet.row(
        y,
        [(xs[k], column - 1.0, side, "R") for k, side in enumerate(("left", "right"))],
        size=7.0,
        shade=QUIET,
        height=4.4,
    )
    for place, (name, row) in enumerate(found):
        cells: list[Cell] = [(MARGIN + 1.0, 20.0, name, "L")]
        cells += [(xs[k], column - 1.0, with_band(v, "ml"), "R") for k, v in enumerate((row.left, row.right))]
        y = sheet.row(y, cells, band=(MARGIN, HALF) if place % 2 else None, height=ROW)
    if len(found) == 2:
        change = changes([found[0][1]], [found[1][1]])[0]
        cells = [(MARGIN + 1.0, 20.0, "change", "L")]
        cells += [
            (xs[k], column - 1.0, number(v, "ml", signed=True), "R") for k, v in enumerate((change.left, change.right))
        ]
        y = sheet.row(y, cells, height=ROW)
    return y + GAP


def _ratios(sheet: Sheet, stances: Sequence[Reported], y: float) -> float:
    x = MARGIN + HALF + 8.0
    shown = [row for row in stances[0].rows if row.kind == "ratio"]
    if not shown:
        return y
    y = sheet.heading(x, y, "Symmetry (1 = symmetric)", HALF)
    column = 18.0
    xs = [x + HALF - (len(stances) - k) * column for k in range(len(stances))]
    y = sheet.row(
        y,
        [(at, column - 1.0, one.name, "R") for at, one in zip(xs, stances, strict=True)],
        size=7.0,
        shade=QUIET,
        height=4.4,
    )
    for place, first in enumerate(shown):
        cells: list[Cell] = [(x + 1.0, HALF - column * len(stances), first.label, "L")]
        for at, one in zip(xs, stances, strict=True):
            row = next((r for r in one.rows if r.measure == first.measure), None)
            cells.append((at, column - 1.0, number(row.value if row else None, "1"), "R"))
        y = sheet.row(y, cells, band=(x, HALF) if place % 2 else None, height=ROW)
    return y + GAP


def _settings(sheet: Sheet, stances: Sequence[Reported], y: float) -> float:
    y = sheet.heading(MARGIN, y, "Fit and settings")
    width = (WIDTH - NAME) / len(stances)
    if len(stances) > 1:
        names: list[Cell] = [(MARGIN + NAME + k * width, width - 1.0, one.name, "L") for k, one in enumerate(stances)]
        y = sheet.row(y, names, size=7.0, shade=QUIET, height=4.4)
    said = [_said(one.result) for one in stances]
    for place, name in enumerate(said[0]):
        cells: list[Cell] = [(MARGIN + 1.0, NAME, name, "L")]
        cells += [(MARGIN + NAME + k * width, width - 2.0, words[name], "L") for k, words in enumerate(said)]
        y = sheet.row(y, cells, band=(MARGIN, WIDTH) if place % 2 else None, height=ROW - 0.3, size=7.5)
    return y


def _said(result: dict[str, Any]) -> dict[str, str]:
    """What the result says of its making, in words."""
    scan, model, landmarks = result["scan"], result["model"], result["landmark_distance_mm"]
    versions = ", ".join(f"{name} {number}" for name, number in result["versions"].items())
    return {
        "Model to scan": _distances(result["surface_distance_mm"]),
        "Scan to model": _distances(result["scan_to_model_mm"]),
        "The model alone, to scan": _alone(result),
        "Model to picked landmarks": (
            "no landmarks were picked"
            if landmarks["mean"] is None
            else f"mean {landmarks['mean']:.1f} mm, largest {landmarks['max']:.1f} mm, of {len(landmarks['each'])}"
        ),
        "Verdict": _verdict(result.get("verdict")),
        "End of the fit": f"{result['stop_reason'].rstrip('.')}; {result['iterations']} steps",
        "Preset, stance": f"{result['preset']}{', on the skin' if result.get('refined') else ''}; {result['stance']}",
        "Scan": f"{scan['vertices']:,} points, {scan['triangles']:,} triangles, {scan['unit']}; {scan['sha256'][:12]}",
        "Model": f"{model['name']}, {model['bones']} bones, {model['blendshapes']} shapes; {model['sha256'][:12]}",
        "Versions": versions,
    }


def _verdict(verdict: dict[str, Any] | None) -> str:
    """The level in words; results of earlier versions have none."""
    return "not known" if verdict is None else VERDICTS[verdict["level"]]


def _alone(result: dict[str, Any]) -> str:
    """Without the free-form layer; results of earlier versions do not have it."""
    if not result.get("refined"):
        return "the same: nothing was added to it"
    return _distances(result["model_alone"]["surface_distance_mm"]) if "model_alone" in result else "not known"


def _distances(found: dict[str, float | None]) -> str:
    if found["mean"] is None:
        return "none found"
    words = f"mean {found['mean']:.2f} mm, 95 % {found['p95']:.2f} mm, largest {found['max']:.1f} mm"
    coverage = found.get("coverage")
    return words if coverage is None else f"{words}; {100 * coverage:.0f} % seen"

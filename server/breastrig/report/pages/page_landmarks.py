"""The report's table of landmarks: how far the model's is from the pick, and how far the truth may be from the model's.

One row a stance, so that it stands beside the lengths on the same page; the patient's two sides share a heading.
"""

from collections.abc import Sequence
from typing import Any

from breastrig.report.document import Reported
from breastrig.report.pages.page import MARGIN, QUIET, WIDTH, Align, Sheet
from breastrig.rig.model import Rig

TITLE = "Landmarks (mm): from the model's to the pick, ± the radius that holds the true place with 90 %"
NAME = 16.0  # mm of a stance's name
MOST = 14  # columns that can be read; a rig with more landmarks has the rest in report.json


def landmark_table(sheet: Sheet, stances: Sequence[Reported], y: float, gap: float) -> float:
    """Draws it at y where any result has radii; the y for what follows after a gap (mm)."""
    if not any(one.result.get("landmark_uncertainty_mm") for one in stances):
        return y
    y = sheet.heading(MARGIN, y, TITLE)
    groups = _groups(stances[0].stance.rig)
    names = [name for group in groups for name in group]
    column = (WIDTH - NAME) / len(names)
    lefts = [MARGIN + NAME + k * column for k in range(len(names))]
    heads: list[tuple[float, float, str, Align]] = []
    sides: list[tuple[float, float, str, Align]] = []
    for group in groups:
        first = names.index(group[0])
        label = group[0] if len(group) == 1 else group[0].removesuffix("_L").removesuffix("_R")
        heads.append((lefts[first], len(group) * column - 1.0, label.replace("_", " "), "R"))
        if len(group) > 1:
            sides += [(lefts[first + k], column - 1.0, _side(name), "R") for k, name in enumerate(group)]
    y = sheet.row(y, heads, size=7.0, shade=QUIET, height=3.4)
    y = sheet.row(y, sides, size=6.5, shade=QUIET, height=3.6)
    for one in stances:
        cells: list[tuple[float, float, str, Align]] = [(MARGIN + 1.0, NAME, one.name, "L")]
        cells += [(left, column - 1.0, _cell(one.result, name), "R") for left, name in zip(lefts, names, strict=True)]
        y = sheet.row(y, cells, size=7.0, height=4.4)
    return y + gap


def _groups(rig: Rig) -> list[list[str]]:
    """Landmarks as columns: those of the middle alone, the others beside their partner."""
    groups: list[list[str]] = []
    for landmark in rig.landmarks:
        if any(landmark.name in group for group in groups):
            continue
        group = list(dict.fromkeys((landmark.name, landmark.mirror)))
        if sum(map(len, groups)) + len(group) > MOST:
            break
        groups.append(group)
    return groups


def _side(name: str) -> str:
    return {"_L": "left", "_R": "right"}.get(name[-2:], name)


def _cell(result: dict[str, Any], name: str) -> str:
    gap = result["landmark_distance_mm"]["each"].get(name)
    radius = result.get("landmark_uncertainty_mm", {}).get(name)
    shown = [] if gap is None else [f"{gap:.1f}"]
    return " ".join(shown if radius is None else [*shown, f"± {radius:.1f}"]) or "-"

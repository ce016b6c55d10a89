"""Occlusion and closure of scans: verdicts under bra, hair, lids, the scanner's own axes, parts of a body.

python -m breastrig_studies.captures COHORT... -o DIR [--group validation] [--each 1] [--worst 30]

For each patient every condition (virtual/as_captured.py) takes another of the patient's scans in turn, or all with
`--each 0`. The test set is left out. Printed is a table by condition, one by patient is DIR/captures.csv, and
DIR/worst.jpg shows the worst fits from four sides. Answers are kept in DIR/work. docs/decisions/0026.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from breastrig.core.documents import csv_table
from breastrig.core.errors import FitFailed
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig_studies.cohort import DEVELOPMENT, VALIDATION, Case, read_cohort
from breastrig_studies.output.pictures import INK, SIZE, fit_row
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.result_cache import Record, Unit, records
from breastrig_studies.studies.trust.asked import RIGHT
from breastrig_studies.studies.trust.captured import captured_scene
from breastrig_studies.virtual.as_captured import CONDITIONS, HELD, body_frame

KINDS = ("all", "none")  # of the landmarks
SIDES = (("front", True), ("front", False), ("left", False), ("right", False), ("three_quarter", False))
FIGURES: dict[str, Callable[[dict[str, Any], str], bool]] = {  # of an answer and the true stance
    "refused": lambda each, _: each["level"] == "refused",
    "unusable": lambda each, _: each["level"] == "unusable",
    "right": lambda each, _: is_right(each),
    "right and good": lambda each, _: is_right(each) and each["level"] == "good",
    "wrong and good": lambda each, _: not is_right(each) and each["level"] == "good",
    "stance wrong": lambda each, true: each.get("stance", true) != true,
    "wrong and sure": lambda each, true: each.get("stance", true) != true and not each["unclear"],
}


def is_right(each: dict[str, Any]) -> bool:
    """Whether the landmarks that the scan shows are near enough."""
    return float(each.get("error_mm", np.inf)) <= RIGHT


def chosen(folders: Sequence[Path], group: str) -> list[Case]:
    """All cases of a group; never one of the test set."""
    cases = [case for folder in folders for case in read_cohort(folder) if not case.held_out]
    return [case for case in cases if case.group == group]


def units(cases: Sequence[Case], each: int, conditions: Sequence[str], recipe: Recipe) -> list[Unit]:
    """The questions, case by case; for each patient `each` scans for a condition, by turns, or all for 0."""
    result = []
    for number, (_, group) in enumerate(groupby(cases, lambda case: case.folder.parent)):
        scans = list(group)
        for k, condition in enumerate(conditions):
            taken = [scans[(number + k + i) % len(scans)] for i in range(min(each, len(scans)))] if each else scans
            result += [
                Unit((case,), "captured", recipe, default_rig_path(), {"condition": condition}) for case in taken
            ]
    return sorted(result, key=lambda unit: (str(unit.cases[0].folder), conditions.index(unit.settings["condition"])))


def table(found: Sequence[Record], kind: str) -> str:
    """A line for each condition: how many, and the median of the landmarks' mean error in mm."""
    lines = [f"{'landmarks: ' + kind:18}{'n':>5}" + "".join(f"{name:>16}" for name in FIGURES) + f"{'mm':>8}"]
    for condition in [*CONDITIONS, "together"]:
        its = [r for r in found if not r.failed and condition in (r.unit.settings["condition"], "together")]
        if its:
            errors = [r.answer[kind]["error_mm"] for r in its if "error_mm" in r.answer[kind]]
            counts = [sum(says(r.answer[kind], r.case.stance) for r in its) for says in FIGURES.values()]
            middle = f"{np.median(errors):8.1f}" if errors else ""
            lines.append(f"{condition:18}{len(its):5}" + "".join(f"{count:16}" for count in counts) + middle)
    return "\n".join(lines)


def by_woman(found: Sequence[Record]) -> bytes:
    """All answers as CSV, one row per patient and scan."""
    columns = ("woman", "scan", "condition", "landmarks", "level", "error_mm", "stance", "unclear", "reasons")
    rows = [
        {"woman": r.case.patient, "scan": r.case.name, "condition": r.unit.settings["condition"], "landmarks": kind}
        | {name: r.answer[kind].get(name) for name in columns[4:-1]}
        | {"reasons": " ".join(r.answer[kind]["reasons"])}
        for r in found
        for kind in (() if r.failed else KINDS)
    ]
    return csv_table(columns, rows)


def worst_sheet(found: Sequence[Record], rig: Rig, count: int) -> Image.Image:
    """The worst fits: the scan, and the model coloured by its distance to it from the sides, in the body's true axes.

    In the model's own axes where those of the scan were turned.
    """
    fits = [(r, kind) for r in found if not r.failed for kind in KINDS if "error_mm" in r.answer[kind]]
    fits = sorted(fits, key=lambda fit: -fit[0].answer[fit[1]]["error_mm"])[:count]
    rows = []
    for record, kind in fits:
        condition, answer = record.unit.settings["condition"], record.answer[kind]
        scene = captured_scene(read_scene(record.case), condition)
        try:
            fit = scene.fitted(
                rig, record.unit.recipe, dict(scene.landmarks) if kind == "all" else {}, None, answer["stance"]
            )
        except FitFailed:
            continue
        axes = None if condition in HELD else body_frame(read_scene(record.case).landmarks)[0]
        row = fit_row(scene, rig, fit.vertices, SIDES, axes)
        words = (*(record.case.patient, record.case.name, condition), f"landmarks: {kind}", f"{answer['error_mm']} mm")
        ImageDraw.Draw(row).text((8, 6), ", ".join((*words, answer["level"], answer["stance"])), INK, font_size=18)
        rows.append(row)
    sheet = Image.new("RGB", (SIZE[0] * len(SIDES), SIZE[1] * len(rows)))
    for k, row in enumerate(rows):
        sheet.paste(row, (0, k * SIZE[1]))
    return sheet


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cohorts", type=Path, nargs="+")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--group", choices=(DEVELOPMENT, VALIDATION), default=VALIDATION)
    parser.add_argument("--each", type=int, default=1)
    parser.add_argument("--condition", choices=CONDITIONS, action="append")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--worst", type=int, default=0)
    options = parser.parse_args()
    asked = units(
        chosen(options.cohorts, options.group), options.each, options.condition or [*CONDITIONS], load_recipe("default")
    )
    found = records(asked, options.output / "work", options.jobs, False, lambda _: None)
    for kind in KINDS:
        sys.stdout.write(table(found, kind) + "\n\n")
    for record in (each for each in found if each.failed):
        sys.stdout.write(f"{record.unit.label} {record.unit.settings['condition']}: {record.failed}\n")
    (options.output / "captures.csv").write_bytes(by_woman(found))
    if options.worst:
        worst_sheet(found, read_rig(default_rig_path()), options.worst).save(options.output / "worst.jpg", quality=85)


if __name__ == "__main__":
    main()

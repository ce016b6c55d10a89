"""The evaluation as one Markdown file: circumstances, limits, every table, every figure."""

import hashlib
import json
import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass

import numpy
import scipy

from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.version import __version__
from breastrig.rig.model import Rig
from breastrig_studies.evaluate import Results
from breastrig_studies.output.figures import spaced
from breastrig_studies.tables.table import Table

VIRTUAL = "Virtual patients, scanned by a simulated depth camera: results on real skin will differ."
MAKEHUMAN = (
    "MakeHuman bodies share their origin with the model's template, which flatters it; they are reported apart from "
    "independent bodies."
)
QUICK = "A quick run: Table 1 and the study of the landmarks."


@dataclass(frozen=True)
class Circumstances:
    """Facts needed to repeat the evaluation."""

    command: str
    data: str
    jobs: int


def facts(results: Results, rig: Rig, about: Circumstances) -> list[tuple[str, str]]:
    """(word, fact): command, data, model, presets and machine."""
    cases = results.plan.cases
    presets = []
    for recipe in results.plan.recipes:
        contents = json.dumps(recipe.model_dump(mode="json"), sort_keys=True)
        presets.append(f"{recipe.name} ({hashlib.sha256(contents.encode()).hexdigest()[:12]})")
    machine = f"{platform.machine()}, {platform.system()}, {os.cpu_count()} cores, {about.jobs} used"
    versions = f"BreastRig {__version__}, Python {platform.python_version()}, NumPy {numpy.__version__}"
    return [
        ("Command", about.command),
        ("Data", f"{about.data}: {len(cases)} scans of {len({case.patient for case in cases})} patients"),
        ("Model", f"{rig.name}, {len(rig.template)} vertices, {len(rig.shapes)} blendshapes, sha256 {rig.sha256[:16]}"),
        ("Presets", ", ".join(presets)),
        ("Machine", machine),
        ("Versions", f"{versions}, SciPy {scipy.__version__}"),
    ]


def markdown_table(table: Table) -> str:
    """Caption and rows as Markdown; means in bold, the reason where a fit was not possible."""
    headings = [column.heading or column.name for column in table.columns]
    lines = [_row([*headings, "note"]), _row([*("---" if column.key else "--:" for column in table.columns), "---"])]
    for row in table.rows:
        cells = [spaced(text) if not is_number else text for text, is_number in table.shown(row)]
        lines.append(_row([*(f"**{cell}**" if row.mean and cell else cell for cell in cells), row.note]))
    return "\n".join([f"## {spaced(table.name).capitalize()}", "", table.caption, "", *lines, ""])


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def summary(
    results: Results, rig: Rig, about: Circumstances, tables: Sequence[Table], figures: Sequence[tuple[str, str]]
) -> str:
    """The text of the file; `figures`: (words, path from the file)."""
    cases = results.plan.cases
    said = [
        LIMITS_OF_USE,
        *([VIRTUAL] if any((case.folder / "truth.ply").is_file() for case in cases) else []),
        *([MAKEHUMAN] if any(case.family == "makehuman" for case in cases) else []),
        *([QUICK] if results.plan.quick else []),
    ]
    parts = ["# How good is the fit?", "", " ".join(said), ""]
    parts += [f"- {word}: {fact}" for word, fact in facts(results, rig, about)]
    parts += ["", "All tables stand beside this file as CSV, with more digits.", ""]
    parts += [markdown_table(table) for table in tables]
    if figures:
        parts += ["## Figures", "", *(f"![{words}]({path})\n" for words, path in figures)]
    return "\n".join(parts)

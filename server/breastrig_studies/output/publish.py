"""Writes an evaluation: CSV tables, figures as PNG, a Markdown summary that shows both, and a record."""

import json
from collections.abc import Callable
from pathlib import Path

from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.version import __version__
from breastrig.gltf.read_rig import read_rig
from breastrig_studies.evaluate import Results, all_tables
from breastrig_studies.output.charts import as_png, have_plots
from breastrig_studies.output.figures import all_figures, spaced
from breastrig_studies.output.ink_pictures import ink_pictures
from breastrig_studies.output.pictures import fit_pictures
from breastrig_studies.output.summary import Circumstances, summary
from breastrig_studies.output.unseen_pictures import unseen_pictures

NO_PLOTS = "The figures need matplotlib: pip install breastrig[plots]; tables and summary are written without them."
TABLES = (
    "table1",
    "refined",
    "presets",
    "landmarks",
    "turns",
    "clicks",
    "wrong_picks",
    "blendshapes",
    "blendshape_order",
    "compliances",
    "peers",
    "transfer",
    "transfer_lines",
    "lesions",
    "prediction",
    "other_patient",
    "unseen",
    "prone",
    "certainty",
    "reliability",
    "believed",
    "measures",
    "ptosis",
    "verdicts",
    "colour_landmarks",
    "areolae",
    "ink",
    "ink_transfer",
    "failures",
)
SUMMARY, RECORD, SCHEMA = "evaluation.md", "evaluation.json", "breastrig/evaluation@1"


def possible_files(folder: Path) -> tuple[str, ...]:
    """The files that `published` may write into the folder, as far as known in advance; existing figures count."""
    figures = sorted(f"figures/{file.name}" for file in (folder / "figures").glob("*.png"))
    return (*(f"{name}.csv" for name in TABLES), *figures, SUMMARY, RECORD)


def published(results: Results, about: Circumstances, folder: Path, progress: Callable[[str], None]) -> list[Path]:
    """Writes everything into the empty folder and returns the files; `progress` is called with what is being made."""
    rig = read_rig(results.plan.model)
    tables = {table.name: table for table in all_tables(results)}
    files = []

    def write(name: str, data: bytes) -> None:
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
        files.append(file)

    for table in tables.values():
        write(f"{table.name}.csv", table.csv())
    for name, chart in all_figures(results, tables).items() if have_plots() else ():
        progress(f"figure {name}")
        write(f"figures/{name}.png", as_png(chart))
    if "unseen" in tables:
        progress("pictures of cut scans")
        for name, png in unseen_pictures(results.records, rig, results.plan.recipes[0].name).items():
            write(f"figures/{name}.png", png)
    if "ink" in tables:
        progress("pictures of ink")
        for name, png in ink_pictures(results.records).items():
            write(f"figures/{name}.png", png)
    for picture in fit_pictures(results.records, rig, results.plan.recipes[0].name, progress):
        write(f"figures/fit_{picture.family}_{picture.place}.png", picture.png)
    figures = [(spaced(file.stem), f"figures/{file.name}") for file in files if file.suffix == ".png"]
    write(SUMMARY, summary(results, rig, about, list(tables.values()), figures).encode())
    record = {"schema": SCHEMA, "notice": LIMITS_OF_USE, "breastrig": __version__, "command": about.command}
    write(RECORD, (json.dumps(record, indent=1) + "\n").encode())
    return files

"""What an evaluation leaves behind: CSV tables, figures as PNG, and one page that shows both."""

from collections.abc import Callable
from pathlib import Path

from breastrig.evaluation.charts import DARK, LIGHT, as_png, have_plots
from breastrig.evaluation.evaluate import Results, all_tables
from breastrig.evaluation.figures import all_figures
from breastrig.evaluation.page import Circumstances, page
from breastrig.evaluation.pictures import fit_pictures
from breastrig.evaluation.study_sections import all_sections
from breastrig.evaluation.unseen_sections import unseen_pictures
from breastrig.gltf.read_rig import read_rig

NO_PLOTS = "The figures need matplotlib: pip install breastrig[plots]; tables and page are written without them."


def published(results: Results, about: Circumstances, folder: Path, told: Callable[[str], None]) -> list[Path]:
    """Writes everything into the folder and returns the files; `told` hears what is being made."""
    rig = read_rig(results.plan.model)
    tables = {table.name: table for table in all_tables(results)}
    files = []

    def write(name: str, data: bytes) -> None:
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
        files.append(file)

    for stale in [*folder.glob("*.csv"), *(folder / "figures").glob("*.png")]:
        stale.unlink()  # of an earlier run with other studies: the folder shows one run
    for table in tables.values():
        write(f"{table.name}.csv", table.csv().encode())
    figures = {}
    for name, chart in all_figures(results, tables).items() if have_plots() else ():
        told(f"figure {name}")
        figures[name] = (as_png(chart, LIGHT), as_png(chart, DARK))
        write(f"figures/{name}.png", figures[name][0])
    if "unseen" in tables:
        told("pictures of cut scans")
        for name, png in unseen_pictures(results.records, rig, results.plan.recipes[0].name).items():
            figures[name] = (png, png)
            write(f"figures/{name}.png", png)
    pictures = fit_pictures(results.records, rig, results.plan.recipes[0].name, told)
    for picture in pictures:
        write(f"figures/fit_{picture.family}_{picture.place}.png", picture.png)
    html = page(results, rig, about, all_sections(results, tables), tables, figures, pictures)
    write("index.html", html.encode())
    return files

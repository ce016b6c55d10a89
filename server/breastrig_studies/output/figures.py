"""The figures as data, from the records and tables; charts.py draws them."""

from collections.abc import Sequence
from typing import Any

from breastrig_studies.evaluate import Results
from breastrig_studies.output.charts import Chart, Curve, CurveChart, CurvePanel, Panel, RowChart, Series, has_numbers
from breastrig_studies.studies.plan import FACTORS, ORDERS
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.studies.sensitivity import TERMS
from breastrig_studies.studies.trust.reliability import LEVELS
from breastrig_studies.tables.accuracy import FAMILIES, groups, of, value
from breastrig_studies.tables.breasts import of_all
from breastrig_studies.tables.certainty import KINDS
from breastrig_studies.tables.table import Cell, Row, Table

HEADINGS = {"independent": "independent bodies", "makehuman": "MakeHuman bodies"}
ORDER_WORDS = {"usefulness": "most useful first", "rig": "the rig's order"}
TERM_WORDS = {
    "data": "data λD",
    "landmarks": "landmarks λL",
    "scales": "bone scales λS",
    "shapes": "blendshapes λBS",
    "joints": "joints λJ",
}


def _ordered(records: Sequence[Record]) -> list[Record]:
    return [record for _, _, chosen in groups(records) for record in chosen]


def _labels(records: Sequence[Record]) -> list[tuple[str, str]]:
    return [(HEADINGS[record.case.family], spaced(f"{record.case.patient}, {record.case.name}")) for record in records]


def spaced(name: str) -> str:
    """A name of a file or a landmark, for people."""
    return name.replace("_", " ")


def _one(record: Record | None, path: str) -> list[float]:
    """The number at a path as a list: empty when it is not known."""
    if record is None or record.failed:
        return []
    number = value(record.answer, path)
    return [] if number is None else [number]


def _same_case(records: Sequence[Record], question: str, record: Record) -> Record | None:
    return next((other for other in of(records, question) if other.case == record.case), None)


def table_1_figure(results: Results) -> Chart:
    """Surface, truth and landmarks of each scan."""
    rows = _ordered(of(results.records, "accuracy", results.plan.recipes[0].name))
    kinds = (
        ("scan surface", "surface_mm.mean"),
        ("true surface", "truth_mm.mean"),
        ("given landmarks", "landmark_mm.mean"),
    )
    series = [Series(label, [_one(row, path) for row in rows]) for label, path in kinds]
    time = [Series("solver", [_one(row, "time_s") for row in rows], hollow=True)]
    return RowChart(_labels(rows), (Panel("mean distance, mm", series), Panel("time, s", time)))


def landmarks_figure(results: Results) -> Chart:
    """Figure 4 of the paper: with and without landmarks."""
    found = results.records
    rows = _ordered(of(found, "accuracy", results.plan.recipes[0].name))
    none = [_same_case(found, "no_landmarks", row) for row in rows]
    half = [_same_case(found, "halves", row) for row in rows]
    landmarks = [
        Series("all given", [_one(row, "landmark_mm.mean") for row in rows]),
        Series("half given, the other half measured", [_one(row, "landmarks_mm") for row in half]),
        Series("none given", [_one(row, "landmarks_mm") for row in none]),
    ]
    surface = [
        Series("all given", [_one(row, "surface_mm.mean") for row in rows]),
        Series("half given, the other half measured", [[] for _ in rows]),
        Series("none given", [_one(row, "surface_mm") for row in none]),
    ]
    return RowChart(_labels(rows), (Panel("landmarks, mean mm", landmarks), Panel("scan surface, mean mm", surface)))


def turns_figure(results: Results) -> Chart:
    """Every random orientation as a dot."""
    rows = _ordered(of(results.records, "random_turns"))

    def marks(variant: str | None, path: str, wrong: bool) -> list[list[float]]:
        return [
            [
                trial[path]
                for trial in row.answer.get("trials", [])
                if not trial["failed"]
                and variant in (None, trial["variant"])
                and any(trial[axis] for axis in ("up", "facing", "sides")) == wrong
                and trial[path] is not None
            ]
            for row in rows
        ]

    panels = []
    for title, path in (("landmarks, mean mm", "landmarks_mm"), ("scan surface, mean mm", "surface_mm")):
        series = [
            Series("as scanned", marks("as_scanned", path, False), hollow=True),
            Series("without the table", marks("without_table", path, False), hollow=True),
            Series("wrong way round", marks(None, path, True), wrong=True),
        ]
        panels.append(Panel(title, series, joined=False))
    return RowChart(_labels(rows), panels)


def clicks_figure(results: Results) -> Chart:
    """True picks against picks 5 mm off."""
    rows = _ordered(of(results.records, "clicks"))
    panels = []
    for title, path in (
        ("scan surface, mean mm", "surface_mm"),
        ("true surface, mean mm", "truth_mm"),
        ("landmarks to their true places, mm", "landmarks_mm"),
    ):
        exact = Series("true picks", [_one(row, f"exact.{path}") for row in rows])
        clicked = Series("all picks 5 mm off", [_one(row, f"clicked.{path}") for row in rows])
        panels.append(Panel(title, (exact, clicked)))
    return RowChart(_labels(rows), panels)


def wrong_picks_figure(table: Table) -> Chart:
    """Share of the wrong picks that were named, and distance of the model from their true places."""
    rows = [row for row in table.rows if not row.mean]
    words = {"independent": HEADINGS["independent"], "MakeHuman": HEADINGS["makehuman"]}
    labels = [(str(row.cells[1]), _short(str(row.cells[2]))) for row in rows if row.cells[0] == rows[0].cells[0]]

    def series(cell: Any) -> list[Series]:
        result = []
        for family, heading in words.items():
            of_family = {(row.cells[1], _short(str(row.cells[2]))): row for row in rows if row.cells[0] == family}
            values = [[cell(of_family[label])] if label in of_family else [] for label in labels]
            result.append(Series(heading, [[v for v in some if v is not None] for some in values]))
        return [one for one in result if any(one.values)]

    named = series(lambda row: 100.0 * row.cells[4] / row.cells[3])
    far = series(lambda row: row.cells[8])
    truth = series(lambda row: row.cells[7])
    panels = [Panel("named, % of fits", named, joined=False), Panel("model to true places, mm", far, joined=False)]
    if truth:
        panels.append(Panel("true surface, mean mm", truth, joined=False))
    return RowChart(labels, panels)


def _short(picks: str) -> str:
    """Both sides of one landmark in a few letters."""
    first, _, second = picks.partition(" and ")
    return spaced(f"{first.removesuffix('_L')}, L and R" if second else first)


def _curves_of(
    rows: Sequence[Row], names: Sequence[str], where: dict[str, str], x: str, y: str
) -> tuple[list[float], list[float | None]]:
    place = {name: index for index, name in enumerate(names)}
    chosen = [row for row in rows if all(row.cells[place[key]] == word for key, word in where.items())]
    return [float(row.cells[place[x]] or 0.0) for row in chosen], [
        None if row.cells[place[y]] is None else float(row.cells[place[y]] or 0.0) for row in chosen
    ]


def blendshapes_figure(table: Table) -> Chart:
    """Figures 5 and 6 of the paper: error and time against the number of blendshapes."""
    names = [column.name for column in table.columns]
    settings = list(dict.fromkeys(str(row.cells[1]) for row in table.rows))
    families = [word for word in FAMILIES.values() if any(row.cells[0] == word for row in table.rows)]
    grid = []
    kinds = (("surface_mm", "scan surface, mm"), ("landmarks_mm", "given landmarks, mm"), ("time_s", "time, s"))
    for number, words in kinds:
        panels = []
        for setting in settings:
            curves = []
            for colour, family in enumerate(families):
                for dash, order in enumerate(ORDERS):
                    where = {"family": family, "setting": setting, "order": order}
                    x, y = _curves_of(table.rows, names, where, "shapes", number)
                    if x:
                        curves.append(Curve(f"{family}, {ORDER_WORDS[order]}", x, y, colour, dash))
            panels.append(CurvePanel(spaced(setting) if number == "surface_mm" else "", words, "blendshapes", curves))
        grid.append(panels)
    return CurveChart(grid, sizes=(2.9, 1.9))


def compliances_figure(table: Table, preset: str) -> Chart:
    """Figures 7 and 8 of the paper: each compliance varied, surface and landmarks."""
    names = [column.name for column in table.columns]
    rows = [row for row in table.rows if row.cells[1] == preset]
    families = [(key, word) for key, word in FAMILIES.items() if any(row.cells[0] == word for row in rows)]
    kinds = [("surface_mm", "scan surface, mm"), ("truth_mm", "true surface, mm"), ("landmarks_mm", "landmarks, mm")]
    place = names.index("truth_mm")
    kinds = [kind for kind in kinds if kind[0] != "truth_mm" or any(row.cells[place] is not None for row in rows)]
    grid = []
    for number, words in kinds:
        panels = []
        for key, family in families:
            curves = []
            for index, term in enumerate(TERMS):
                x, y = _curves_of(rows, names, {"family": family, "compliance": term}, "factor", number)
                curves.append(Curve(TERM_WORDS[term], x, y, index, index))
            title = HEADINGS[key] if number == "surface_mm" else ""
            panels.append(CurvePanel(title, words, "compliance times", curves, log_x=True, mark_x=FACTORS[2]))
        grid.append(panels)
    return CurveChart(grid, sizes=(4.0, 2.0))


def peers_figure(table: Table) -> Chart:
    """Methods on rows, means of each stance as dots."""
    names = [column.name for column in table.columns]
    settings = list(dict.fromkeys(str(row.cells[1]) for row in table.rows))
    labels = []
    for key, family in FAMILIES.items():
        methods = dict.fromkeys(str(row.cells[2]) for row in table.rows if row.cells[0] == family)
        labels += [(HEADINGS[key], method) for method in methods]
    words = {HEADINGS[key]: word for key, word in FAMILIES.items()}
    panels = []
    for number, title, log in (
        ("surface_mm", "scan surface, mm", False),
        ("truth_mm", "true surface, mm", False),
        ("landmarks_mm", "given landmarks, mm", False),
        ("time_s", "time, s", True),
    ):
        place = names.index(number)
        series = []
        for setting in settings:
            found = {
                (str(row.cells[0]), str(row.cells[2])): row.cells[place]
                for row in table.rows
                if row.cells[1] == setting
            }
            values = [found.get((words[heading], method)) for heading, method in labels]
            series.append(Series(spaced(setting), [[] if v is None else [float(v)] for v in values]))
        if any(some for one in series for some in one.values):
            panels.append(Panel(title, series, log=log, joined=False))
    return RowChart(labels, panels)


def reliability_figure(table: Table) -> Chart:
    """Stated against observed coverage, for each group of places; see tables/certainty.py."""
    said = [100.0 * level for level in LEVELS]
    panels = []
    for group in dict.fromkeys(str(row.cells[0]) for row in table.rows):
        curves = [Curve("as said", said, said, len(KINDS), 2)]
        for index, words in enumerate(KINDS.values()):
            for row in table.rows:
                if row.cells[:2] == (group, words):
                    curves.append(Curve(words, said, [_number(cell) for cell in row.cells[3:]], index, index))
        panels.append(CurvePanel(group, "covered, %", "said, %", curves))
    return CurveChart((panels,), sizes=(1.8, 2.3))


def _number(cell: Cell) -> float | None:
    return float(cell) if isinstance(cell, int | float) else None


def all_figures(results: Results, tables: dict[str, Table]) -> dict[str, Chart]:
    """Every figure whose numbers are there, by the name of its file."""
    charts: dict[str, Chart] = {"table1": table_1_figure(results), "landmarks": landmarks_figure(results)}
    if "turns" in tables:
        charts["turns"] = turns_figure(results)
    charts["clicks"] = clicks_figure(results)
    if "wrong_picks" in tables:
        charts["wrong_picks"] = wrong_picks_figure(of_all(tables["wrong_picks"]))
    if "blendshapes" in tables:
        charts["blendshapes"] = blendshapes_figure(tables["blendshapes"])
    if "compliances" in tables:
        for recipe in results.plan.recipes:
            charts[f"compliances_{recipe.name}"] = compliances_figure(tables["compliances"], recipe.name)
    if "reliability" in tables:
        charts["reliability"] = reliability_figure(of_all(tables["reliability"]))
    if "peers" in tables:
        charts["peers"] = peers_figure(tables["peers"])
    return {name: chart for name, chart in charts.items() if has_numbers(chart)}

"""Tables from records: the paper's Table 1, the presets, and the study of the landmarks.

Families of bodies stay apart everywhere, and so do stances by the name of their folder: two models of how a breast lies
down are two settings, though both are supine.
"""

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

from breastrig_studies.studies.result_cache import Record
from breastrig_studies.tables.breasts import ALL, BREASTS, by_breasts
from breastrig_studies.tables.table import Cell, Column, Row, Table, mean, mean_row

FAMILIES = {"independent": "independent", "makehuman": "MakeHuman"}
WHO = (Column("family", "bodies", key=True), Column("setting", "stance", key=True))
PATIENT = Column("patient", "patient", key=True)
SURFACE, TRUTH, LANDMARKS = (
    Column("surface_mm", "surface mm"),
    Column("truth_mm", "truth mm"),
    Column("landmarks_mm", "landmarks mm"),
)


def value(answer: dict[str, Any], path: str) -> float | None:
    """The number at a dotted path; None when it is not known."""
    found: Any = answer
    for part in path.split("."):
        found = found[part]
    return None if found is None else float(found)


def groups(records: Iterable[Record]) -> list[tuple[str, str, list[Record]]]:
    """(family, setting, records): independent bodies first, settings by name."""
    gathered: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        gathered.setdefault((record.case.family, record.case.name), []).append(record)
    order = list(FAMILIES)
    return [(*which, gathered[which]) for which in sorted(gathered, key=lambda which: (order.index(which[0]), which))]


def of(records: Iterable[Record], question: str, preset: str | None = None) -> list[Record]:
    """The records of a question (and preset)."""
    return [
        record for record in records if record.unit.question == question and preset in (None, record.unit.recipe.name)
    ]


def by_case(
    name: str,
    caption: str,
    columns: tuple[tuple[Column, str], ...],
    records: Sequence[Record],
) -> Table:
    """One row a case with the numbers at the columns' paths, then the mean, for each family and setting."""
    table = Table(name, caption, (*WHO, PATIENT, *(column for column, _ in columns)))
    for family, setting, chosen in groups(records):
        rows = []
        for record in chosen:
            numbers = [None if record.failed else value(record.answer, path) for _, path in columns]
            rows.append(Row((FAMILIES[family], setting, record.case.patient, *numbers), note=record.failed or ""))
        table.rows.extend([*rows, mean_row((FAMILIES[family], setting, "mean"), rows)])
    return table


TABLE_1 = (
    (Column("time_s", "time s"), "time_s"),
    (Column("surface_mean_mm", "surface mean"), "surface_mm.mean"),
    (Column("surface_std_mm", "std"), "surface_mm.std"),
    (Column("surface_max_mm", "max", 1), "surface_mm.max"),
    (Column("landmarks_mean_mm", "landmarks mean"), "landmark_mm.mean"),
    (Column("landmarks_std_mm", "std"), "landmark_mm.std"),
    (Column("landmarks_max_mm", "max", 1), "landmark_mm.max"),
    (Column("landmarks_min_mm", "min"), "landmark_mm.min"),
    (Column("scan_to_model_mean_mm", "scan to model"), "scan_to_model_mm.mean"),
    (Column("truth_mean_mm", "truth mean"), "truth_mm.mean"),
    (Column("truth_p95_mm", "truth 95 %"), "truth_mm.p95"),
    (Column("coverage", "seen"), "surface_mm.coverage"),
    (Column("iterations", "steps", 0), "iterations"),
)
REFINED = (
    (Column("fit_surface_mm", "surface, fit"), "surface_mm.mean"),
    (Column("refined_surface_mm", "surface, refined"), "refined.surface_mm.mean"),
    (Column("fit_truth_mm", "truth, fit"), "truth_mm.mean"),
    (Column("refined_truth_mm", "truth, refined"), "refined.truth_mm.mean"),
    (Column("fit_turned_triangles", "turned over, fit", 1), "turned_triangles"),
    (Column("refined_turned_triangles", "turned over, refined", 1), "refined.turned_triangles"),
)


def table_1(records: Sequence[Record], preset: str) -> Table:
    """The paper's Table 1 with columns for the truth."""
    return by_case(
        "table1", f"Preset {preset}, all landmarks given; mm and s.", TABLE_1, of(records, "accuracy", preset)
    )


def refined_table(records: Sequence[Record], preset: str) -> Table:
    """The smooth free-form layer on top of the fit."""
    caption = "With and without the free-form layer, mm; triangles turned over, of 5,000."
    return by_case("refined", caption, REFINED, of(records, "accuracy", preset))


def presets_table(records: Sequence[Record], presets: Sequence[str]) -> Table:
    """Presets side by side, means of each family and setting."""
    paths = (
        "time_s",
        "surface_mm.mean",
        "scan_to_model_mm.mean",
        "truth_mm.mean",
        "landmark_mm.mean",
        "iterations",
    )
    columns = (
        Column("time_s", "time s"),
        SURFACE,
        Column("scan_to_model_mm", "scan to model mm"),
        TRUTH,
        LANDMARKS,
        Column("iterations", "steps", 0),
    )
    table = Table("presets", "Means over the cases.", (*WHO, Column("preset", key=True), *columns))
    for family, setting, chosen in groups(of(records, "accuracy")):
        for preset in presets:
            answers = [record.answer for record in of(chosen, "accuracy", preset) if not record.failed]
            numbers = [mean(value(answer, path) for answer in answers) for path in paths]
            table.rows.append(Row((FAMILIES[family], setting, preset, *numbers)))
    return table


def landmarks_table(records: Sequence[Record], preset: str) -> Table:
    """All landmarks given, half of them, none: landmarks and surface."""
    columns = (
        Column("all_given_landmarks_mm", "landmarks, all given"),
        Column("half_given_landmarks_mm", "the other half, half given"),
        Column("none_given_landmarks_mm", "landmarks, none given"),
        Column("all_given_surface_mm", "surface, all given"),
        Column("none_given_surface_mm", "surface, none given"),
        Column("all_given_truth_mm", "truth, all given"),
        Column("none_given_truth_mm", "truth, none given"),
    )
    sources: tuple[tuple[str, str], ...] = (
        ("accuracy", "landmark_mm.mean"),
        ("halves", "landmarks_mm"),
        ("no_landmarks", "landmarks_mm"),
        ("accuracy", "surface_mm.mean"),
        ("no_landmarks", "surface_mm"),
        ("accuracy", "truth_mm.mean"),
        ("no_landmarks", "truth_mm"),
    )
    table = Table("landmarks", "The scan as it lies; mm.", (*WHO, PATIENT, *columns))
    for family, setting, chosen in groups(of(records, "accuracy", preset)):
        rows = []
        for case in chosen:
            same = {r.unit.question: r for r in records if r.case == case.case and r.unit.recipe.name == preset}
            failed = [r.failed for q, _ in sources if (r := same[q]).failed]
            numbers = [None if same[q].failed else value(same[q].answer, path) for q, path in sources]
            rows.append(Row((FAMILIES[family], setting, case.case.patient, *numbers), note=" ".join(failed[:1])))
        table.rows.extend([*rows, mean_row((FAMILIES[family], setting, "mean"), rows)])
    return table


def clicks_table(records: Sequence[Record]) -> Table:
    """True picks against picks that are 5 mm off."""
    columns = (
        (Column("exact_surface_mm", "surface, true picks"), "exact.surface_mm"),
        (Column("clicked_surface_mm", "surface, 5 mm off"), "clicked.surface_mm"),
        (Column("exact_truth_mm", "truth, true picks"), "exact.truth_mm"),
        (Column("clicked_truth_mm", "truth, 5 mm off"), "clicked.truth_mm"),
        (Column("exact_landmarks_mm", "landmarks, true picks"), "exact.landmarks_mm"),
        (Column("clicked_landmarks_mm", "landmarks, 5 mm off"), "clicked.landmarks_mm"),
    )
    return by_case("clicks", "Landmarks are measured to their true places; mm.", columns, of(records, "clicks"))


def turns_table(records: Sequence[Record]) -> Table:
    """Random orientations without landmarks: how often wrong, and how near."""
    counted = ("fits", "failed", "wrong_up", "wrong_facing", "sides_exchanged", "wrong_stance")
    words = ("fits", "failed", "up wrong", "facing wrong", "sides exchanged", "stance wrong")
    table = Table(
        "turns",
        "Up or facing is wrong when it is more than 45° off. Sums of counts, means in mm.",
        (
            *WHO,
            Column("scan", "scan", key=True),
            PATIENT,
            *(Column(name, word, 0) for name, word in zip(counted, words, strict=True)),
            *(SURFACE, TRUTH, LANDMARKS),
        ),
    )
    for family, setting, chosen in groups(of(records, "random_turns")):
        for variant, word in (("as_scanned", "as scanned"), ("without_table", "without table")):
            rows, everything = [], []
            for record in chosen:
                trials = [t for t in record.answer.get("trials", []) if t["variant"] == variant]
                if trials or (record.failed and variant == "as_scanned"):
                    who = (FAMILIES[family], setting, word, record.case.patient)
                    everything += trials
                    rows.append(Row((*who, *turn_numbers(trials, record.case.stance)), note=record.failed or ""))
            if rows:
                who = (FAMILIES[family], setting, word, "all")
                table.rows.extend([*rows, Row((*who, *turn_numbers(everything, chosen[0].case.stance)), mean=True)])
    return table


def turn_numbers(trials: Sequence[dict[str, Any]], stance: str) -> list[Cell]:
    """The counts and means of some trials."""
    good = [trial for trial in trials if not trial["failed"]]
    wrong: list[Cell] = [sum(trial[axis] for trial in good) for axis in ("up", "facing", "sides")]
    means = [mean(trial[name] for trial in good) for name in ("surface_mm", "truth_mm", "landmarks_mm")]
    return [len(trials), len(trials) - len(good), *wrong, sum(trial["stance"] != stance for trial in good), *means]


def wrong_picks_table(records: Sequence[Record]) -> Table:
    """One pick 50 mm off, or sides exchanged: by what was wrong, over the cases of a family."""
    table = Table(
        "wrong_picks",
        "Named: the program says which pick it doubts. False alarms: others that it doubts as well.",
        (
            Column("family", "bodies", key=True),
            Column("what", "what is wrong", key=True),
            Column("picks", "the picks", key=True),
            Column("fits", "fits", 0),
            Column("named", "named", 0),
            Column("false_alarms", "false alarms", 0),
            SURFACE,
            TRUTH,
            Column("wrong_landmarks_mm", "model to their true places mm"),
        ),
    )
    for family in FAMILIES:
        for question, what in (("one_wrong", "one pick 50 mm off"), ("exchanged_sides", "sides exchanged")):
            trials = [t for r in of(records, question) if r.case.family == family for t in r.answer.get("trials", [])]
            if not trials:
                continue
            together: dict[tuple[str, ...], list[dict[str, Any]]] = {}
            for trial in trials:
                together.setdefault(tuple(trial["wrong"]), []).append(trial)
            for wrong, same in [*together.items(), ((), trials)]:
                words = "all together" if not wrong else " and ".join(wrong) if len(wrong) < 3 else "all pairs"
                numbers: list[Cell] = [len(same), sum(t["named"] for t in same)]
                numbers.append(sum(len(t["false_alarms"]) for t in same))
                numbers += [mean(t[name] for t in same) for name in ("surface_mm", "truth_mm", "wrong_landmarks_mm")]
                table.rows.append(Row((FAMILIES[family], what, words, *numbers), mean=not wrong))
    return table


def failures_table(records: Sequence[Record]) -> Table:
    """Every fit that was not possible, with its sentence."""
    who = (*WHO, PATIENT, Column("question", key=True), Column("preset", key=True), Column("sentence", key=True))
    table = Table("failures", "Fits that were not possible.", who)
    for record in records:
        sentences = [record.failed] if record.failed else []
        sentences += [trial["failed"] for trial in record.answer.get("trials", []) if trial.get("failed")]
        case, unit = record.case, record.unit
        for sentence in sentences:
            cells = (FAMILIES[case.family], case.name, case.patient, unit.question, unit.recipe.name, sentence)
            table.rows.append(Row(cells))
    return table


def console(records: Sequence[Record], preset: str) -> str:
    """The means for a terminal, one line a family and setting, then those of hanging and of other breasts."""
    columns = {
        "all_given_surface_mm": "surface",
        "all_given_truth_mm": "truth",
        "all_given_landmarks_mm": "landmarks",
        "half_given_landmarks_mm": "half given",
        "none_given_landmarks_mm": "none given",
    }
    table = by_breasts(partial(landmarks_table, preset=preset), records, means=True)
    lines = [f"{'mean, mm':34s}" + "".join(f"{heading:>12s}" for heading in columns.values())]
    for row in table.rows:
        if row.mean:
            cells = dict(zip((column.name for column in table.columns), row.cells, strict=True))
            about = [cells["family"], cells["setting"], cells.get(BREASTS.name, ALL)]
            words = ", ".join(str(word) for word in about if word != ALL)
            numbers = [cells[name] for name in columns]
            lines.append(
                f"{words:34s}" + "".join(f"{f'{n:.2f}' if isinstance(n, float) else '-':>12s}" for n in numbers)
            )
    return "\n".join(lines)

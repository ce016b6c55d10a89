"""From records to tables: the number of blendshapes, the compliances, the peers, and two stances together."""

from collections.abc import Sequence
from typing import Any

from breastrig.rig.model import Rig
from breastrig_studies.studies.plan import FACTORS, ORDERS, compliances, counts, first_shapes
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.studies.sensitivity import TERMS
from breastrig_studies.tables.accuracy import FAMILIES, LANDMARKS, PATIENT, SURFACE, TRUTH, WHO, groups, of, value
from breastrig_studies.tables.table import Cell, Column, Row, Table, mean, mean_row

NUMBERS = ("surface_mm", "truth_mm", "landmarks_mm")
TIME = Column("time_s", "time s", 3)
PICKS = ("true", "5 mm off")
CARRIED = (  # paths into a row of two_stances.gain
    *("separate_mm.mean", "together_mm.mean", "smooth_separate_mm.mean", "smooth_together_mm.mean"),
    *("smooth_together_mm.p95", "rigid_mm", "spline_mm"),
)
PEERS = {"rigid": "rigid closest points", "nricp_amberg": "free-form (nricp_amberg)"}


def means_of(records: Sequence[Record], names: Sequence[str]) -> list[Cell]:
    """The mean of each named number over the fits that were possible."""
    good = [record.answer for record in records if not record.failed]
    return [mean(value(answer, name) for answer in good) for name in names]


def shapes_table(records: Sequence[Record], rig: Rig, useful: dict[str, dict[str, float]]) -> Table:
    """Error and time against the number of blendshapes, in both orders."""
    columns = (Column("order", "order", key=True), Column("shapes", "blendshapes", 0), SURFACE, TRUTH, LANDMARKS, TIME)
    table = Table("blendshapes", "Means over the cases, all landmarks given.", (*WHO, *columns))
    for family, setting, chosen in groups(of(records, "shape_count")):
        for order in ORDERS:
            for count in counts(len(rig.shapes)):
                names = first_shapes(rig, list(useful[setting]), order, count)
                same = [record for record in chosen if tuple(record.unit.settings["names"]) == names]
                who = (FAMILIES[family], setting, order, count)
                table.rows.append(Row((*who, *means_of(same, (*NUMBERS, "time_s")))))
    return table


def shape_order_table(rig: Rig, useful: dict[str, dict[str, float]]) -> Table:
    """The order of usefulness in each setting, with what a shape did."""
    columns = [Column("place", "place", 0)]
    for setting in useful:
        columns += [
            Column(f"{setting}_shape", f"{setting}: shape", key=True),
            Column(f"{setting}_moved_mm", "moved mm"),
        ]
    table = Table("blendshape_order", "By how much each shape moved the skin on average over the fits.", tuple(columns))
    ordered = [list(effects.items()) for effects in useful.values()]
    for place in range(len(rig.shapes)):
        cells: list[Cell] = [place + 1]
        for effects in ordered:
            cells += effects[place]
        table.rows.append(Row(tuple(cells)))
    return table


def compliance_table(records: Sequence[Record], presets: Sequence[str]) -> Table:
    """Each compliance over decades; factor 1 is the preset itself."""
    columns = (
        Column("family", "bodies", key=True),
        Column("preset", "preset", key=True),
        Column("compliance", "compliance of", key=True),
        Column("factor", "times", 2),
    )
    table = Table("compliances", "Means over all scans of a family.", (*columns, SURFACE, TRUTH, LANDMARKS))
    found = of(records, "compliance")
    for family in FAMILIES:
        for preset in presets:
            chosen = [r for r in found if r.case.family == family and r.unit.recipe.name == preset]
            for term in TERMS if chosen else ():
                for factor in FACTORS:
                    asked = {"term": compliances()[0][0] if factor == 1.0 else term, "factor": factor}
                    same = [record for record in chosen if record.unit.settings == asked]
                    table.rows.append(Row((FAMILIES[family], preset, term, factor, *means_of(same, NUMBERS))))
    return table


def peers_table(records: Sequence[Record], presets: Sequence[str]) -> Table:
    """Our presets and other methods from the same start."""
    columns = (Column("method", "method", key=True), SURFACE, TRUTH, LANDMARKS, TIME)
    table = Table("peers", "Means over the cases, all methods from the same start.", (*WHO, *columns))
    ours = ("surface_mm.mean", "truth_mm.mean", "landmark_mm.mean", "time_s")
    for family, setting, chosen in groups(of(records, "peer")):
        here = [r for r in of(records, "accuracy") if (r.case.family, r.case.name) == (family, setting)]
        for preset in presets:
            who = (FAMILIES[family], setting, f"BreastRig, {preset}")
            table.rows.append(Row((*who, *means_of(of(here, "accuracy", preset), ours))))
        for method, words in PEERS.items():
            same = [record for record in chosen if record.unit.settings["method"] == method]
            failed = next((record.failed for record in same if record.failed), None)
            numbers = means_of(same, (*NUMBERS, "time_s"))
            table.rows.append(Row((FAMILIES[family], setting, words, *numbers), note=failed or ""))
    return table


def two_stances_table(records: Sequence[Record]) -> Table:
    """Points carried from one stance to the other: fits apart, fitted together, and simple means."""
    columns = (
        PATIENT,
        Column("from", "from", key=True),
        Column("to", "to", key=True),
        Column("picks", "picks", key=True),
        Column("separate_mm", "fits apart"),
        Column("together_mm", "together"),
        Column("smooth_separate_mm", "smooth, apart"),
        Column("smooth_together_mm", "smooth, together"),
        Column("smooth_together_p95_mm", "95 %"),
        Column("rigid_mm", "rigid"),
        Column("spline_mm", "spline"),
    )
    caption = (
        "Mean distance between the carried and the true corresponding point, mm; smooth is the program's transfer."
    )
    table = Table("two_stances", caption, (WHO[0], *columns))
    for family in FAMILIES:
        for picks in PICKS:
            rows = []
            for record in of(records, "two_stances"):
                if record.case.family != family:
                    continue
                if record.failed:
                    blank: list[Cell] = ["", "", picks, *(None for _ in CARRIED)]
                    rows.append(Row((FAMILIES[family], record.case.patient, *blank), note=record.failed))
                for found in record.answer.get("rows", []):
                    errors: dict[str, Any] = found["clicks"] if picks == PICKS[1] else found
                    numbers = [value(errors, path) for path in CARRIED]
                    who = (FAMILIES[family], record.case.patient, found["from"], found["to"], picks)
                    rows.append(Row((*who, *numbers)))
            if rows:
                table.rows.extend([*rows, mean_row((FAMILIES[family], "mean", "", "", picks), rows)])
    return table

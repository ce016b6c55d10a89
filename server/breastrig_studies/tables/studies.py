"""Tables from records: the number of blendshapes, the compliances, and the peers."""

from collections.abc import Sequence

from breastrig.rig.model import Rig
from breastrig_studies.studies.plan import FACTORS, ORDERS, compliances, counts, first_shapes
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.studies.sensitivity import TERMS
from breastrig_studies.tables.accuracy import FAMILIES, LANDMARKS, SURFACE, TRUTH, WHO, groups, of, value
from breastrig_studies.tables.table import Cell, Column, Row, Table, mean

NUMBERS = ("surface_mm", "truth_mm", "landmarks_mm")
TIME = Column("time_s", "time s", 3)
PICKS = ("true", "5 mm off")
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

"""Tables from records: drawings transferred to another stance, and to another patient."""

from collections.abc import Sequence

from breastrig_studies.studies.lesions import WAYS as LESION_WAYS
from breastrig_studies.studies.other_patient import ANCHORS, SHAPES
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.studies.transfer import ALL, PICKS, WAYS
from breastrig_studies.tables.accuracy import FAMILIES, PATIENT, WHO, of, value
from breastrig_studies.tables.table import Cell, Column, Row, Table, mean, mean_row

PAIR = (Column("from", "from", key=True), Column("to", "to", key=True))
PICKED = Column("picks", "picks", key=True)
NUMBERS = tuple(column for way in WAYS for column in (Column(f"{way}_mm", way), Column(f"{way}_p95_mm", "95 %")))
PATHS = tuple(f"{way}.{number}" for way in WAYS for number in ("mean_mm", "p95_mm"))


def transfer_table(records: Sequence[Record]) -> Table:
    """All lines together: one row for each patient, direction and kind of picks."""
    caption = (
        "Distance between the carried and the true place of lines on chest and breasts, mm: mean and 95 %. Skin is the "
        "program's way, model that through the fitted models alone; rigid and spline go through the landmarks."
    )
    table = Table("transfer", caption, (WHO[0], PATIENT, *PAIR, PICKED, *NUMBERS))
    for family, word in FAMILIES.items():
        for picks in PICKS:
            rows: list[Row] = []
            for record in of(records, "transfer"):
                if record.case.family != family:
                    continue
                if record.failed:
                    blank: list[Cell] = ["", "", picks, *(None for _ in PATHS)]
                    rows.append(Row((word, record.case.patient, *blank), note=record.failed))
                for row in record.answer.get("rows", []):
                    if (row["line"], row["region"], row["picks"]) == (ALL, ALL, picks):
                        who = (word, record.case.patient, row["from"], row["to"], picks)
                        rows.append(Row((*who, *(value(row, path) for path in PATHS))))
            if rows:
                table.rows.extend([*rows, mean_row((word, "mean", "", "", picks), rows)])
    return table


def lesions_table(records: Sequence[Record]) -> Table:
    """One row for each patient and pair of stances, and their mean for each pair."""
    caption = (
        "Distance between the carried and the true centre of lesions inside the breasts, mm: mean and 95 %. Volume is "
        "the program's way; rigid and spline go through the landmarks of both scans. Held: the share of true centres "
        "within their radii."
    )
    numbers = [column for way in LESION_WAYS for column in (Column(f"{way}_mm", way), Column(f"{way}_p95_mm", "95 %"))]
    columns = (Column("lesions", "lesions", 0), *numbers, Column("held", "held", 2))
    table = Table("lesions", caption, (WHO[0], PATIENT, *PAIR, *columns))
    paths = [f"{way}.{number}" for way in LESION_WAYS for number in ("mean_mm", "p95_mm")]
    for family, word in FAMILIES.items():
        pairs: dict[tuple[str, str], list[Row]] = {}
        for record in of(records, "lesions"):
            for row in record.answer.get("rows", []) if record.case.family == family else []:
                numbers_of = (row["lesions"], *(value(row, path) for path in paths), value(row, "held"))
                cells = Row((word, record.case.patient, row["from"], row["to"], *numbers_of))
                pairs.setdefault((row["from"], row["to"]), []).append(cells)
        for (start, goal), rows in pairs.items():
            table.rows.extend([*rows, mean_row((word, "mean", start, goal, None), rows)])
    return table


def prediction_table(records: Sequence[Record]) -> Table:
    """One row for each patient, predicted stance and kind of place, and their mean for each kind."""
    caption = (
        "Distance between where a standing scan alone predicts skin in another stance and its true place, mm: mean and "
        "95 %, laid on the other scan by its landmarks, and the same for the standing body moved rigidly and, supine, "
        "as on the mean of other patients. Held: the share of places within their radii."
    )
    ways = ("predicted", "rigid", "mean_motion")
    numbers = [column for way in ways for column in (Column(f"{way}_mm", way), Column(f"{way}_p95_mm", "95 %"))]
    key = (Column("to", "to", key=True), Column("places", "places", key=True))
    table = Table("prediction", caption, (WHO[0], PATIENT, *key, *numbers, Column("held", "held", 2)))
    paths = [f"{way}.{number}" for way in ways for number in ("mean_mm", "p95_mm")]
    for family, word in FAMILIES.items():
        kinds: dict[tuple[str, str], list[Row]] = {}
        for record in of(records, "prediction"):
            for row in record.answer.get("rows", []) if record.case.family == family else []:
                known = {"mean_motion": {"mean_mm": None, "p95_mm": None}} | row
                cells = (row["to"], row["places"], *(value(known, path) for path in paths), value(row, "held"))
                kinds.setdefault((row["to"], row["places"]), []).append(Row((word, record.case.patient, *cells)))
        for kind, rows in kinds.items():
            table.rows.extend([*rows, mean_row((word, "mean", *kind), rows)])
    return table


def transfer_lines_table(records: Sequence[Record]) -> Table:
    """Each kind of line and region by itself."""
    columns = (Column("line", "line", key=True), Column("region", "region", key=True), Column("points", "points", 0))
    table = Table(
        "transfer_lines",
        "As above, for each kind of line and region.",
        (WHO[0], PATIENT, *PAIR, PICKED, *columns, *NUMBERS),
    )
    for record in of(records, "transfer"):
        for row in record.answer.get("rows", []):
            if row["line"] != ALL:
                who = (FAMILIES[record.case.family], record.case.patient, row["from"], row["to"], row["picks"])
                what = (row["line"], row["region"], row["points"])
                table.rows.append(Row((*who, *what, *(value(row, path) for path in PATHS))))
    return table


def other_patient_table(records: Sequence[Record]) -> Table:
    """Relative places of shapes in both patients, and how far they differ, as means over pairs of patients."""
    caption = (
        "Distance of a carried shape to a landmark in parts of the distance from nipple to xiphoid: mean in the "
        "patient that it was drawn on, in the other one, and the mean difference between the two."
    )
    columns = (
        *(Column("shape", "shape", key=True), Column("landmark", "to", key=True), Column("pairs", "pairs", 0)),
        *(Column("first", "drawn on"), Column("second", "carried to"), Column("difference", "difference")),
    )
    table = Table("other_patient", caption, (*WHO, *columns))
    found = [record for record in of(records, "other_patient") if not record.failed]
    for family, setting in dict.fromkeys((record.case.family, record.case.name) for record in found):
        rows = [
            row
            for record in found
            if (record.case.family, record.case.name) == (family, setting)
            for row in record.answer["rows"]
        ]
        for shape in SHAPES:
            for anchor in ANCHORS:
                same = [row for row in rows if row["shape"][:-2] == shape and row["landmark"] == anchor]
                if same:
                    numbers: list[Cell] = [mean(row[key] for row in same) for key in ("first", "second")]
                    numbers.append(mean(abs(row["second"] - row["first"]) for row in same))
                    table.rows.append(Row((FAMILIES[family], setting, shape, anchor, len(same), *numbers)))
    return table

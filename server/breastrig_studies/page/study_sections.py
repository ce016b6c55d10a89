"""The sections of the page about the studies: blendshapes, compliances, peers, two stances; and all in their order."""

from collections.abc import Sequence

from breastrig_studies.cohort import Case
from breastrig_studies.evaluate import Results
from breastrig_studies.page import ink_section, sections, transfer_sections, unseen_sections
from breastrig_studies.page.section import Section, capital, mm
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.tables.accuracy import FAMILIES, of
from breastrig_studies.tables.breasts import of_all
from breastrig_studies.tables.certainty import KINDS, covered
from breastrig_studies.tables.measures import PICKS as MEASURED_WITH
from breastrig_studies.tables.studies import PICKS
from breastrig_studies.tables.table import Row, Table, mean


def prone_section(table: Table) -> Section:
    """One sentence a family and kind of fit."""
    place = {column.name: index for index, column in enumerate(table.columns)}

    def words(row: Row) -> str:
        surface, nipples, worst = (
            mm(cell if isinstance(cell, float) else None)
            for cell in (row.cells[place[name]] for name in ("surface_mm", "nipples_mm", "nipples_worst_mm"))
        )
        return (
            f"{str(row.cells[0]).capitalize()} bodies, {row.cells[1]}: the model alone is {surface} from the skin, "
            f"nipples {nipples} off, at worst {worst}; {row.cells[place['unusable']]:.0f} % are called unusable."
        )

    return Section(
        "prone",
        "How good are fits of a breast MRI's skin?",
        "The front of the chest, breasts hanging, fitted with the landmarks that an MRI shows, with every second of "
        "them, with none, and from a start that is turned head down.",
        tuple(words(row) for row in table.rows),
        (),
        ("prone",),
    )


def verdicts_section(table: Table) -> Section:
    """Of whole scans that are fitted rightly, and of all that are not."""
    place = {column.name: index for index, column in enumerate(table.columns)}

    def counted(truth: str, extent: str | None, kinds: tuple[str, ...]) -> tuple[float, int]:
        """Of these fits: how many are called good, and how many there are."""
        good, total = 0.0, 0
        for row in table.rows:
            kind, scan, true, n, share, *_ = row.cells
            if true == truth and extent in (None, scan) and kind in kinds:
                assert isinstance(n, int)
                assert isinstance(share, float)
                good, total = good + n * share / 100.0, total + n
        return good, total

    kinds = tuple(dict.fromkeys(str(row.cells[place["fit"]]) for row in table.rows))
    right, rights = counted("right", "whole", ("landmarks given", "none given"))
    wrong, wrongs = counted("wrong", None, kinds)
    answers = []
    if rights:
        answers.append(f"Of {rights} right fits of whole scans {right:.0f} are called good.")
    if wrongs:
        answers.append(f"Of {wrongs} wrong fits {wrongs - wrong:.0f} are to be checked or unusable.")
    return Section(
        "verdicts",
        "Does the verdict tell right fits from wrong ones?",
        "Each scan is fitted with all landmarks, with none, with the proposals accepted as they are, and from a start "
        "that is turned head down.",
        tuple(answers),
        (),
        ("verdicts",),
    )


def measures_section(table: Table, ptosis: Table | None = None) -> Section:
    """Of lengths and volumes; the table has the ratios too."""
    place = {column.name: index for index, column in enumerate(table.columns)}
    parts = []
    for unit, words in (("mm", "lengths"), ("ml", "volumes")):
        rows = [row.cells for row in table.rows if row.cells[place["unit"]] == unit]
        for kind, picks in MEASURED_WITH.items():
            errors, shares = (
                [value for row in rows if isinstance(value := row[place[f"{kind}_{name}"]], float)]
                for name in ("error", "held")
            )
            if errors and shares:
                mean, held = sum(errors) / len(errors), sum(shares) / len(shares)
                parts.append(f"{words}, {picks}: {mean:.1f} {unit} off on average, {held:.0f} % within the band")
    return Section(
        "measures",
        "Are the report's measures right?",
        "Each measure is compared with the same measure on the whole true surface, between the true landmarks.",
        ("; ".join(parts).capitalize() + ".",) if parts else (),
        (),
        ("measures",) if ptosis is None else ("measures", "ptosis"),
    )


def colour_section(landmarks: Table, areolae: Table | None) -> Section:
    """What colour brings to proposed landmarks, and the areolae's diameters."""
    answers = []
    for row in landmarks.rows:
        number = _by_name(landmarks, row)
        if number["landmark"] == "nipple":
            coloured, p95, form = (mm(_float(number[name])) for name in ("coloured_mm", "p95_mm", "form_mm"))
            answers.append(
                f"Nipples are proposed within {coloured} (95 %: {p95}) where the form alone gives {form}; left and "
                f"right are exchanged on {number['exchanged']} scans."
            )
    for row in [] if areolae is None else areolae.rows:
        number = _by_name(areolae, row) if areolae is not None else {}
        if row.mean and number["bias_mm"] is not None:
            answers.append(
                f"Diameters of areolae are off by {_float(number['bias_mm']):+.1f} mm in the mean, with a deviation of "
                f"{mm(_float(number['deviation_mm']))}."
            )
    return Section(
        "colour_landmarks",
        "What do colours say of the landmarks?",
        "Areolae are looked for near the place that the form of the body expects, on painted virtual skins: "
        "photographs of real skin may give other numbers. What is not seen, covered or reconstructed, stays with the "
        "form.",
        tuple(answers),
        (),
        ("colour_landmarks", *(("areolae",) if areolae is not None else ())),
    )


def _by_name(table: Table, row: Row) -> dict[str, str | int | float | None]:
    return dict(zip((column.name for column in table.columns), row.cells, strict=True))


def _float(cell: str | int | float | None) -> float:
    return float(cell or 0.0)


def certainty_section(records: Sequence[Record]) -> Section:
    answers = []
    for family in FAMILIES:
        found = [record for record in of(records, "certainty") if record.case.family == family and not record.failed]
        if not found:
            continue
        parts = []
        for kind, words in KINDS.items():
            shares = [covered(found, kind, part) for part in ("landmarks", "skin")]
            if all(total for _, total in shares):
                marks, skin = (100 * good / total for good, total in shares)
                parts.append(f"{words}: {marks:.0f} % of landmarks, {skin:.0f} % of the skin")
        trials = [trial for record in found for trial in record.answer.values()]
        picks, dropped, asked = (sum(trial[key] for trial in trials) for key in ("picks", "dropped", "unusual"))
        answers.append(
            f"{capital(family)}, within the radius: {'; '.join(parts)}. Of {picks} right picks {dropped} were rejected "
            f"and {asked} asked about."
        )
    return Section(
        "certainty",
        "Does the program know how far off it is, and does it believe right picks?",
        "Each landmark and each vertex has a radius that should hold its true place nine times of ten. True places of "
        "vertices are those of a fit to the whole true surface. The figure: what radii of 50, 80, 90 and 95 % hold; on "
        "the line “as said” they hold what they say, above it they are too wide, below it too narrow.",
        tuple(answers),
        ("reliability",),
        ("reliability", "certainty", "believed"),
    )


def _over_scans(rows: Sequence[Row], column: int, cases: Sequence[Case]) -> float | None:
    """The mean over scans of a column of means of settings, whose rows begin with family and setting."""
    total, scans = 0.0, 0
    for row in rows:
        number = _number(row.cells[column])
        here = sum((FAMILIES[case.family], case.name) == row.cells[:2] for case in cases)
        if number is not None and not row.note:
            total, scans = total + here * number, scans + here
    return total / scans if scans else None


def _number(cell: object) -> float | None:
    return float(cell) if isinstance(cell, int | float) else None


def blendshapes(table: Table, effects: Table, cases: Sequence[Case]) -> Section:
    last = max(int(row.cells[3] or 0) for row in table.rows)
    answers = []
    for family, word in FAMILIES.items():
        rows = [row for row in table.rows if row.cells[0] == word and row.cells[2] == "usefulness"]
        if not rows:
            continue

        def at(count: int, column: int, rows: Sequence[Row] = rows) -> float | None:
            return _over_scans([row for row in rows if row.cells[3] == count], column, cases)

        without, with_all = at(0, 4), at(last, 4)
        if without is None or with_all is None:
            continue
        enough = last
        for count in sorted({int(row.cells[3] or 0) for row in rows}, reverse=True):
            here = at(count, 4)
            if here is not None and here <= 1.1 * with_all:
                enough = count
            else:
                break
        answers.append(
            f"{capital(family)}: {mm(without)} from the scanned skin without blendshapes and {mm(with_all)} with all "
            f"{last}; the {enough} most useful ones come within a tenth of that. Solving takes "
            f"{at(0, 7):.3f} s without and {at(last, 7):.3f} s with all."
        )
    return Section(
        "blendshapes",
        "How many blendshapes are needed?",
        "The paper's Figures 5 and 6: blendshapes added five at a time. Useful is what moved the skin most "
        "over the fits "
        "of the same stance: the mean of |weight| times the shape's root mean square displacement.",
        tuple(answers),
        ("blendshapes",),
        ("blendshapes", effects.name),
    )


def compliances(table: Table, names: Sequence[str]) -> Section:
    answers = []
    for family, word in FAMILIES.items():
        for preset in names:
            rows = [row for row in table.rows if row.cells[0] == word and row.cells[1] == preset]
            if not rows:
                continue
            spans = {}
            for term in dict.fromkeys(str(row.cells[2]) for row in rows):
                values = [_number(row.cells[4]) for row in rows if row.cells[2] == term]
                known = [number for number in values if number is not None]
                marks = [n for row in rows if row.cells[2] == term and (n := _number(row.cells[6])) is not None]
                if known and marks:
                    spans[term] = (max(known) - min(known), max(marks) - min(marks))
            if not spans:
                continue
            by_surface, by_landmarks = (max(spans, key=lambda term: spans[term][k]) for k in (0, 1))
            answers.append(
                f"{capital(family)}, preset {preset}: the surface answers most to the compliance of the {by_surface} "
                f"(it varies by {mm(spans[by_surface][0])}), the landmarks most to that of the {by_landmarks} "
                f"(by {mm(spans[by_landmarks][1])})."
            )
    return Section(
        "compliances",
        "How much do the settings matter?",
        "The paper's Figures 7 and 8: one compliance at a time made ten and a hundred times smaller and "
        "larger, the others "
        "as in the preset.",
        tuple(answers),
        tuple(f"compliances_{name}" for name in names),
        (table.name,),
    )


def peers(table: Table, cases: Sequence[Case]) -> Section:
    answers = []
    for family, word in FAMILIES.items():
        parts = []
        rows = [row for row in table.rows if row.cells[0] == word]
        for method in dict.fromkeys(str(row.cells[2]) for row in rows):
            same = [row for row in rows if row.cells[2] == method]
            numbers = [_over_scans(same, column, cases) for column in (3, 4, 6)]
            time = "" if numbers[2] is None else f", {numbers[2]:.2f} s"
            truth = "" if numbers[1] is None else f", {mm(numbers[1])} from the true one"
            parts.append(f"{method} {mm(numbers[0])} from the scanned skin{truth}{time}")
        if parts:
            answers.append(f"{capital(family)}: {'; '.join(parts)}.")
    return Section(
        "peers",
        "What do other methods reach?",
        "The same template from the same start (a similarity from the landmarks): rigid closest points, and trimesh's "
        "free-form registration (nricp_amberg, after Amberg and others, 2007), which is given the landmarks as well. A "
        "free-form registration follows the scan's noise and has no bones or shapes to carry to another stance.",
        tuple(answers),
        ("peers",),
        (table.name,),
    )


def two_stances(table: Table) -> Section:
    names = [column.name for column in table.columns]
    answers = []
    for family, word in FAMILIES.items():
        for picks in PICKS:
            rows = [row for row in table.rows if row.cells[0] == word and row.cells[4] == picks]
            rows = [row for row in rows if not row.mean and not row.note]
            if not rows:
                continue

            def over(column: str, rows: Sequence[Row] = rows) -> str:
                return mm(mean(_number(row.cells[names.index(column)]) for row in rows), 1)

            answers.append(
                f"{capital(family)}, picks {'true' if picks == PICKS[0] else '5 mm off'}, {len(rows)} transfers: by "
                f"the "
                f"model {over('separate_mm')} with the fits apart and {over('together_mm')} together; by the program's "
                f"smooth transfer {over('smooth_separate_mm')} and {over('smooth_together_mm')}; a rigid motion leaves "
                f"{over('rigid_mm')}, a spline through the landmarks {over('spline_mm')}."
            )
    return Section(
        "two-stances",
        "Does it help to fit two stances of one patient together?",
        "Points of the skin carried from one stance to the other, measured to the true corresponding points "
        "on chest and "
        "breasts that both scans saw.",
        tuple(answers),
        ("two_stances",),
        (table.name,),
    )


def all_sections(results: Results, tables: dict[str, Table]) -> list[Section]:
    """What the page says, in its order; the pictures follow the first."""
    found = []
    if "colour_landmarks" in tables:
        found.append(colour_section(tables["colour_landmarks"], tables.get("areolae")))
    if "ink" in tables:
        found.append(ink_section.ink_section(results.records, tables["ink"]))
    if not results.plan.plain:
        return [*found, sections.failures(tables.get("failures"))]
    found += [sections.surface(results), sections.landmarks(results)]
    if "turns" in tables:
        found.append(sections.turns(results))
    found += [sections.clicks(results), sections.wrong_picks(results)]
    if "unseen" in tables:
        found.append(unseen_sections.unseen_section(results.records))
    if "prone" in tables:
        found.append(prone_section(tables["prone"]))
    if "certainty" in tables:
        found.append(certainty_section(results.records))
    if "measures" in tables:
        found.append(measures_section(tables["measures"], tables.get("ptosis")))
    if "verdicts" in tables:
        found.append(verdicts_section(of_all(tables["verdicts"])))
    if "blendshapes" in tables:
        found.append(blendshapes(tables["blendshapes"], tables["blendshape_order"], results.plan.cases))
    if "compliances" in tables:
        found.append(compliances(tables["compliances"], [recipe.name for recipe in results.plan.recipes]))
    found.append(sections.presets(results))
    if "peers" in tables:
        found.append(peers(tables["peers"], results.plan.cases))
    if "two_stances" in tables:
        found.append(two_stances(tables["two_stances"]))
    if "transfer" in tables:
        found.append(transfer_sections.transfer(tables["transfer"]))
    if "lesions" in tables:
        found.append(transfer_sections.lesions(tables["lesions"]))
    if "prediction" in tables:
        found.append(transfer_sections.prediction(tables["prediction"]))
    if "other_patient" in tables:
        found.append(transfer_sections.other_patient(tables["other_patient"]))
    return [*found, sections.refined(results), sections.failures(tables.get("failures"))]

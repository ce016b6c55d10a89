"""The whole evaluation: measure what is not yet measured, then make the tables."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from breastrig.gltf.read_rig import read_rig
from breastrig_studies.studies.plan import Plan, shape_effects
from breastrig_studies.studies.result_cache import Record, records
from breastrig_studies.tables import accuracy as tables
from breastrig_studies.tables import certainty as certainty_tables
from breastrig_studies.tables import colour_landmarks as colour_landmark_tables
from breastrig_studies.tables import ink as ink_tables
from breastrig_studies.tables import measures as measures_tables
from breastrig_studies.tables import studies as study_tables
from breastrig_studies.tables import transfer as transfer_tables
from breastrig_studies.tables import unseen as unseen_tables
from breastrig_studies.tables import verdicts as verdict_tables
from breastrig_studies.tables.breasts import by_breasts
from breastrig_studies.tables.prone import prone_table
from breastrig_studies.tables.table import Table

WORK = "work"  # folder of the records


@dataclass(frozen=True, eq=False)
class Results:
    """All results of an evaluation."""

    plan: Plan
    records: list[Record]
    useful: dict[str, dict[str, float]]  # setting -> shape -> mm, best first


def measured(plan: Plan, folder: Path, jobs: int, again: bool, progress: Callable[[int, str], None]) -> Results:
    """All answers of the plan, kept under folder/work; `progress` gets how many there are, and each one's end."""
    rig = read_rig(plan.model)
    first = plan.first_round()
    rehearsal = {case.name: rig.shape_names for case in plan.plain}
    total = len(first) + len(plan.second_round(rig, rehearsal))  # about: some shape sets are the same in both orders
    found = records(first, folder / WORK, jobs, again, lambda label: progress(total, label))
    useful = shape_effects(tables.of(found, "accuracy", plan.recipes[0].name), rig)
    second = plan.second_round(rig, {name: tuple(effects) for name, effects in useful.items()})
    if second:
        total = len(first) + len(second)
        found += records(second, folder / WORK, jobs, again, lambda label: progress(total, label))
    return Results(plan, found, useful)


def all_tables(results: Results) -> list[Table]:
    """Every table that has rows, Table 1 first."""
    return [table for table in possible_tables(results) if table.rows]


def possible_tables(results: Results) -> list[Table]:
    """Every table, also those of which nothing was asked."""
    found, presets = results.records, [recipe.name for recipe in results.plan.recipes]
    rig, studied = read_rig(results.plan.model), not results.plan.quick and bool(results.plan.plain)
    return [
        tables.table_1(found, presets[0]),
        tables.refined_table(found, presets[0]),
        tables.presets_table(found, presets),
        by_breasts(partial(tables.landmarks_table, preset=presets[0]), found, means=True),
        tables.turns_table(found),
        tables.clicks_table(found),
        by_breasts(tables.wrong_picks_table, found),
        study_tables.shapes_table(found, rig, results.useful),
        *([study_tables.shape_order_table(rig, results.useful)] if studied else []),
        study_tables.compliance_table(found, presets),
        study_tables.peers_table(found, presets),
        transfer_tables.transfer_table(found),
        transfer_tables.transfer_lines_table(found),
        transfer_tables.lesions_table(found),
        transfer_tables.prediction_table(found),
        transfer_tables.other_patient_table(found),
        unseen_tables.unseen_table(found),
        prone_table(found),
        by_breasts(certainty_tables.certainty_table, found),
        by_breasts(certainty_tables.reliability_table, found),
        by_breasts(certainty_tables.believed_table, found),
        measures_tables.measures_table(found),
        measures_tables.ptosis_table(found),
        by_breasts(verdict_tables.verdicts_table, found),
        colour_landmark_tables.colour_landmarks_table(found),
        colour_landmark_tables.areolae_table(found),
        ink_tables.ink_table(found),
        ink_tables.ink_transfer_table(found),
        tables.failures_table(found),
    ]

"""The sections of the page that every run has; see section.py for their form."""

from collections.abc import Sequence

from breastrig_studies.evaluate import Results
from breastrig_studies.page.figures import spaced
from breastrig_studies.page.section import Section, capital, mm
from breastrig_studies.studies.result_cache import Record
from breastrig_studies.tables.accuracy import FAMILIES, of, turn_numbers, value
from breastrig_studies.tables.table import Table, mean


def _family(records: Sequence[Record], family: str) -> list[Record]:
    return [record for record in records if record.case.family == family and not record.failed]


def _means(records: Sequence[Record], path: str) -> float | None:
    return mean(value(record.answer, path) for record in records)


def surface(results: Results) -> Section:
    answers = []
    for family in FAMILIES:
        fits = _family(of(results.records, "accuracy", results.plan.recipes[0].name), family)
        if not fits:
            continue
        worst = max(fits, key=lambda fit: value(fit.answer, "surface_mm.mean") or 0.0)
        truth = _means(fits, "truth_mm.mean")
        to_truth = "" if truth is None else f" and {mm(truth)} from the true one"
        answers.append(
            f"{capital(family)}, {len(fits)} scans: on average the model lies {mm(_means(fits, 'surface_mm.mean'))} "
            f"from the scanned skin{to_truth}, and the given landmarks end "
            f"{mm(_means(fits, 'landmark_mm.mean'))} from "
            f"their places, after {_means(fits, 'time_s'):.2f} s of solving. The farthest scan is "
            f"{spaced(worst.case.patient)}, {spaced(worst.case.name)}, with "
            f"{mm(value(worst.answer, 'surface_mm.mean'))} to the scanned skin."
        )
    return Section(
        "surface",
        "How near is the surface, and how long does it take?",
        "The paper's Table 1: every scan fitted with all its landmarks. Surface: from each model vertex with an "
        "accepted pair to the scan. Truth: from each vertex that the scan shows to the noise-free skin. Time: the "
        "solver alone on one core, the median of three fits. On seven real patients, so not like with like, the paper "
        "reports 2.35 mm to the surface, 8.03 mm to given landmarks and 20.1 mm to others, in 2.03 s.",
        tuple(answers),
        ("table1",),
        ("table1",),
    )


def landmarks(results: Results) -> Section:
    answers = []
    for family in FAMILIES:
        given = _family(of(results.records, "accuracy", results.plan.recipes[0].name), family)
        half = _family(of(results.records, "halves"), family)
        none = _family(of(results.records, "no_landmarks"), family)
        if not given:
            continue
        answers.append(
            f"{capital(family)}: {mm(_means(given, 'landmark_mm.mean'), 1)} at landmarks that were given, "
            f"{mm(_means(half, 'landmarks_mm'), 1)} at the other half when half were given, "
            f"{mm(_means(none, 'landmarks_mm'), 1)} when none were. The surface is "
            f"{mm(_means(given, 'surface_mm.mean'))} from the scan with landmarks and "
            f"{mm(_means(none, 'surface_mm'))} without."
        )
    return Section(
        "landmarks",
        "Where do landmarks end up that nobody picked?",
        "The paper's Figure 4, and a harder form of it: half of the landmarks are given and the other half "
        "measured, both "
        "ways round; or none is given and the program finds the body itself, the scan lying as it was scanned.",
        tuple(answers),
        ("landmarks",),
        ("landmarks",),
    )


def turns(results: Results) -> Section:
    answers = []
    for family in FAMILIES:
        scans = _family(of(results.records, "random_turns"), family)
        trials = [(trial, scan.case.stance) for scan in scans for trial in scan.answer["trials"]]
        if not trials:
            continue
        good = [trial for trial, _ in trials if not trial["failed"]]
        up, facing, sides = (sum(trial[axis] for trial in good) for axis in ("up", "facing", "sides"))
        stance = sum(trial["stance"] != known for trial, known in trials if not trial["failed"])
        numbers = turn_numbers([trial for trial, _ in trials], "")
        assert not isinstance(numbers[6], str)
        assert not isinstance(numbers[8], str)
        answers.append(
            f"{capital(family)}: of {len(trials)} fits {len(trials) - len(good)} failed, {up} ended with up more "
            f"than 45° "
            f"off, {facing} facing more than 45° off, {sides} with left and right exchanged, and {stance} took the "
            f"patient for standing or lying wrongly. The mean distance is {mm(numbers[6])} to the scanned skin and "
            f"{mm(numbers[8], 1)} to the landmarks."
        )
    return Section(
        "turns",
        "What if no landmark is picked, and the scan lies anyhow?",
        "Every scan turned at random over the whole sphere and shifted, fitted without any landmark. Lying "
        "patients also "
        "without the table: there nothing but the body tells how she lies, and the stance is a guess.",
        tuple(answers),
        ("turns",),
        ("turns",),
    )


def clicks(results: Results) -> Section:
    answers = []
    for family in FAMILIES:
        found = _family(of(results.records, "clicks"), family)
        if not found:
            continue
        pairs = {
            name: (_means(found, f"exact.{name}"), _means(found, f"clicked.{name}"))
            for name in ("surface_mm", "truth_mm", "landmarks_mm")
        }
        named = sum(len(trial["named"]) for record in found for trial in record.answer["trials"])
        picks = sum(len(record.answer["trials"]) for record in found)
        answers.append(
            f"{capital(family)}: to the scanned skin {mm(pairs['surface_mm'][0])} with true picks and "
            f"{mm(pairs['surface_mm'][1])} with picks 5 mm off; to the true skin {mm(pairs['truth_mm'][0])} and "
            f"{mm(pairs['truth_mm'][1])}; the landmarks end {mm(pairs['landmarks_mm'][0], 1)} and "
            f"{mm(pairs['landmarks_mm'][1], 1)} from their true places. In {picks} fits {named} of these picks were "
            "doubted."
        )
    return Section(
        "clicks",
        "What if the surgeon clicks 5 mm off?",
        "Every landmark picked 5 mm along the skin from its true place, in random directions, four times over.",
        tuple(answers),
        ("clicks",),
        ("clicks",),
    )


def wrong_picks(results: Results) -> Section:
    answers = []
    for family in FAMILIES:
        for question, words in (
            ("one_wrong", "one pick 50 mm off was named"),
            ("exchanged_sides", "exchanged sides were named"),
        ):
            trials = [t for r in _family(of(results.records, question), family) for t in r.answer["trials"]]
            if not trials:
                continue
            named = sum(trial["named"] for trial in trials)
            alarms = sum(len(trial["false_alarms"]) for trial in trials)
            answers.append(
                f"{capital(family)}: {words} in {named} of {len(trials)} fits, with {alarms} false alarms; the model "
                f"came "
                f"{mm(mean(trial['truth_mm'] for trial in trials))} from the true skin and "
                f"{mm(mean(trial['wrong_landmarks_mm'] for trial in trials), 1)} from the true places of the wrong "
                f"picks."
            )
    return Section(
        "wrong-picks",
        "What if a pick is wrong?",
        "Each landmark in turn picked 50 mm away along the skin while the others are right; then each pair "
        "with left and "
        "right exchanged, and all pairs at once. Named: the program says which pick it doubts.",
        tuple(answers),
        ("wrong_picks",),
        ("wrong_picks",),
    )


def presets(results: Results) -> Section:
    answers = []
    for family in FAMILIES:
        parts = []
        for recipe in results.plan.recipes:
            fits = _family(of(results.records, "accuracy", recipe.name), family)
            if fits:
                time = _means(fits, "time_s")
                parts.append(
                    f"{recipe.name} {mm(_means(fits, 'truth_mm.mean'))} from the true skin, "
                    f"{mm(_means(fits, 'landmark_mm.mean'), 1)} from the landmarks, {time:.2f} s"
                )
        if parts:
            answers.append(f"{capital(family)}: {'; '.join(parts)}.")
    return Section(
        "presets",
        "How do the presets compare?",
        "The same scans, landmarks and start with each preset. The preset “paper” follows the paper's terms, "
        "compliances "
        "and stop rule.",
        tuple(answers),
        (),
        ("presets",),
    )


def refined(results: Results) -> Section:
    answers = []
    for family in FAMILIES:
        fits = _family(of(results.records, "accuracy", results.plan.recipes[0].name), family)
        if fits:
            answers.append(
                f"{capital(family)}: to the scanned skin {mm(_means(fits, 'surface_mm.mean'))} before and "
                f"{mm(_means(fits, 'refined.surface_mm.mean'))} after, to the true skin "
                f"{mm(_means(fits, 'truth_mm.mean'))} before and {mm(_means(fits, 'refined.truth_mm.mean'))} after."
            )
    return Section(
        "refined",
        "Does the free-form layer come nearer to the true skin, or only to the noise?",
        "The smooth layer of --refine on top of the same fits.",
        tuple(answers),
        (),
        ("refined",),
    )


def failures(table: Table | None) -> Section:
    count = len(table.rows) if table else 0
    words = "No fit failed." if not count else f"{count} fits were not possible; each is listed with its reason."
    return Section("failures", "What failed?", "", (words,), (), (table.name,) if table else ())

"""Estimates the weight of each sign of a stance where no table is seen (fitting/starts/stance_signs.toml).

    python model_assets/make_poses.py DIR/poses
    breastrig evaluate --warped 24 COHORT -o DIR --quick
    python -m breastrig_studies.gravity.prone_scans COHORT DIR/prone
    python -m breastrig_studies.stance_signs DIR/poses DIR/warped DIR/prone

Scans are whole and without their tables, fitted without landmarks and with all that are on them; a part of each and
prone skins are fitted without. Printed are the signs' numbers, from the development group without landmarks, and how
many answers are wrong, marked as unsure or not: in the development group each patient by the others, else by the
numbers that are kept. Fits of whole scans that failed, whose stance has no meaning, are left out, and so is the test
set (evaluate --test).
"""

import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import PRONE, STANDING, SUPINE
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.starts.stance_signs import (
    LikelyStance,
    Sign,
    StanceLogOdds,
    StanceSigns,
    likely_stance,
    measured_signs,
    stance_signs,
)
from breastrig.fitting.task import FitTask
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import DEVELOPMENT, VALIDATION, Case, read_cohort
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.trust.captured import captured_scene

ASTRAY = 0.04  # m, mean distance of the landmarks
MOST = 1.5  # standard deviations, of any sign: a patient with almost no breasts shows little, not much
RIDGE = {SUPINE: 3.0, PRONE: 0.1}  # of the weights, in units of scans, of which each patient has many, or one
ALONE = "none"  # of the landmarks are given
GROUPS = (DEVELOPMENT, VALIDATION)
WHOLE, PARTS = "as_it_is", ("breasts_only", "above_nipples", "below_nipples", "one_side")  # of virtual/as_captured.py


@dataclass(frozen=True, eq=False)
class ScanSigns:
    """One scan, and what it shows of the stance."""

    kind: str  # folder, pose, condition and landmarks
    half: str
    source: str
    stance: str
    signs: Mapping[str, float]


def signs_of_scans(folder: Path, rig: Rig) -> Iterator[ScanSigns]:
    """All scans but the test set's; each is kept beside the folder, so that it is fitted once."""
    kept = folder.parent / f"signs_{folder.name}"
    kept.mkdir(exist_ok=True)
    for number, case in enumerate(read_cohort(folder)):
        file = kept / f"{case.patient}_{case.name}.json"
        if case.held_out:
            continue
        if not file.is_file():
            patient = json.loads((folder / case.patient / "patient.json").read_text("utf-8"))
            half, source = case.group or GROUPS[number % 2], patient.get("source", case.patient)
            found = [
                ScanSigns(f"{folder.name} {case.name} {kind}", half, source, case.stance, signs)
                for kind, signs in signs_of(case, rig, PARTS[number % len(PARTS)])
            ]
            file.write_text(json.dumps([asdict(each) for each in found]), "utf-8")
        yield from (ScanSigns(**each) for each in json.loads(file.read_text("utf-8")))


def signs_of(case: Case, rig: Rig, part: str) -> Iterator[tuple[str, Mapping[str, float]]]:
    """(condition and landmarks, signs) of the whole scan and of a part of it, or of a prone skin."""
    recipe, scene = load_recipe("default"), read_scene(case)
    asked = [(WHOLE, ALONE), (WHOLE, "all"), (part, ALONE)] if case.stance != PRONE else [(PRONE, ALONE)]
    for condition, given in asked:
        seen = scene if condition == PRONE else captured_scene(scene, condition)  # without the table
        picks = {} if given == ALONE else dict(seen.landmarks)
        start = seen.start(rig, picks)
        task = FitTask(rig, seen.target, start, recipe, {}, STANDING).with_picks(picks)
        *_, last = checked_iterates(task)
        if condition != WHOLE or seen.landmark_errors(rig, pose(rig, last.parameters)).mean() < ASTRAY:
            yield f"{condition} {given}", measured_signs(task, last)


def weights_of(scans: Sequence[ScanSigns], stance: str) -> Array:
    """(N,) what each counts: this stance as all others, sources nearer to each other than their scans' numbers."""
    counts = np.ones(len(scans))
    for of in ([s.source for s in scans], [str(s.stance == stance) for s in scans]):
        names = np.array(of)
        for name in {*of}:
            counts[names == name] /= (
                np.sqrt(counts[names == name].sum()) if len({*of}) > 2 else counts[names == name].sum()
            )
    return np.asarray(counts * len(counts) / counts.sum())


def estimated(scans: Sequence[ScanSigns], kept: StanceLogOdds, stance: str) -> StanceLogOdds:
    """Logistic regression with a ridge over the standardised signs, cut off, times the length; Newton's method.

    Signs that scans turned at random do not have are kept as they are.
    """
    names, weights = [name for name, sign in kept.signs.items() if not sign.by_hand], weights_of(scans, stance)
    values = np.array([[s.signs.get(name, np.nan) for name in names] for s in scans])
    lies, known = np.array([s.stance == stance for s in scans]), np.isfinite(values)
    mean = np.nansum(values * weights[:, None], axis=0) / (known * weights[:, None]).sum(axis=0)
    values = np.where(known, values, mean)  # says nothing
    deviation = np.sqrt(np.average((values - mean) ** 2, axis=0, weights=weights))
    rows = np.clip((values - mean) / deviation, -MOST, MOST)
    usual = kept.length
    lengths = np.array([1.0 if usual is None else s.signs.get("length", usual) / usual for s in scans])
    rows, slopes = lengths[:, None] * np.column_stack([rows, np.ones(len(values))]), np.zeros(len(names) + 1)
    ridge = np.diag([RIDGE[stance]] * len(names) + [0.0])
    for _ in range(30):
        odds = 1.0 / (1.0 + np.exp(-rows @ slopes))
        curved = (rows * (weights * odds * (1.0 - odds))[:, None]).T @ rows + ridge
        slopes -= np.linalg.solve(curved, rows.T @ (weights * (odds - lies)) + ridge @ slopes)
    found = {
        name: Sign(between=mean[k], weight=slopes[k] / deviation[k], most=MOST * deviation[k])
        for k, name in enumerate(names)
    }
    return kept.model_copy(update={"constant": slopes[-1], "signs": kept.signs | found})


def of_whole(scans: Sequence[ScanSigns]) -> list[ScanSigns]:
    return [s for s in scans if f" {WHOLE} " in s.kind]


def all_estimated(scans: Sequence[ScanSigns], kept: StanceSigns) -> StanceSigns:
    """Supine against standing of whole scans, prone against everything else."""
    supine = estimated(of_whole(scans), kept.supine, SUPINE)
    return kept.model_copy(update={"supine": supine, "prone": estimated(scans, kept.prone, PRONE)})


def table(scans: Sequence[ScanSigns], found: Sequence[LikelyStance]) -> Iterator[str]:
    """A line for each kind."""
    for kind in sorted({s.kind for s in scans}):
        here = [(s.stance == each.stance, each.sure) for s, each in zip(scans, found, strict=True) if s.kind == kind]
        yield (
            f"  {kind:40s} of {len(here):3d} wrong {here.count((False, True)):2d}, wrong and unsure "
            f"{here.count((False, False)):2d}, right and unsure {here.count((True, False)):2d}"
        )


def say(lines: Iterable[str]) -> None:
    sys.stdout.writelines(f"{line}\n" for line in lines)


def main(folders: Sequence[Path]) -> None:
    """Measures what is not measured yet, and prints."""
    rig, kept = read_rig(default_rig_path()), stance_signs()
    scans = [each for folder in folders for each in signs_of_scans(folder, rig)]
    development = [s for s in scans if s.half == DEVELOPMENT]
    alone = [s for s in development if s.kind.endswith(ALONE)]
    for stance, against in ((SUPINE, all_estimated(alone, kept).supine), (PRONE, all_estimated(alone, kept).prone)):
        say([f"{stance}: constant {against.constant:.3g}"])
        for name, sign in against.signs.items():
            say([f"{stance}.{name}: between {sign.between:.4g}, weight {sign.weight:.4g}, most {sign.most:.3g}"])
    by_others = {
        source: all_estimated([s for s in alone if s.source != source], kept)
        for source in {s.source for s in development}
    }
    say(["development group, each patient by the others"])
    say(table(development, [likely_stance(s.signs, by_others[s.source]) for s in development]))
    for group in GROUPS:
        its = [s for s in scans if s.half == group]
        say([f"the kept numbers, group: {group}"])
        say(table(its, [likely_stance(s.signs) for s in its]))


if __name__ == "__main__":
    given = arguments(__doc__, "FOLDER...")
    main([Path(each) for each in given.folder])

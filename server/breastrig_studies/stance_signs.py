"""Finds how much each sign of a stance says where no table is seen (fitting/starts/stance_signs.toml).

    python model_assets/make_poses.py DIR/poses
    breastrig evaluate --warped 24 COHORT -o DIR --quick
    python -m breastrig_studies.stance_signs DIR/poses DIR/warped

Scans are whole and without their tables; each is fitted without landmarks and with all that are on it.  Printed are the
signs' numbers, from the choosing women without landmarks, and how many answers are wrong, said to be unsure or not: in
the choosing group each woman by the others, else by the numbers that are kept.  Fits that went
astray, whose stance says nothing, are left out, and so are sealed women (evaluate --sealed).
"""

import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.fitting.picks.checked_fit import checked_iterates
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.supine_or_standing import Sign, StanceSigns, measured_signs, stance_signs
from breastrig.fitting.task import FitTask
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose
from breastrig_studies.cohort import read_cohort
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.trust.captured import captured_scene

ASTRAY = 0.04  # m, mean distance of the landmarks
MOST = 1.5  # standard deviations, of any sign: a woman with next to no breasts shows little, not much
RIDGE = 3.0  # of the weights, in units of scans, of which each woman has many; 1.5 is surer and no better
ALONE = "none"  # of the landmarks are given
GROUPS = ("choose", "report")


@dataclass(frozen=True, eq=False)
class ScanSigns:
    """One scan, and what it shows of the stance."""

    kind: str  # folder, pose and landmarks
    half: str
    source: str
    lies: bool
    signs: Mapping[str, float]


def signs_of_scans(folder: Path, rig: Rig) -> Iterator[ScanSigns]:
    """All scans that are placed and not sealed; each is kept beside the folder, so that it is fitted once."""
    recipe, kept = load_recipe("default"), folder.parent / f"signs_{folder.name}"
    kept.mkdir(exist_ok=True)
    for case in read_cohort(folder):
        patient = json.loads((folder / case.patient / "patient.json").read_text("utf-8"))
        file = kept / f"{case.patient}_{case.name}.json"
        if case.sealed:
            continue
        if not file.is_file():
            found = []
            scene = captured_scene(read_scene(case), "as_it_is")  # without the table
            for given, picks in ((ALONE, {}), ("all", dict(scene.landmarks))):
                task = FitTask(rig, scene.target, scene.start(rig, picks), recipe, {}, "standing").with_picks(picks)
                *_, last = checked_iterates(task)
                if scene.landmark_errors(rig, pose(rig, last.parameters)).mean() < ASTRAY:
                    kind = f"{folder.name} {case.name} {given}"
                    lies, signs = case.stance == "supine", measured_signs(task, last)
                    found.append(ScanSigns(kind, patient["half"], patient["source"], lies, signs))
            file.write_text(json.dumps([asdict(each) for each in found]), "utf-8")
        yield from (ScanSigns(**each) for each in json.loads(file.read_text("utf-8")))


def weights_of(scans: Sequence[ScanSigns]) -> Array:
    """(N,) what each counts: both stances the same, sources nearer to each other than the numbers of their scans."""
    counts = np.ones(len(scans))
    for of in ([s.source for s in scans], [str(s.lies) for s in scans]):
        names = np.array(of)
        for name in {*of}:
            counts[names == name] /= (
                np.sqrt(counts[names == name].sum()) if len({*of}) > 2 else counts[names == name].sum()
            )
    return np.asarray(counts * len(counts) / counts.sum())


def estimated(scans: Sequence[ScanSigns], kept: StanceSigns) -> StanceSigns:
    """Logistic regression with a ridge over the standardised signs, cut off, times the length; Newton's method.

    Signs that scans turned at random do not have are kept as they are.
    """
    names, weights = [name for name, sign in kept.signs.items() if not sign.by_hand], weights_of(scans)
    values = np.array([[s.signs.get(name, np.nan) for name in names] for s in scans])
    lies, known = np.array([s.lies for s in scans]), np.isfinite(values)
    mean = np.nansum(values * weights[:, None], axis=0) / (known * weights[:, None]).sum(axis=0)
    values = np.where(known, values, mean)  # says nothing
    deviation = np.sqrt(np.average((values - mean) ** 2, axis=0, weights=weights))
    rows = np.clip((values - mean) / deviation, -MOST, MOST)
    lengths = np.array([s.signs.get("length", kept.length) for s in scans]) / kept.length
    rows, slopes = lengths[:, None] * np.column_stack([rows, np.ones(len(values))]), np.zeros(len(names) + 1)
    ridge = np.diag([RIDGE] * len(names) + [0.0])
    for _ in range(30):
        odds = 1.0 / (1.0 + np.exp(-rows @ slopes))
        curved = (rows * (weights * odds * (1.0 - odds))[:, None]).T @ rows + ridge
        slopes -= np.linalg.solve(curved, rows.T @ (weights * (odds - lies)) + ridge @ slopes)
    found = {
        name: Sign(between=mean[k], weight=slopes[k] / deviation[k], most=MOST * deviation[k])
        for k, name in enumerate(names)
    }
    return kept.model_copy(update={"constant": slopes[-1], "signs": kept.signs | found})


def table(scans: Sequence[ScanSigns], odds: Array, unsure: float) -> Iterator[str]:
    """A line for each kind."""
    lie: Booleans = np.array([s.lies for s in scans])
    for kind in sorted({s.kind for s in scans}):
        here = np.array([s.kind == kind for s in scans])
        wrong, doubted = (odds > 0.0) != lie, np.abs(odds) <= unsure
        yield (
            f"  {kind:32s} of {here.sum():3d} wrong {(here & wrong & ~doubted).sum():2d}, wrong and unsure "
            f"{(here & wrong & doubted).sum():2d}, right and unsure {(here & ~wrong & doubted).sum():2d}"
        )


def say(lines: Iterable[str]) -> None:
    sys.stdout.writelines(f"{line}\n" for line in lines)


def main(folders: Sequence[Path]) -> None:
    """Measures what is not measured yet, and prints."""
    rig, kept = read_rig(default_rig_path()), stance_signs()
    scans = [each for folder in folders for each in signs_of_scans(folder, rig)]
    choosing = [s for s in scans if s.half == "choose"]
    alone = [s for s in choosing if s.kind.endswith(ALONE)]
    whole = estimated(alone, kept)
    say([f"constant = {whole.constant:.3g}"])
    for name, sign in whole.signs.items():
        say([f"{name}: between {sign.between:.4g}, weight {sign.weight:.4g}, most {sign.most:.3g}"])
    by_others = {
        source: estimated([s for s in alone if s.source != source], kept) for source in {s.source for s in choosing}
    }
    say(["choosing group, each woman by the others"])
    say(table(choosing, np.array([by_others[s.source].log_odds(s.signs) for s in choosing]), kept.unsure))
    for group in GROUPS:
        its = [s for s in scans if s.half == group]
        say([f"the kept numbers, group: {group}"])
        say(table(its, np.array([kept.log_odds(s.signs) for s in its]), kept.unsure))


if __name__ == "__main__":
    main([Path(each) for each in sys.argv[1:]])

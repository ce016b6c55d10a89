"""Finds how much each sign of a stance says where no table is seen (fitting/starts/stance_signs.toml).

    breastrig evaluate --warped 100 COHORT -o DIR --quick
    python -m breastrig_studies.stance_signs DIR/warped COHORT

Of each warped body there are four scans, tables cut away: standing and lying as its source does, standing with the arms
away and lying with the arms along her sides (virtual/warped/arms.py), each whole and its left half.  Printed are the
signs' numbers, from the choosing half, and how many answers are wrong, said to be unsure or not: in the choosing half
each source by the others, in the reporting half by the numbers that are kept.  Fits that went astray, whose stance says
nothing, are left out.
"""

import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.fitting.picks.checked_fit import checked_iterates
from breastrig.fitting.prepare_scan import PreparedScan, prepared
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_scan
from breastrig.fitting.starts.supine_or_standing import Sign, StanceSigns, measured_signs, stance_signs
from breastrig.fitting.task import FitTask
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose
from breastrig.scan.clean import Surface, compact
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.virtual.case_files import UNITS, write_case
from breastrig_studies.virtual.warped.arms import with_arms_along, with_arms_away
from breastrig_studies.virtual.warped.body import draw_body
from breastrig_studies.virtual.warped.captures import scan_captured
from breastrig_studies.virtual.warped.make import HANGS, source_of
from breastrig_studies.virtual.warped.numbers import HANGING, draw_capture
from breastrig_studies.virtual.warped.sources import Source, read_sources

STANCES = ("standing", "supine")
ARMS = 3  # beside the stances and what hangs: the generator of the arms
ASTRAY = 0.04  # m, mean distance of the landmarks
MOST = {"energy_less": 8.0}  # energies of some fits are 60 apart, because other skin was matched
RIDGE = 1.0  # of the weights, in units of bodies
# How much a scan counts.  Arms along the sides are why this is done, but most lie and stand as the sources do; who
# stands with the arms far away is rarest.  0.15 to 1 of the last: 7 to 11 of 50 with the arms along them are wrong.
COUNTS = {"": 3.0, "half": 2.0, "arms": 1.0, "arms half": 0.5}
STANDING_AWAY = 0.5


@dataclass(frozen=True, eq=False)
class ScanSigns:
    """One scan, and what it shows of the stance."""

    kind: str  # of COUNTS
    half: str
    source: str
    lies: bool
    signs: Mapping[str, float]


def write_arms(folder: Path, sources: Sequence[Source]) -> Path:
    """Beside the folder of warped bodies the same ones with other arms, where they are not there yet."""
    into = folder.parent / "arms"
    for file in sorted(folder.glob("*/patient.json")):
        patient = json.loads(file.read_text("utf-8"))
        place, (seed, number) = into / file.parent.name, patient["made_by"]["seed"]
        if (place / "patient.json").is_file():
            continue
        random, own = np.random.default_rng((seed, number)), np.random.default_rng((seed, number, ARMS))
        source = source_of(sources, number, random)
        draw_capture(random)
        share = patient["made_by"].get("hanging", HANGING)
        body = draw_body(source, random, np.random.default_rng((seed, number, HANGS)), share)
        for k, moved in enumerate((with_arms_away(body, own), with_arms_along(body, own))):
            scan = scan_captured(moved, source.faces, source.scanned, patient["capture"], own)
            write_case(place / moved.stance, moved, source.faces, scan, UNITS[k], own, {})
        (place / "patient.json").write_text(json.dumps(patient), "utf-8")
    return into


def scans_without_table(case: Case) -> Iterator[tuple[str, Scene, PreparedScan]]:
    """The case without its table, and its left half."""
    scene = read_scene(case)
    skin = Surface(scene.target.vertices, scene.target.faces, ())
    yield "", scene, prepared(skin, "auto")
    left = scene.landmarks["acromion_L"] - scene.landmarks["acromion_R"]
    kept: Booleans = np.asarray(
        (skin.vertices @ left > scene.landmarks["suprasternal_notch"] @ left)[skin.faces].all(axis=1)
    )
    if kept.mean() > 0.25:  # else it is half a scan already
        yield "half", scene, prepared(Surface(*compact(skin.vertices, skin.faces[kept]), ()), "auto")


def signs_of_scans(folder: Path, arms: str, rig: Rig) -> list[ScanSigns]:
    """All scans of a folder that are placed; kept beside it, so that they are fitted once."""
    file = folder.parent / f"signs_{folder.name}.json"
    if not file.is_file():
        file.write_text(json.dumps([asdict(each) for each in _measured(folder, arms, rig)]), "utf-8")
    return [ScanSigns(**each) for each in json.loads(file.read_text("utf-8"))]


def _measured(folder: Path, arms: str, rig: Rig) -> Iterator[ScanSigns]:
    recipe = load_recipe("default")
    for case in read_cohort(folder):
        patient = json.loads((folder / case.patient / "patient.json").read_text("utf-8"))
        for part, scene, ready in scans_without_table(case):
            start = start_from_scan(rig, ready.target, ready.frame.fronts).parameters
            task = FitTask(rig, ready.target, start, recipe, {})
            standing, supine = ((*checked_iterates(replace(task, stance=each)),)[-1] for each in STANCES)
            if scene.landmark_errors(rig, pose(rig, standing.parameters)).mean() < ASTRAY:
                signs = measured_signs(task, standing, supine)
                yield ScanSigns(
                    f"{arms} {part}".strip(), patient["half"], patient["source"], case.stance == "supine", signs
                )


def weights_of(scans: Sequence[ScanSigns]) -> Array:
    """(N,) what each counts; the sources' shares are nearer to each other than their numbers."""
    counts = np.array([COUNTS[s.kind] * (1.0 if s.lies or "arms" not in s.kind else STANDING_AWAY) for s in scans])
    sources = np.array([s.source for s in scans])
    for source in set(sources):
        counts[sources == source] /= np.sqrt(counts[sources == source].sum())
    return np.asarray(counts * len(counts) / counts.sum())


def estimated(scans: Sequence[ScanSigns], kept: StanceSigns) -> StanceSigns:
    """Logistic regression with a ridge over the standardised signs; Newton's method."""
    names, weights = list(kept.signs), weights_of(scans)
    values = np.array([[s.signs.get(name, np.nan) for name in names] for s in scans])
    bounds = np.array([MOST.get(name, np.inf) for name in names])
    values, lies = np.clip(values, -bounds, bounds), np.array([s.lies for s in scans])
    known = np.isfinite(values)
    mean = np.nansum(values * weights[:, None], axis=0) / (known * weights[:, None]).sum(axis=0)
    values = np.where(known, values, mean)  # says nothing
    deviation = np.sqrt(np.average((values - mean) ** 2, axis=0, weights=weights))
    rows, slopes = np.column_stack([(values - mean) / deviation, np.ones(len(values))]), np.zeros(len(names) + 1)
    ridge = np.diag([RIDGE] * len(names) + [0.0])
    for _ in range(30):
        odds = 1.0 / (1.0 + np.exp(-rows @ slopes))
        curved = (rows * (weights * odds * (1.0 - odds))[:, None]).T @ rows + ridge
        slopes -= np.linalg.solve(curved, rows.T @ (weights * (odds - lies)) + ridge @ slopes)
    arms = names.index("arms")
    mean[arms] -= slopes[-1] * deviation[arms] / slopes[arms]  # the constant, said as an angle
    signs: dict[str, Sign] = {
        name: kept.signs[name].model_copy(update={"between": mean[k], "weight": slopes[k] / deviation[k]})
        for k, name in enumerate(names)
    }
    energy = signs["energy_less"]  # cut off around 0
    mean_energy, signs["energy_less"] = energy.between, energy.model_copy(update={"between": 0.0})
    shift = energy.weight * mean_energy / signs["arms"].weight
    signs["arms"] = signs["arms"].model_copy(update={"between": signs["arms"].between + shift})
    return kept.model_copy(update={"signs": signs})


def answered(scan: ScanSigns, signs: StanceSigns) -> float:
    """The log odds that she lies as fitting/stance.py takes them: where the arms hang she stands, surely or not."""
    if scan.signs["arms"] >= load_recipe("default").stance_rule.arms_hanging:
        return signs.log_odds(scan.signs)
    return min(signs.log_odds({name: value for name, value in scan.signs.items() if name != "energy_less"}), -1e-9)


def table(scans: Sequence[ScanSigns], odds: Array, unsure: float) -> Iterator[str]:
    """A line for each kind and stance."""
    lie: Booleans = np.array([s.lies for s in scans])
    for kind in COUNTS:
        for lies in (False, True):
            here = (lie == lies) & np.array([s.kind == kind for s in scans])
            wrong, doubted = (odds > 0.0) != lie, np.abs(odds) <= unsure
            yield (
                f"  {kind or 'whole':10s} {'lying' if lies else 'standing':8s} of {here.sum():3d} wrong "
                f"{(here & wrong & ~doubted).sum():2d}, wrong and unsure {(here & wrong & doubted).sum():2d}, "
                f"right and unsure {(here & ~wrong & doubted).sum():2d}"
            )


def say(lines: Iterable[str]) -> None:
    sys.stdout.writelines(f"{line}\n" for line in lines)


def main(folder: Path, cohort: Path) -> None:
    """Makes what is missing, and prints."""
    rig, kept = read_rig(default_rig_path()), stance_signs()
    scans = signs_of_scans(folder, "", rig) + signs_of_scans(write_arms(folder, read_sources(cohort)), "arms", rig)
    choosing = [s for s in scans if s.half == "choose"]
    for name, sign in estimated(choosing, kept).signs.items():
        say([f"{name}: between {sign.between:.4g}, weight {sign.weight:.4g}"])
    by_others = {
        source: estimated([s for s in choosing if s.source != source], kept) for source in {s.source for s in choosing}
    }
    say(["choosing half, each source by the others"])
    say(table(choosing, np.array([answered(s, by_others[s.source]) for s in choosing]), kept.unsure))
    for half in ("choose", "report"):
        its = [s for s in scans if s.half == half]
        say([f"the kept numbers, half: {half}"])
        say(table(its, np.array([answered(s, kept) for s in its]), kept.unsure))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))

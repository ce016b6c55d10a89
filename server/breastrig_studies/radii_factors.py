"""Writes the factors from posterior deviations to 90 % radii (fitting/uncertainty), over patients with known skin.

python -m breastrig_studies.radii_factors DIR/warped DIR/poses DIR/prone [--write]

The factor of a kind of place is the quantile of error over deviation, as the fit's strain and the scatter of its picks
enlarge that, which holds nine of ten places, each patient of the development half counting alike (split conformal
prediction with groups: patients).  Landmarks are all picked, exactly or 5 mm off, half of them, three, or none; without
picks a factor is at least the one beside some.  Where that half has too few patients both halves estimate: the second
one's coverage is no check then.  Without --write: the median strain of the development half, the coverage of the file's
factors on both halves, and their width.  Scores of each scan are kept beside its folder, so that it is fitted once.
"""

import json
import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.stances import PRONE, split_side
from breastrig.fitting.posterior import Posterior, expected_places
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.starts.orientation import MIN_LANDMARKS
from breastrig.fitting.task import FitTask, ended
from breastrig.fitting.uncertainty.radii import (
    NO_PICKS,
    OTHER,
    Calibration,
    Scatter,
    calibration,
    factor_of,
    scatter_of,
    seen_vertices,
    shows_part,
)
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import DEVELOPMENT, VALIDATION, Case, read_cohort
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.landmarks import CLICK_ERROR
from breastrig_studies.studies.reference_fit import ReferenceFit, reference_fit

LEVEL = 0.9
SEED = 23
SHOWN = 0.01  # m; a landmark farther from the scan cannot be picked
EACH = 40  # vertices of a region in a fit
MOST = 2  # scans of one patient in a stance
STATES = ("given", "others", "alone", "proposed", "seen", "hidden", "seen_alone", "hidden_alone")
BESIDE = {"alone": "others", "seen_alone": "seen", "hidden_alone": "hidden"}  # the same place where others are picked
FEW = 15  # patients of a half: ten prone ones of two donors gave factors that held 73 to 83 % of the other half's


@dataclass(frozen=True)
class Score:
    """The score of one place in one fit."""

    state: str
    kind: str
    score: float  # error over the posterior's deviation
    deviation: float  # m
    strain: float  # of the fit
    part: bool  # whether the scan shows a part of the body
    scatter: float = NO_PICKS.deviation  # of the picks (radii.py)
    picks: int = NO_PICKS.picks


def trials(scene: Scene) -> Iterator[dict[str, Array]]:
    """The sets of picks: none, all visible ones, the same 5 mm off, each half of them, and three."""
    rng = np.random.default_rng(SEED)
    gaps = {n: float(scene.target.vertex_tree.query(place)[0]) for n, place in scene.landmarks.items()}
    shown = {name: place for name, place in scene.landmarks.items() if gaps[name] < SHOWN}
    clicked = {name: scene.along_the_skin(place, CLICK_ERROR, rng) for name, place in shown.items()}
    halves = [dict(list(shown.items())[first::2]) for first in (0, 1)]
    three = dict([*shown.items()][k] for k in rng.permutation(len(shown))[:MIN_LANDMARKS])
    yield {}
    yield from (each for each in (shown, clicked, *halves, three) if len(each) >= MIN_LANDMARKS)


def fitted(scene: Scene, rig: Rig, recipe: Recipe, picks: dict[str, Array], start: RigParameters) -> Posterior | None:
    """The posterior of the fit with these picks; None where it fails."""
    task = FitTask(rig, scene.target, start, recipe, {}, scene.case.stance).with_picks(picks)
    *_, last = checked_iterates(task)
    return Posterior(ended(task, last), last.parameters) if last.is_finite else None


def scores_of(posterior: Posterior, scene: Scene, true: ReferenceFit | None) -> Iterator[Score]:
    """The scores of all known places of a fit: landmarks, and EACH vertices of each region."""
    rig, state, picked = posterior.task.rig, posterior.state, posterior.task.picked
    names, rng, seen = tuple(scene.landmarks), np.random.default_rng(SEED), seen_vertices(posterior)
    fit = posterior.strain, shows_part(seen), *scatter_of(posterior)

    def score(kind: str, name: str, error: float, deviation: float) -> Score:
        return Score(kind, split_side(name)[0], error / deviation, deviation, *fit)

    deviations = np.sqrt(posterior.landmark_variances(names))
    model = dict(zip(rig.landmark_names, rig.landmark_points().positions(state.vertices, rig.faces), strict=True))
    expected = dict(zip(rig.landmark_names, expected_places(posterior, {}), strict=True))
    for way, places in [("others", model)] if picked else [("alone", model), ("proposed", expected)]:
        for name, deviation in zip(names, deviations.tolist(), strict=True):
            error = float(np.linalg.norm(places[name] - scene.landmarks[name]))
            yield score("given" if name in picked else way, name, error, deviation)
    if true is None or scene.case.stance == PRONE:  # an MRI shows too little skin to say what lies where along it
        return
    deviations = np.sqrt(posterior.vertex_variances())
    errors = np.linalg.norm(state.vertices - true.vertices, axis=1)
    for name, vertices in _regions(rig):
        for is_seen, way in ((True, "seen"), (False, "hidden")):
            part = vertices[seen[vertices] == is_seen]
            for v in rng.choice(part, min(EACH, len(part)), replace=False):
                yield score(way if picked else f"{way}_alone", name, float(errors[v]), float(deviations[v]))


def _regions(rig: Rig) -> Iterator[tuple[str, Integers]]:
    """The rig's regions, and what lies in none."""
    yield from rig.regions.items()
    left = np.setdiff1d(np.arange(len(rig.template)), np.concatenate([np.zeros(0, int), *rig.regions.values()]))
    if len(left):
        yield OTHER, left


def quantile(scores: Sequence[float], women: Sequence[str]) -> float:
    """The score that holds LEVEL of a new patient's places; known patients count alike, and one more as the worst."""
    values, names = np.array(scores), np.array(women)
    weights = np.zeros(len(values))
    for name in {*women}:
        weights[names == name] = 1.0 / np.count_nonzero(names == name)
    order = np.argsort(values)
    share = np.cumsum(weights[order]) / (len({*women}) + 1.0)
    return float(values[order][min(int(np.searchsorted(share, LEVEL)), len(values) - 1)])


Known = list[tuple[str, str, Score]]  # patient, stance


def larger_for(each: Score, known: Calibration) -> float:
    """The factor for the fit's strain and the picks' scatter; that one at least 1 for hidden skin, which none shows."""
    times = known.enlarged(Scatter(each.scatter, each.picks), given=each.state == "given")
    return known.strained(each.strain, part=each.part) * (max(times, 1.0) if each.state == "hidden" else times)


def factors(found: Known, known: Calibration) -> dict[str, dict[str, dict[str, float]]]:
    """Factors by stance, state and kind; `known` tells the enlargement of radii for a scatter of picks."""
    result: dict[str, dict[str, dict[str, float]]] = {}
    for stance in sorted({each[1] for each in found}):
        groups: dict[tuple[str, str], list[tuple[float, str]]] = defaultdict(list)
        for woman, its, each in found:
            if its == stance:
                groups[each.state, each.kind].append((each.score / larger_for(each, known), woman))
        of_stance: dict[str, dict[str, float]] = {state: {} for state in STATES}
        estimates = {key: quantile(*zip(*scores, strict=True)) for key, scores in groups.items()}
        for state, kind in sorted(groups):
            factor = max(estimates[state, kind], estimates.get((BESIDE.get(state, ""), kind), 0.0))
            of_stance[state][kind] = round(factor, 2)
        for group in of_stance.values():
            if group:
                group[OTHER] = max(group.values(), default=1.0)  # of what has no factor of its own
        for state, beside in BESIDE.items():
            if of_stance[state] and of_stance[beside]:
                of_stance[state][OTHER] = max(of_stance[state][OTHER], of_stance[beside][OTHER])
        result[stance] = {state: group for state, group in of_stance.items() if group}
    return result


def scores_of_scan(case: Case, rig: Rig, recipe: Recipe) -> Iterator[Score]:
    """The scores of all trials."""
    scene = read_scene(case)
    true, alone = reference_fit(scene, rig, recipe), scene.place(rig).parameters
    for picks in trials(scene):
        posterior = fitted(scene, rig, recipe, picks, scene.start(rig, picks) if picks else alone)
        if posterior is not None:
            yield from scores_of(posterior, scene, true)


def read_scores(folder: Path, rig: Rig, recipe: Recipe) -> Iterator[tuple[Case, str, list[Score]]]:
    """(case, half, scores) of all patients but the test set."""
    kept, times = folder.parent / f"radii_{folder.name}", defaultdict[tuple[str, str], int](int)
    kept.mkdir(exist_ok=True)
    for case in read_cohort(folder):
        number = int("".join(filter(str.isdigit, case.patient)) or 0)
        half = case.group or (DEVELOPMENT, VALIDATION)[number % 2]
        times[case.patient, case.stance] += 1
        if case.held_out or times[case.patient, case.stance] > MOST:
            continue
        file = kept / f"{case.patient}_{case.name}.json"
        if not file.is_file():
            file.write_text(json.dumps([asdict(each) for each in scores_of_scan(case, rig, recipe)]), "utf-8")
        yield case, half, [Score(**each) for each in json.loads(file.read_text("utf-8"))]


def write_factors(folder: Path, found: dict[str, dict[str, dict[str, float]]]) -> None:
    """radii.json of a rig's folder."""
    document = {"schema": "breastrig/radii@1", "stances": found}
    (folder / "radii.json").write_text(json.dumps(document, indent=1) + "\n", "utf-8")


def table(found: Known, known: Calibration) -> Iterator[str]:
    """A line for each stance and state: the share held over all patients, that of the worst patient, and the width."""
    for stance in sorted({each[1] for each in found}):
        its = known.of_stance(stance)
        for state in STATES:
            held, wide = defaultdict[str, list[bool]](list), []
            for woman, at, each in found:
                if (at, each.state) == (stance, state):
                    times = factor_of(getattr(its, state), each.kind) * larger_for(each, known)
                    held[woman].append(each.score <= times)
                    wide.append(times * each.deviation)
            shares = [float(np.mean(each)) for each in held.values()]
            if shares:
                width = f"{1e3 * float(np.median(wide)):7.1f} mm"
                yield f"{stance:9s}{state:13s}{np.mean(shares):7.1%}{min(shares):7.1%}{width}"


def enough(halves: dict[str, Known]) -> Known:
    """The development half; of stances of which it has too few patients, both halves."""
    patients = defaultdict[str, set[str]](set)
    for patient, stance, _ in halves[DEVELOPMENT]:
        patients[stance].add(patient)
    return halves[DEVELOPMENT] + [each for each in halves[VALIDATION] if len(patients[each[1]]) < FEW]


def main(folders: Sequence[str], write: bool) -> None:
    """Prints the table of both halves, and writes the file's stances when asked to."""
    rig, recipe = read_rig(default_rig_path()), load_recipe("default")
    known = calibration(rig)
    assert known is not None
    halves: dict[str, Known] = {DEVELOPMENT: [], VALIDATION: []}
    for folder in map(Path, folders):
        for case, half, scores in read_scores(folder, rig, recipe):
            halves[half] += [(f"{folder.name} {case.patient}", case.stance, each) for each in scores]
    if write:
        estimates = factors(enough(halves), known)
        write_factors(default_rig_path().with_suffix(".known"), estimates)
        known = Calibration.model_validate(known.model_dump() | {"stances": estimates})
    usual = np.median([each.strain for _, _, each in halves[DEVELOPMENT]])
    sys.stdout.write(f"usual_strain = {usual:.4f}\n")
    for half, found in halves.items():
        sys.stdout.write(f"{half}\n" + "\n".join(table(found, known)) + "\n")


if __name__ == "__main__":
    given = arguments(__doc__, "FOLDER...", "--write")
    main(given.folder, given.write)

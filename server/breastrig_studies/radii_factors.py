"""Writes by how much radii exceed a posterior's deviations (fitting/uncertainty), over women whose skin is known.

    python -m breastrig_studies.radii_factors DIR/warped DIR/poses DIR/prone [--write]

The misfit of a kind of place is the likeliest of a Student t over all fits together, whether all, half, three or none
of the landmarks are picked. Its factor is the quantile of error over deviation and misfit that holds nine of ten of
them, each woman of the choosing half counting alike (split conformal prediction with groups: women), of fits with
picks or of those without, whichever is larger. Where that half has too few women to speak for others, both halves
estimate: what the table then says of the second is no check. Picks are exact and 5 mm off. Without --write: what the
file's factors hold of the reporting half, and how wide they are. Scores of a scan are kept beside its folder, so that
it is fitted once.
"""

import json
import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.stances import PRONE, split_side
from breastrig.fitting.body.hanging import hangs_by
from breastrig.fitting.picks.checked_fit import checked_iterates, ended
from breastrig.fitting.picks.leave_one_out import FREEDOM
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.propose import expected_places
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.starts.orientation import MIN_LANDMARKS
from breastrig.fitting.task import FitTask
from breastrig.fitting.uncertainty.calibration import (
    NO_PICKS,
    SCHEMA,
    Calibration,
    Scatter,
    calibration,
    factor_of,
)
from breastrig.fitting.uncertainty.radii import OTHER, scatter_of, seen_vertices
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig_studies.cohort import CHOOSE, REPORT, Case, read_cohort
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.landmarks import CLICK_ERROR
from breastrig_studies.studies.reference_fit import ReferenceFit, reference_fit

LEVEL = 0.9
SEED = 23
SHOWN = 0.01  # m; a landmark farther from the scan cannot be picked
EACH = 40  # vertices of a region in a fit
MOST = 2  # scans of one woman in a stance
STATES = ("given", "others", "alone", "proposed", "seen", "hidden", "seen_alone", "hidden_alone")
STATE_OF = {"alone": "others", "seen_alone": "seen", "hidden_alone": "hidden"}  # that its numbers stand under
MISFIT_OF = {"others": "others", "proposed": "others", "seen": "seen", "hidden": "hidden"}  # likewise; given has none
MISFITS_MM = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0)
STRETCHES = np.geomspace(0.1, 10.0, 60)  # of deviation and misfit, beside which misfits are compared
HANGS_WITH = ("nipple", "inframammary_fold", "xiphoid", "mid_sternum", "breast", "areola", "chest", "belly")
FEW = 15  # women of a half: ten prone ones of two donors gave factors that held 73 to 83 % of the other half's
WOMEN = 3  # fewer whose breasts hang say nothing of others


@dataclass(frozen=True)
class Score:
    """Of one place in one fit."""

    state: str
    kind: str
    score: float  # error over the posterior's deviation
    hangs: bool
    deviation: float  # m
    scatter: float = NO_PICKS.deviation  # of the picks (radii.py)
    picks: int = NO_PICKS.picks

    @property
    def error(self) -> float:
        """m"""
        return self.score * self.deviation


def trials(scene: Scene) -> Iterator[dict[str, Array]]:
    """What is picked: nothing, what can be seen, the same 5 mm off, each half of it, and three places."""
    rng = np.random.default_rng(SEED)
    gaps = {n: float(scene.target.vertex_tree.query(place)[0]) for n, place in scene.landmarks.items()}
    shown = {name: place for name, place in scene.landmarks.items() if gaps[name] < SHOWN}
    clicked = {name: scene.along_the_skin(place, CLICK_ERROR, rng) for name, place in shown.items()}
    halves = [dict(list(shown.items())[first::2]) for first in (0, 1)]
    three = [dict([*shown.items()][k] for k in rng.permutation(len(shown))[:MIN_LANDMARKS])]
    yield {}
    yield from (each for each in (shown, clicked, *halves, *three) if len(each) >= MIN_LANDMARKS)


def fitted(scene: Scene, rig: Rig, recipe: Recipe, picks: dict[str, Array], start: RigParameters) -> Posterior | None:
    """Where the fit with these picks ends; None where it breaks down."""
    task = FitTask(rig, scene.target, start, recipe, {}, scene.case.stance).with_picks(picks)
    *_, last = checked_iterates(task)
    return Posterior(ended(task, last), last.parameters) if last.is_finite else None


def scores_of(posterior: Posterior, scene: Scene, true: ReferenceFit | None) -> Iterator[Score]:
    """Of all places of a fit that are known: landmarks, and of each region EACH vertices."""
    rig, state, picked = posterior.task.rig, posterior.state, posterior.task.picked
    names, rng, scatter = tuple(scene.landmarks), np.random.default_rng(SEED), scatter_of(posterior)

    def score(kind: str, name: str, error: float, deviation: float) -> Score:
        hangs = hangs_by(state, posterior.task.recipe, name) > 0.0
        return Score(kind, split_side(name)[0], error / deviation, hangs, deviation, *scatter)

    deviations = np.sqrt(posterior.landmark_variances(names))
    model = dict(zip(rig.landmark_names, rig.landmark_points().positions(state.vertices, rig.faces), strict=True))
    expected = dict(zip(rig.landmark_names, expected_places(posterior, {}), strict=True))
    for way, places in [("others", model)] if picked else [("alone", model), ("proposed", expected)]:
        for name, deviation in zip(names, deviations.tolist(), strict=True):
            error = float(np.linalg.norm(places[name] - scene.landmarks[name]))
            yield score("given" if name in picked else way, name, error, deviation)
    if true is None or scene.case.stance == PRONE:  # an MRI shows too little skin to say what lies where along it
        return
    seen, deviations = seen_vertices(posterior), np.sqrt(posterior.vertex_variances())
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
    """The score that holds LEVEL of a new woman's places; those known count alike, and one more as the worst."""
    values, names = np.array(scores), np.array(women)
    weights = np.zeros(len(values))
    for name in {*women}:
        weights[names == name] = 1.0 / np.count_nonzero(names == name)
    order = np.argsort(values)
    share = np.cumsum(weights[order]) / (len({*women}) + 1.0)
    return float(values[order][min(int(np.searchsorted(share, LEVEL)), len(values) - 1)])


Known = list[tuple[str, str, Score]]  # woman, stance


def deviation_of(each: Score, known: Calibration) -> float:
    """m, with what the picks' scatter makes of it: careful picks say nothing of skin that is not seen."""
    times = known.enlarged(Scatter(each.scatter, each.picks), given=each.state == "given")
    return each.deviation * (max(times, 1.0) if each.state.startswith("hidden") else times)


def likely_misfit(errors: Array, deviations: Array, women: Sequence[str]) -> float:
    """mm: the likeliest of MISFITS_MM, at its likeliest stretch, of (N,) m errors on the skin, women counting alike."""
    names, each = np.unique(np.array(women), return_inverse=True)
    weights = 1.0 / np.bincount(each, minlength=len(names))[each]
    nats = []
    for misfit in MISFITS_MM:
        spread = STRETCHES[:, None] ** 2 * (deviations**2 + (1e-3 * misfit) ** 2)
        density = -np.log(spread) - 0.5 * (FREEDOM + 2.0) * np.log1p(errors**2 / (FREEDOM * spread))
        nats.append(float((density @ weights).max()))
    return MISFITS_MM[int(np.argmax(nats))]


@dataclass(frozen=True, eq=False)
class _Places:
    """All that is known of a kind of place in a stance, with picks or without."""

    errors: Array  # (N,) m
    deviations: Array  # (N,) m
    women: tuple[str, ...]
    hangs: Array  # (N,) whether a breast hangs
    states: Array  # (N,) of STATES

    def over(self, misfit: float) -> Array:
        """(N,) errors over deviation and misfit (m)."""
        return np.asarray(self.errors / np.hypot(self.deviations, misfit))

    def factor(self, misfit: float) -> float:
        """That holds LEVEL of fits with picks and of those without."""
        scores, women = self.over(misfit), np.array(self.women)
        parts = [self.states == state for state in {*self.states.tolist()}]
        return max(quantile(scores[part].tolist(), women[part].tolist()) for part in parts)


def _places(found: Known, known: Calibration) -> dict[tuple[str, str], _Places]:
    """By state that numbers stand under, and kind."""
    groups: dict[tuple[str, str], list[tuple[str, Score]]] = defaultdict(list)
    for woman, _, each in found:
        groups[STATE_OF.get(each.state, each.state), each.kind].append((woman, each))
    return {
        key: _Places(
            np.array([each.error for _, each in group]),
            np.array([deviation_of(each, known) for _, each in group]),
            tuple(woman for woman, _ in group),
            np.array([each.hangs for _, each in group]),
            np.array([each.state for _, each in group]),
        )
        for key, group in sorted(groups.items())
    }


def factors(found: Known, known: Calibration) -> dict[str, dict[str, Any]]:
    """By stance: factors by state and kind, and misfits; `known` says what a scatter of picks makes of deviations."""
    stances = sorted({each[1] for each in found})
    return {stance: _of_stance(_places([each for each in found if each[1] == stance], known)) for stance in stances}


def _of_stance(places: dict[tuple[str, str], _Places]) -> dict[str, Any]:
    result: dict[str, Any] = {state: {} for state in STATES if state not in STATE_OF}
    misfits: dict[str, dict[str, float]] = {state: {} for state in {*MISFIT_OF.values()}}
    for (state, kind), each in places.items():
        if state in misfits:
            misfits[state][kind] = likely_misfit(each.errors, each.deviations, each.women)
    more: dict[str, list[tuple[float, str]]] = defaultdict(list)
    widest: dict[str, tuple[float, str]] = {}
    for (state, kind), each in places.items():
        misfit = 1e-3 * misfits.get(MISFIT_OF.get(state, ""), {}).get(kind, 0.0)
        factor = each.factor(misfit)
        result[state][kind] = round(factor, 2)
        radius = float(np.median(factor * np.hypot(each.deviations, misfit)))
        widest[state] = max(widest.get(state, (0.0, "")), (radius, kind))
        beyond = each.over(misfit) / factor
        more[kind] += [(float(beyond[k]), each.women[k]) for k in np.flatnonzero(each.hangs)]
    for state, (_, kind) in widest.items():  # of what has no numbers of its own
        result[state][OTHER] = result[state][kind]
        if state in misfits:
            misfits[state][OTHER] = misfits[state][kind]
    result["hanging"] = {
        kind: round(larger, 2)
        for kind in HANGS_WITH
        if len({w for _, w in more[kind]}) >= WOMEN
        and (larger := quantile([s for s, _ in more[kind]], [w for _, w in more[kind]])) > 1.0
    }
    result["misfit_mm"] = {state: dict(sorted(group.items())) for state, group in sorted(misfits.items()) if group}
    return {state: group for state, group in result.items() if group}


def scores_of_scan(case: Case, rig: Rig, recipe: Recipe) -> Iterator[Score]:
    """Of all trials."""
    scene = read_scene(case)
    true, alone = reference_fit(scene, rig, recipe), scene.place(rig).parameters
    for picks in trials(scene):
        posterior = fitted(scene, rig, recipe, picks, scene.start(rig, picks) if picks else alone)
        if posterior is not None:
            yield from scores_of(posterior, scene, true)


def read_scores(folder: Path, rig: Rig, recipe: Recipe) -> Iterator[tuple[Case, str, list[Score]]]:
    """(case, half, scores) of all women who are not sealed."""
    kept, times = folder.parent / f"radii_{folder.name}", defaultdict[tuple[str, str], int](int)
    kept.mkdir(exist_ok=True)
    for case in read_cohort(folder):
        number = int("".join(filter(str.isdigit, case.patient)) or 0)
        half = case.group or (CHOOSE, REPORT)[number % 2]
        times[case.patient, case.stance] += 1
        if case.sealed or times[case.patient, case.stance] > MOST:
            continue
        file = kept / f"{case.patient}_{case.name}.json"
        if not file.is_file():
            file.write_text(json.dumps([asdict(each) for each in scores_of_scan(case, rig, recipe)]), "utf-8")
        yield case, half, [Score(**each) for each in json.loads(file.read_text("utf-8"))]


def write_factors(folder: Path, found: dict[str, dict[str, Any]]) -> None:
    """radii.json of a rig's folder."""
    document = {"schema": SCHEMA, "stances": found}
    (folder / "radii.json").write_text(json.dumps(document, indent=1) + "\n", "utf-8")


def table(found: Known, known: Calibration) -> Iterator[str]:
    """A line for each stance and state: the share held of all women, of the woman of whom least, and how wide."""
    for stance in sorted({each[1] for each in found}):
        its = known.of_stance(stance)
        for state in STATES:
            held, wide = defaultdict[str, list[bool]](list), []
            for woman, at, each in found:
                if (at, each.state) == (stance, state):
                    under = STATE_OF.get(state, state)
                    times = factor_of(getattr(its, under), each.kind)
                    times *= its.hanging.get(each.kind, 1.0) if each.hangs else 1.0
                    misfit = its.misfit(MISFIT_OF[under], each.kind) if under in MISFIT_OF else 0.0
                    radius = times * float(np.hypot(deviation_of(each, known), misfit))
                    held[woman].append(each.error <= radius)
                    wide.append(radius)
            shares = [float(np.mean(each)) for each in held.values()]
            if shares:
                width = f"{1e3 * float(np.median(wide)):7.1f} mm"
                yield f"{stance:9s}{state:13s}{np.mean(shares):7.1%}{min(shares):7.1%}{width}"


def enough(halves: dict[str, Known]) -> Known:
    """The choosing half, and of stances of which it has too few women the other one as well."""
    women = {stance: {woman for woman, at, _ in halves[CHOOSE] if at == stance} for _, stance, _ in halves[CHOOSE]}
    few = {stance for stance, names in women.items() if len(names) < FEW}
    return halves[CHOOSE] + [each for each in halves[REPORT] if each[1] in few]


def main(folders: Sequence[str], write: bool) -> None:
    """Prints the table of both halves, and writes the file's stances when asked to."""
    rig, recipe = read_rig(default_rig_path()), load_recipe("default")
    known = calibration(rig)
    assert known is not None
    halves: dict[str, Known] = {CHOOSE: [], REPORT: []}
    for folder in map(Path, folders):
        for case, half, scores in read_scores(folder, rig, recipe):
            halves[half] += [(f"{folder.name} {case.patient}", case.stance, each) for each in scores]
    if write:
        estimates = factors(enough(halves), known)
        write_factors(default_rig_path().with_suffix(".known"), estimates)
        known = Calibration.model_validate(known.model_dump() | {"stances": estimates})
    for half, found in halves.items():
        sys.stdout.write(f"{half}\n" + "\n".join(table(found, known)) + "\n")


if __name__ == "__main__":
    main([each for each in sys.argv[1:] if each != "--write"], "--write" in sys.argv)

"""`breastrig model learn MODEL BODIES`: what is known of a rig, from bodies whose whole skin is known.

BODIES is a cohort (cohort.py) with truth.ply of every body.  Written into NAME.known and bound to the rig: bodies.json,
uncertainty.toml and verdict.toml.  Bodies of the groups `report` and `sealed` are left for whoever measures what came
of it (`breastrig evaluate BODIES --model MODEL`).  The rules: docs/decisions/0024.
"""

import json
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadInput
from breastrig.core.stances import split_side
from breastrig.correspondence.distances import Comparison
from breastrig.fitting.picks.checked_fit import checked_iterates, ended
from breastrig.fitting.picks.leave_one_out import LeaveOneOut
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.starts.orientation import MIN_LANDMARKS
from breastrig.fitting.task import FitTask
from breastrig.fitting.uncertainty.radii import FEW, HOLDS_90, OUTLYING, seen_vertices
from breastrig.fitting.verdicts.fit_signals import FitSignals, fit_signals
from breastrig.fitting.verdicts.verdict import VerdictLimits, verdict_limits
from breastrig.gltf.known_files import bind_known
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.stance_priors import in_stance
from breastrig_studies.body_statistics import statistics
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.landmarks import CLICK_ERROR
from breastrig_studies.studies.reference_fit import ReferenceFit, reference_fit

KEPT = ("report", "sealed")  # groups of patient.json from which nothing is estimated
HELD = 0.9  # of the true places
FEWEST = 6  # bodies
SHOWN = 0.01  # m; a landmark farther from the scan cannot be picked
STRETCH = {True: 1.0, False: 2.0}  # of the posterior's deviations with and without picks, as the torso's
SCATTER = (0.5, 3.0)  # least and most, as the torso's
CHECK, NO_TORSO = (
    1.5,
    4.0,
)  # times the way from the median to the worst right fit: the torso's own limits are near these
RIGHT = 0.04  # of the rig's length: a fit whose landmarks are farther off on the mean is wrong, 20 mm of a torso
OTHER, PICKED, HIDDEN, ALONE = "other", "shown", "hidden", "without_picks"


@dataclass(eq=False)
class Found:
    """What all fits say."""

    needed: dict[tuple[str, str, str, str], list[Array]] = field(default_factory=lambda: defaultdict(list))
    signals: list[FitSignals] = field(default_factory=list)
    margins: dict[bool, list[float]] = field(default_factory=lambda: {True: [], False: []})  # of right and wrong fits

    def misfit(self, part: str, name: str, how: str) -> float:
        """m, root mean square distance that makes the radii hold HELD of these places, whatever the picks are.

        Of those of OTHER names where there are none, and at last of those that are known another way.
        """
        for named, known in ((name, how), (None, how), (None, None)):
            kinds: dict[str, list[Array]] = defaultdict(list)
            for (p, n, h, kind), values in self.needed.items():
                if p == part and named in (None, n) and known in (None, h):
                    kinds[kind] += values
            squares = [each for each in map(np.concatenate, kinds.values()) if len(each)]
            if squares:
                most = max(float(np.quantile(each, HELD)) for each in squares)
                return round(float(np.sqrt(max(most, 0.0))), 4)
        return 0.0


@dataclass(frozen=True, eq=False)
class Trial:
    """One fit of a scene: how far off (m) and how well known (m²) its places are."""

    kind: str  # of picks
    picks: frozenset[str]
    landmarks: dict[str, tuple[float, float]]
    vertices: tuple[Array, Array]  # (V,) each
    seen: Booleans  # (V,)
    scatter: float  # of the picks; nan where they are too few
    signals: FitSignals
    margin: float | None  # of the start, without picks


def learn(glb: Path, bodies: Path) -> Path:
    """Writes what is known of the rig; the folder.  Raises BadInput without bodies to learn from."""
    cases = [case for case in read_cohort(bodies) if _half(case) not in KEPT]
    if len({case.patient for case in cases}) < FEWEST:
        raise BadInput(f"{bodies} has fewer than {FEWEST} bodies to learn from; more are needed to say what 90 % are.")
    rig, recipe, folder = read_rig(glb), load_recipe("default"), glb.with_suffix(".known")
    truths = {case: reference_fit(read_scene(case), rig, recipe) for case in cases}
    known = [(case.stance, truth.parameters) for case, truth in truths.items() if truth is not None]
    if len(known) < len(cases):
        raise BadInput(f"{bodies} has scans without truth.ply; what is not known cannot be estimated on.")
    folder.mkdir(exist_ok=True)
    (folder / "bodies.json").write_text(json.dumps(statistics(rig, known), indent=1) + "\n", "utf-8")
    bind_known(glb, rig.sha256)
    rig = read_rig(glb)  # with these bodies
    trials = [trial for case, true in truths.items() for trial in _trials(read_scene(case), rig, recipe, true)]
    scatters = np.array([trial.scatter for trial in trials])
    usual = round(float(np.nanmedian(scatters)), 2) if np.isfinite(scatters).any() else 1.0
    found = Found()
    for trial in trials:
        add(found, rig, trial, usual)
    return write(glb, rig, found, usual, {case.stance for case in cases}, len(known))


def write(glb: Path, rig: Rig, found: Found, usual: float, stances: set[str], scans: int) -> Path:
    """Radii and verdict into the rig's folder."""
    folder = glb.with_suffix(".known")
    folder.mkdir(exist_ok=True)
    (folder / "uncertainty.toml").write_text(_toml(_uncertainty(rig, found, usual), scans), "utf-8")
    (folder / "verdict.toml").write_text(_toml(_verdict(found, stances), scans), "utf-8")
    return bind_known(glb, rig.sha256).parent


def _half(case: Case) -> str:
    file = case.folder.parent / "patient.json"
    return str(json.loads(file.read_text("utf-8")).get("half", "")) if file.is_file() else ""


def _trials(scene: Scene, rig: Rig, recipe: Recipe, true: ReferenceFit | None) -> Iterator[Trial]:
    """With true picks, with picks 5 mm off, with every other one, and without."""
    assert true is not None
    rng = np.random.default_rng(0)
    gaps = np.atleast_1d(scene.target.vertex_tree.query(np.array(list(scene.landmarks.values())))[0])
    shown = {n: at for (n, at), gap in zip(scene.landmarks.items(), gaps, strict=True) if gap < SHOWN}
    clicked = {name: scene.along_the_skin(at, CLICK_ERROR, rng) for name, at in shown.items()}
    halves = [dict(list(shown.items())[first::2]) for first in (0, 1)]
    kinds = [("none", {}), ("exact", shown), ("clicked", clicked), *(("half", each) for each in halves)]
    for kind, picks in kinds:
        if kind != "none" and len(picks) < MIN_LANDMARKS:
            continue
        start = scene.place(rig) if not picks else None
        first = start.parameters if start is not None else scene.start(rig, picks)
        task = FitTask(rig, scene.target, first, recipe, picks, scene.case.stance)
        *_, last = checked_iterates(task)
        posterior = Posterior(ended(task, last), last.parameters)
        margin = None if start is None else start.margin
        compared = Comparison(scene.target, posterior.state.vertices, rig.faces)
        signals = fit_signals(in_stance(rig, task.stance), last.parameters, compared, margin)
        names = tuple(scene.landmarks)
        off = scene.landmark_errors(rig, posterior.state.vertices, names).tolist()
        yield Trial(
            kind,
            frozenset(picks),
            dict(zip(names, zip(off, posterior.landmark_variances(names).tolist(), strict=True), strict=True)),
            (np.linalg.norm(posterior.state.vertices - true.vertices, axis=1), posterior.vertex_variances()),
            seen_vertices(posterior),
            _scatter(posterior),
            signals,
            margin,
        )


def _scatter(posterior: Posterior) -> float:
    """As fitting/uncertainty/radii.py has it, before it is compared with what is usual."""
    if posterior.picks is None or len(posterior.task.landmarks) < FEW:
        return float("nan")
    deviations = np.array(list(LeaveOneOut(posterior).deviations().values()))
    return float(np.sqrt(np.mean(np.minimum(deviations, OUTLYING) ** 2) / 3.0))


def add(found: Found, rig: Rig, trial: Trial, usual: float) -> None:
    """Of each place the square of the misfit (m²) that would make its radius as large as its error.

    Wrong fits are for the verdict to see; of them only how clear their starts were is kept.
    """
    right = float(np.mean([error for error, _ in trial.landmarks.values()])) < RIGHT * _length(rig)
    if trial.margin is not None:
        found.margins[right].append(trial.margin)
    if not right:
        return
    scatter = float(np.clip((trial.scatter / usual) ** 2, *SCATTER)) if np.isfinite(trial.scatter) else 1.0
    stretch = STRETCH[bool(trial.picks)] ** 2
    for name, (error, variance) in trial.landmarks.items():
        how = ALONE if not trial.picks else PICKED if name in trial.picks else HIDDEN
        place = (error / (HOLDS_90 * scatter)) ** 2 - stretch * variance
        found.needed["landmarks", split_side(name)[0], how, trial.kind].append(np.array([place]))
    errors, variances = trial.vertices
    for how, part in ((PICKED, trial.seen), (HIDDEN, ~trial.seen)) if trial.picks else ():
        larger = scatter if how == PICKED else max(scatter, 1.0)
        need = (errors / (HOLDS_90 * larger)) ** 2 - stretch * variances
        for name, members in _regions(rig).items():
            found.needed["regions", name, how, trial.kind].append(need[members[part[members]]])
    found.signals.append(trial.signals)


def _length(rig: Rig) -> float:
    """m"""
    return float(np.ptp(rig.template, axis=0).max())


def _regions(rig: Rig) -> dict[str, Integers]:
    """Vertices by name without its side; those outside of all regions are OTHER."""
    regions: dict[str, Integers] = {OTHER: np.arange(len(rig.template), dtype=np.int64)}
    for name, members in rig.regions.items():
        stem = split_side(name)[0]
        regions[stem] = np.union1d(regions.get(stem, members), members)
        regions[OTHER] = np.setdiff1d(regions[OTHER], members)
    return regions


def _uncertainty(rig: Rig, found: Found, usual: float) -> dict[str, Any]:
    """The document of fitting/uncertainty/calibration.py."""
    landmarks = [*sorted({split_side(name)[0] for name in rig.landmark_names}), OTHER]
    right, wrong = found.margins[True], found.margins[False]
    clear = max(0.7 * min(right, default=0.0), 1.3 * max(wrong, default=0.0), 0.01)  # all of these lay right
    misfits = {
        part: {name: {how: found.misfit(part, name, how) for how in (PICKED, HIDDEN)} for name in names}
        for part, names in (("landmarks", landmarks), ("regions", list(_regions(rig))))
    }
    alone = {name: found.misfit("landmarks", name, ALONE) for name in landmarks}
    return {
        "stretch": STRETCH[True],
        "usual_scatter": usual,
        "least_scatter": SCATTER[0],
        "least_scatter_hidden": 1.0,
        "most_scatter": SCATTER[1],
        **misfits,
        "hanging": {},
        "hanging_regions": {},
        "without_picks": {
            "stretch": STRETCH[False],
            "clear": round(clear, 3),
            "unclear": round(clear / 4.0, 3),
            "astray": round(0.5 * _length(rig), 3),
            "landmarks": alone,
        },
    }


def _verdict(found: Found, stances: set[str]) -> dict[str, Any]:
    """The document of fitting/verdicts/verdict.py: the torso's signals and words with limits of these fits."""
    torso = verdict_limits(read_rig(default_rig_path()))
    assert torso is not None
    signals = {}
    for name, limit in torso.signals.items():
        values = np.array([getattr(each, name) for each in found.signals])
        values = values[np.isfinite(values)]
        if len(values):
            middle, worst = float(np.median(values)), float(values.max() if limit.above else values.min())
            check, no_torso = (middle + times * (worst - middle) for times in (CHECK, NO_TORSO))
            if check == no_torso:
                continue  # all fits are alike: it says nothing
            least = {
                "check": max(check, 0.0),
                "no_torso": 0.0 if limit.scan_alone else max(no_torso, 0.0),
            }  # a part is one
            rounded = {key: float(f"{value:.3g}") for key, value in least.items()}
            if rounded["check"] != rounded["no_torso"]:
                signals[name] = limit.model_copy(update=rounded | {"hanging": None})
    limits: VerdictLimits = torso.model_copy(
        update={"stances": tuple(sorted(stances)), "size": None, "signals": signals, "of_stance": {}}
    )
    return limits.model_dump(exclude_none=True)


def _toml(document: dict[str, Any], bodies: int) -> str:
    """Words and numbers of JSON are those of TOML, too."""
    lines = [f"# By `breastrig model learn`, estimated on fits to {bodies} scans of bodies whose whole skin is known."]

    def write(table: dict[str, Any], place: Sequence[str]) -> None:
        if place:
            lines.extend(("", f"[{'.'.join(place)}]"))
        plain = {key: value for key, value in table.items() if not isinstance(value, dict)}
        lines.extend(f"{key} = {json.dumps(value)}" for key, value in plain.items())
        for key in [key for key in table if key not in plain]:
            write(table[key], [*place, key])

    write(document, ())
    return "\n".join(lines) + "\n"

"""`breastrig model learn MODEL BODIES`: what is known of a rig, from bodies whose whole skin is known.

BODIES is a cohort (cohort.py) with truth.ply of every body.  Written into NAME.known and bound to the rig:
bodies.json, landmark_errors.json, radii.json, uncertainty.toml and verdict.toml.  Bodies of the groups `validation` and
`test` are left for whoever measures what came of it (`breastrig evaluate BODIES --model MODEL`).  The rules:
docs/decisions/0024.
"""

import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from breastrig.core.errors import BadInput
from breastrig.correspondence.distances import Comparison
from breastrig.fitting.body.landmarks import FILE as LANDMARKS
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.uncertainty.radii import Calibration
from breastrig.fitting.verdicts.fit_signals import FitSignals, fit_signals
from breastrig.fitting.verdicts.verdict import VerdictLimits, verdict_limits
from breastrig.gltf.known_files import bind_known
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.stance_priors import in_stance
from breastrig.rig.validation.finding import named
from breastrig_studies.bodies.body_statistics import KnownBody, document, statistics
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.landmark_errors import document as document_of_landmarks
from breastrig_studies.landmark_errors import residuals_of
from breastrig_studies.radii_factors import Known, Score, factors, fitted, scores_of, trials, write_factors
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.reference_fit import ReferenceFit, reference_fit

BODIES = "bodies.json"
FEWEST = 6  # bodies
FREEDOM_GIVEN, FREEDOM_ELSEWHERE = 4.0, 16.0  # of the picks' scatter, as the torso's
EXPECTED = 0.75  # quantile of scatters: most picks that are added then make places surer
BEYOND, PART = 4.0, 1.5  # times the way from the median to the worst right fit; the torso's limits are near these
RIGHT = 0.04  # of the rig's length: a fit whose landmarks are farther off on the mean is wrong, 20 mm of a torso


@dataclass(frozen=True, eq=False)
class Trial:
    """One fit of a scan."""

    body: str
    stance: str
    scores: Sequence[Score]
    error: float  # m, of landmarks on the mean
    signals: FitSignals
    margin: float | None  # of the start, without picks


@dataclass(eq=False)
class LearnedFits:
    """Results of all fits; of wrong ones, for the verdict to detect, only how clear their starts were."""

    known: Known = field(default_factory=list)
    signals: list[FitSignals] = field(default_factory=list)
    margins: dict[bool, list[float]] = field(default_factory=lambda: {True: [], False: []})  # of right and wrong fits

    def add(self, rig: Rig, trial: Trial) -> None:
        right = trial.error < RIGHT * _length(rig)
        if trial.margin is not None:
            self.margins[right].append(trial.margin)
        if right:
            self.known += [(trial.body, trial.stance, each) for each in trial.scores]
            self.signals.append(trial.signals)


def learn(glb: Path, bodies: Path) -> Path:
    """Writes what is known of the rig; the folder.  Raises BadInput without bodies to learn from."""
    cases = [case for case in read_cohort(bodies) if case.teaches]
    if len({case.patient for case in cases}) < FEWEST:
        raise BadInput(f"{bodies} has fewer than {FEWEST} bodies to learn from; more are needed to say what 90 % are.")
    unknown = [f"{case.patient}/{case.name}" for case in cases if not (case.folder / "truth.ply").is_file()]
    if unknown:
        raise BadInput(f"{bodies} has scans without truth.ply ({named(unknown)}); nothing can be learned of them.")
    rig, recipe = read_rig(glb), load_recipe("default")
    truths = {case: reference_fit(read_scene(case), rig, recipe) for case in _counted(cases, "true skins")}
    known = [
        KnownBody(case.patient, case.stance, truth.parameters) for case, truth in truths.items() if truth is not None
    ]
    rig = _knowing(rig, BODIES, document(rig, statistics(rig, known)))
    rig = _knowing(rig, LANDMARKS, document_of_landmarks(residuals_of(cases, rig, recipe)))
    found = LearnedFits()
    for case in _counted(cases, "fits"):
        for trial in _trials(read_scene(case), rig, recipe, truths[case]):
            found.add(rig, trial)
    return write(glb, rig, found, {case.stance for case in cases}, len(known))


def _knowing(rig: Rig, file: str, found: dict[str, Any]) -> Rig:
    """The rig with this of what is known of it; all is written at the end, so that no folder is of two learnings."""
    return replace(rig, known={**rig.known, file: json.dumps(found) + "\n"})


def _counted(cases: list[Case], what: str) -> Iterator[Case]:
    """The cases, with a progress bar on a terminal."""
    yield from tqdm(cases, unit="scan", disable=not sys.stderr.isatty(), leave=False, desc=what)


def write(glb: Path, rig: Rig, found: LearnedFits, stances: set[str], scans: int) -> Path:
    """Radii and verdict into the rig's folder, and what the rig itself knows of bodies and landmarks."""
    folder = glb.with_suffix(".known")
    folder.mkdir(exist_ok=True)
    for name in rig.known.keys() & {BODIES, LANDMARKS}:
        (folder / name).write_text(rig.known[name], "utf-8")
    uncertainty = _uncertainty(rig, found)
    write_factors(folder, factors(found.known, Calibration.model_validate(uncertainty)))
    (folder / "uncertainty.toml").write_text(_toml(uncertainty, scans), "utf-8")
    (folder / "verdict.toml").write_text(_toml(_verdict(found, stances), scans), "utf-8")
    return bind_known(glb, rig.sha256).parent


def _trials(scene: Scene, rig: Rig, recipe: Recipe, true: ReferenceFit | None) -> Iterator[Trial]:
    alone = scene.place(rig)
    for picks in trials(scene):
        posterior = fitted(scene, rig, recipe, picks, scene.start(rig, picks) if picks else alone.parameters)
        if posterior is None:
            continue
        margin, vertices = None if picks else alone.margin, posterior.state.vertices
        compared = Comparison(scene.target, vertices, rig.faces)
        yield Trial(
            scene.case.patient,
            scene.case.stance,
            tuple(scores_of(posterior, scene, true)),
            float(scene.landmark_errors(rig, vertices).mean()),
            fit_signals(in_stance(rig, scene.case.stance), posterior.state.x, compared, margin),
            margin,
        )


def _length(rig: Rig) -> float:
    """m"""
    return float(np.ptp(rig.template, axis=0).max())


def _uncertainty(rig: Rig, found: LearnedFits) -> dict[str, Any]:
    """The document of fitting/uncertainty/radii.py."""
    scatters = [each.scatter for _, _, each in found.known if each.picks]
    right, wrong = found.margins[True], found.margins[False]
    clear = max(0.7 * min(right, default=0.0), 1.3 * max(wrong, default=0.0), 0.01)  # all of these lay right
    return {
        "expected_scatter": round(float(np.quantile(scatters, EXPECTED)), 2) if scatters else 1.0,
        "freedom_given": FREEDOM_GIVEN,
        "freedom_elsewhere": FREEDOM_ELSEWHERE,
        "without_picks": {
            "clear": round(clear, 3),
            "unclear": round(clear / 4.0, 3),
            "astray": round(0.5 * _length(rig), 3),
        },
    }


def _verdict(found: LearnedFits, stances: set[str]) -> dict[str, Any]:
    """The document of fitting/verdicts/verdict.py: the torso's signals and words with limits of these fits."""
    torso = verdict_limits(read_rig(default_rig_path()))
    assert torso is not None
    signals = {}
    for name, limit in torso.signals.items():
        values = np.array([getattr(each, name) for each in found.signals])
        values = values[np.isfinite(values)]
        if len(values):
            middle, worst = float(np.median(values)), float(values.max() if limit.above else values.min())
            beyond = middle + (PART if limit.scan_alone else BEYOND) * (worst - middle)
            rounded = float(f"{max(beyond, 0.0):.3g}")
            if worst != middle and rounded > 0.0:  # where all fits are alike it says nothing
                signals[name] = limit.model_copy(update={"limit": rounded})
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

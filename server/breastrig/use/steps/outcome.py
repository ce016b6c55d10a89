"""Each iteration of one scan's fit as an event, and what is known at its end.

Nothing is written here: the same outcome becomes a folder of files, an event, or a program's `Fit`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import cast

import numpy as np

from breastrig.colour.areolae import ObservedAreola
from breastrig.colour.features.observation import Observation
from breastrig.core.arrays import Array
from breastrig.core.clock import Clock
from breastrig.core.errors import BreastRigError, FitFailed
from breastrig.core.stances import Stance
from breastrig.correspondence.distances import Comparison, SurfaceDistances
from breastrig.drawings.line_error import with_errors
from breastrig.drawings.project_drawing import on_scan
from breastrig.files.result import DoubtedPick
from breastrig.fitting.body.refine import refined, skin_behind
from breastrig.fitting.checks.basis import CheckBasis, check_basis
from breastrig.fitting.fit import FitIterate
from breastrig.fitting.hypotheses import UNCLEAR
from breastrig.fitting.observed.landmarks import followed, observed_areolae
from breastrig.fitting.picks.issues import unusual
from breastrig.fitting.posterior import Posterior, contribution
from breastrig.fitting.propose import propose_landmarks
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import MIN_LANDMARKS
from breastrig.fitting.task import PickIssue, ended
from breastrig.fitting.uncertainty.radii import HOLDS_90, Radii
from breastrig.fitting.verdicts.reasons import GivenLandmarks, picked_names
from breastrig.fitting.verdicts.verdict import Verdict, judge
from breastrig.geometry.polyline import Polyline
from breastrig.gltf.pose_nodes import node_poses
from breastrig.least_squares.newton import Status
from breastrig.rig.cohort_posterior import Gaussian
from breastrig.rig.model import ModelDrawing, Rig
from breastrig.rig.parameters import RigParameters
from breastrig.scan.limits import NO_PLACES
from breastrig.scan.scan import Scan
from breastrig.use.steps.events import Iterated, NodePose, Started
from breastrig.use.steps.prepare import ReadyScan


@dataclass(frozen=True, eq=False)
class RecordedIterate:
    """One iteration and its event."""

    iterate: FitIterate
    event: Iterated


@dataclass(frozen=True, eq=False)
class ModelAlone:
    """The rig as its bones and shapes have it, without the free-form layer."""

    vertices: Array  # (V, 3) m, in the scan's frame
    distances: SurfaceDistances


@dataclass(frozen=True, eq=False)
class FitOutcome:
    """The result of a fit, from which its files, a report or a program's `Fit` are made.

    Parameters are in the scan's frame, metres.
    """

    ready: ReadyScan  # what was fitted, and as what
    recorded: tuple[RecordedIterate, ...]
    parameters: RigParameters
    covariance: Array  # (P, P) of a step from the parameters (fitting/posterior.py)
    body: Gaussian | None  # what it says of the body (fitting/posterior.py)
    vertices: Array  # (V, 3) m, the fitted surface in the scan's frame, refined or not
    model_alone: ModelAlone
    timing_s: dict[str, float]
    distances: SurfaceDistances
    seen: Mapping[str, Observation]  # by name, from colours
    doubts: tuple[PickIssue, ...]  # picks that are asked about
    drawing: ModelDrawing | None
    drawing_missing: tuple[str, ...]  # of each pattern that does not fit on this patient why, a sentence or two
    lines: tuple[Polyline, ...]
    radii: Radii | None  # None: nothing is known of this model's errors
    areolae: Mapping[str, ObservedAreola | None]  # by side, None where none is seen; empty for a scan without texture
    verdict: Verdict
    checks: CheckBasis | None  # None: nothing is known of this model's errors


def started(ready: ReadyScan) -> Started:
    """The first event of the fit."""
    plan, found = ready.plan, ready.hypothesis
    return Started(
        stance=cast(Stance, found.task.stance),
        stance_reason=found.stance_reason,
        preset=found.task.recipe.name,
        model_sha256=plan.rig.sha256,
        drawing=plan.settings.drawing,
        iterations_limit=found.task.recipe.iterations_limit,
        notes=list(ready.notes),
        landmarks_not_followed=[DoubtedPick(names=list(d.names), reason=d.reason) for d in ready.exchanged],
    )


def record(ready: ReadyScan, iterate: FitIterate) -> RecordedIterate:
    """The iterate with its event; FitFailed when the fit broke down."""
    if not iterate.is_finite:
        raise FitFailed(_with_file(_why_failed(iterate, _given(ready)), ready.scan))
    return RecordedIterate(iterate, _iterated(ready.plan.rig, iterate))


def outcome_of(ready: ReadyScan, recorded: Sequence[RecordedIterate], clock: Clock) -> FitOutcome:
    """The outcome of a fit from its iterates, with the times of the `clock`; FitFailed when this is no torso."""
    last = recorded[-1].iterate
    found, task = ready.hypothesis, ready.hypothesis.task
    rig, target = task.rig, task.target
    rejected = (*ready.exchanged, *last.not_followed)
    posterior = Posterior(ended(task, last), last.parameters)
    doubtful = (*rejected, *unusual(posterior)) if task.picked else rejected  # nobody can be asked about those
    vertices = posterior.state.vertices
    judged = judge(
        posterior,
        last.status,
        _given(ready),
        doubtful,
        found.clearness,
        lesions=ready.scan.lesions,
        contradicted=ready.contradicted,
        size_known=True if ready.scan.true_size else None if ready.scan.size_known else False,
        unclear_stance=found.stance_reason in UNCLEAR,
        repeats=partial(_only_repeats, ready),
    )
    if not judged.verdict.is_torso:
        raise FitFailed(_with_file(judged.refusal, ready.scan))
    compared = judged.compared
    if ready.plan.settings.refine:
        clock.lap()
        behind = skin_behind(rig, task.stance, target, vertices)
        vertices = refined(target, vertices, rig.faces, behind).vertices
        clock.lap("refine")
        compared = Comparison(target, vertices, rig.faces)
    seen = followed(task, found.shown, {name for issue in rejected for name in issue.names})
    known = judged.radii
    if known is not None and seen:
        known = replace(known, landmarks=known.landmarks | {name: HOLDS_90 * each.error for name, each in seen.items()})
    issues = tuple(issue for issue in doubtful if not task.certain.issuperset(issue.names))
    doubted = {name for issue in issues for name in issue.names}
    # a pattern begins where measures do: as picked, else as seen, else where the model has it
    places = {name: each.place for name, each in seen.items()}
    places |= {name: place for name, place in ready.plan.landmarks.items() if name not in doubted}
    asked = ready.plan.drawing
    drawing, missing = asked.where_it_fits(rig, vertices, places) if asked else (None, ())
    lines = on_scan(rig, vertices, drawing, target) if drawing else ()
    lines = with_errors(rig, compared.search, None if known is None else known.vertices, lines)
    sure = task.picked - {*ready.plan.unsure}
    checks = None if known is None else check_basis(posterior, known, seen, sure | doubted)
    areolae = observed_areolae(rig, vertices, ready.plan.landmarks, ready.scan, found.shown)
    clock.total()
    return FitOutcome(
        ready=ready,
        recorded=tuple(recorded),
        parameters=last.parameters.without_modes,
        covariance=posterior.covariance(),
        body=contribution(posterior),
        vertices=vertices,
        model_alone=ModelAlone(posterior.state.vertices, judged.compared.distances),
        timing_s=dict(clock.seconds),
        distances=compared.distances,
        seen=seen,
        doubts=issues,
        drawing=drawing,
        drawing_missing=missing,
        lines=lines,
        radii=known,
        areolae=areolae,
        verdict=judged.verdict,
        checks=checks,
    )


def _given(ready: ReadyScan) -> GivenLandmarks:
    """Counts of landmarks that a person has given, before any of them was doubted."""
    plan = ready.plan
    picked = len(plan.landmarks.keys() - plan.unsure)
    followed = len(ready.hypothesis.task.picked)
    return GivenLandmarks(picked, len(plan.rig.landmark_names) - picked, followed, agreed=len(plan.unsure))


def _only_repeats(ready: ReadyScan) -> bool:
    """Whether too few landmarks are a person's own; asks for the proposals once more, for nobody hands them on."""
    task = ready.hypothesis.task
    try:
        proposed = propose_landmarks(task.rig, ready.prepared, load_recipe("default"), ready.orientation, ready.scan)
    except BreastRigError:
        return False
    picks = {name: task.given[name].place for name in task.picked}
    places = {name: each.point for name, each in proposed.items()}
    return len(picked_names(picks, places)) < MIN_LANDMARKS


def _iterated(rig: Rig, iterate: FitIterate) -> Iterated:
    gap = iterate.landmark_distance
    return Iterated(
        iteration=iterate.iteration,
        stage=iterate.stage,
        energy=round(float(np.nan_to_num(iterate.energy)), 6),
        mean_distance_mm=round(1e3 * iterate.mean_distance, 4),
        landmark_distance_mm=None if gap is None else round(1e3 * gap, 4),
        coverage=round(iterate.coverage, 4),
        elapsed_s=round(iterate.elapsed_s, 4),
        nodes=[NodePose.model_validate(node) for node in node_poses(rig, iterate.parameters)],
        modes=[round(weight, 6) for weight in iterate.parameters.modes.tolist()],
    )


def _with_file(sentence: str, scan: Scan) -> str:
    """The sentence, and what was left out of the file because it is no place."""
    return " ".join([sentence, *(note for note in scan.notes if NO_PLACES in note)])


def _why_failed(iterate: FitIterate, given: GivenLandmarks) -> str:
    """A sentence on the failure, with advice that was not followed yet."""
    if iterate.status is Status.NOT_FINITE:
        advice = given.advice or "check the landmarks"
        return f"The fit broke down (a number is not finite); {advice}, or try another scan."
    advice = f"{given.advice}, or check the scan's unit" if given.advice else "check the landmarks and the scan's unit"
    return f"The model found no skin of the scan near it; {advice}."

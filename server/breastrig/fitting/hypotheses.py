"""A fit's hypothesis: its start and stance, found from landmarks and scan, or taken over from an earlier fit.

A table decides whether a patient lies (scan/orient.py), unless plane and body are both upright in the scanner's axes.
Without one a fit as standing shows the stance (starts/stance_signs.py); an unclear answer asks the user, and is a
reason in the verdict.

Findings from the scan alone, once, at the upload, are then known to proposals and fits: in the scan's own frame and as
plain numbers, so that they are stored with the scan. The place of the model's rest pose belongs to one model; for
another one it is found again. Continuing from an earlier fit of the same scan is for a person who moves one pick and
looks at the result: finding start and stance costs more than the iterations that are then needed. The result is that of
a fresh fit with the same picks, up to the remaining error of the last iterations (0.1 to 0.6 mm on average, measured
with picks moved by 10 mm).
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, cast

import numpy as np

from breastrig.colour.features.observation import LOOKED_FOR, Observation
from breastrig.core.clock import Clock
from breastrig.core.stances import AUTO, PRONE, STANDING, SUPINE
from breastrig.fitting.body.hanging import hanging_shapes
from breastrig.fitting.observed.landmarks import colour_observations, with_observations
from breastrig.fitting.prepare_scan import PreparedScan
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.starts.hypotheses import Opening
from breastrig.fitting.starts.orientation import (
    MIN_LANDMARKS,
    SURE_LANDMARKS,
    Start,
    agree,
    best_start,
    contradicted,
    prone_start,
    start_from_landmarks,
    start_from_scan,
)
from breastrig.fitting.starts.rigid_search import OBLIQUE, turned_from
from breastrig.fitting.starts.stance_signs import SCANNERS_UP, UPRIGHT, likely_stance, measured_signs
from breastrig.fitting.task import FitIterate, FitTask, ended
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.similarity import Similarity, body_axes, similar_parameters
from breastrig.rig.skinning import pose
from breastrig.scan.orient import Frame
from breastrig.scan.scan import Scan

SURE_MARGIN = 0.3  # of start_from_scan; whole scans have 0.28 to 1.1

WALL = (
    "An upright plane is close behind, and the patient seems to stand: a wall. "
    "If it is a table, say that the patient lies."
)
TABLE = (
    "An upright plane is close behind, and the patient seems to lie: a table. "
    "If it is a wall, say that the patient stands."
)


def may_be_wall(task: FitTask, frame: Frame) -> bool:
    """Whether the plane behind the body is upright in the scanner's own axes, and the body at its start as well."""
    if frame.table is None:
        return False
    up = body_axes(task.rig, pose(task.rig, task.start))[:, 1]
    return bool(np.linalg.norm(np.cross(frame.table[0], SCANNERS_UP)) > UPRIGHT and up @ SCANNERS_UP > UPRIGHT)


LIES = "There is no table in the scan, but the patient seems to lie."
STANDS = "There is no table in the scan, and the patient seems to stand."
MAY_LIE = "Without a table it is not clear: the patient seems to lie. If the patient stands, say so."
MAY_STAND = "Without a table it is not clear: the patient seems to stand. If the patient lies, say so."
MAY_HANG = (
    "Only a chest's front is seen, and its breasts may hang to the front: prone. "
    "If not, say how the patient was scanned."
)
HANGS = (
    "Only the front of a chest is seen, and its breasts hang to the front: prone. "
    "If not, say how the patient was scanned."
)
UNCLEAR = (MAY_LIE, MAY_STAND, MAY_HANG)
REASONS = {STANDING: (MAY_STAND, STANDS), SUPINE: (MAY_LIE, LIES), PRONE: (MAY_HANG, HANGS)}  # unsure, sure


@dataclass(frozen=True, eq=False)
class FoundStance:
    """A stance, why, and the fit that showed it: all iterates of the task in it, none where no fit was needed."""

    stance: str  # standing | supine | prone
    reason: str
    iterates: tuple[FitIterate, ...] = ()
    start: Start | None = None  # where the stance has one of its own


def found_stance(task: FitTask, frame: Frame, known_opening: Opening | None = None) -> FoundStance:
    """For a task whose start is right and whose stance does not matter yet; `known_opening` was fitted to find it.

    Whoever fits the task next goes on from the iterates, so that nothing is fitted twice.
    """
    wall = may_be_wall(task, frame)
    is_said = frame.stance == PRONE or (frame.stance == SUPINE and not wall)
    if is_said or not any(shape.kind == "gravity" for shape in task.rig.shapes):
        return FoundStance(frame.stance, frame.stance_reason)
    task = replace(task, stance=STANDING)
    standing = tuple(checked_iterates(task, _same(known_opening, task)))
    likely = likely_stance(measured_signs(task, standing[-1]))
    if wall:
        return FoundStance(STANDING, WALL, standing) if likely.stance == STANDING else FoundStance(SUPINE, TABLE)
    reason = REASONS[likely.stance][likely.sure]
    if likely.stance == STANDING:
        return FoundStance(STANDING, reason, standing)
    task = replace(task, stance=likely.stance)
    if likely.stance == SUPINE:
        return FoundStance(SUPINE, reason, tuple(checked_iterates(task)))
    start = prone_start(task.rig, task.target, frame)
    task = replace(task, start=start.parameters)
    return FoundStance(PRONE, reason, () if task.landmarks else tuple(checked_iterates(task)), start)


def _same(opening: Opening | None, task: FitTask) -> Opening | None:
    """The opening, if it is this task's."""
    if opening is None or task.landmarks:
        return None
    return opening if opening.task.stance == task.stance and opening.task.recipe is task.recipe else None


@dataclass(frozen=True, eq=False)
class ScanOrientation:
    """The orientation of one scan, for one model."""

    model_sha256: str
    frame: Frame  # as seen on the scan, before the model was tried
    start: Similarity  # of the model's rest pose in the scan's frame (m)
    margin: float  # see fitting/starts/orientation.py: how clear the start is
    stance: str  # standing | supine | prone
    stance_reason: str
    fitted: RigParameters | None = None  # where the fit without landmarks ended; None: the stance took none
    hanging: tuple[str, ...] = ()  # shapes by which breasts were seen to hang in that fit
    contradicted: bool = False  # whether the scan clearly shows its body another way round than the file says

    def body_frame(self) -> dict[str, Any]:
        """Up and front of the body as the model found them, for the page's camera."""
        return {
            "up": self.start.rotation[:, 1].tolist(),
            "front": self.start.rotation[:, 2].tolist(),
            "confidence": round(float(np.clip(self.margin / SURE_MARGIN, 0.0, 1.0)), 2),
            "reason": "This is how the model fits best; turn the view if it is wrong.",
        }

    def facts(self) -> dict[str, Any]:
        """Plain values, ready for JSON."""
        return cast(dict[str, Any], json.loads(json.dumps(asdict(self), default=np.ndarray.tolist)))


def orientation_from(facts: dict[str, Any] | None, rig: Rig) -> ScanOrientation | None:
    """The orientation stored in `facts`; None where none is, in another form, or if it was found with another model."""
    if facts is None or facts["model_sha256"] != rig.sha256 or "frame" not in facts:
        return None
    seen, start, fitted = facts["frame"], facts["start"], facts.get("fitted")
    arrays = {name: np.array(seen[name]) for name in ("up", "front", "fronts")}
    planes = [None if each is None else (np.array(each[0]), each[1]) for each in (seen["table"], *seen["background"])]
    return ScanOrientation(
        **facts
        | {
            "frame": Frame(**seen | arrays | {"table": planes[0], "background": tuple(planes[1:])}),
            "start": Similarity(start["scale"], np.array(start["rotation"]), np.array(start["translation"])),
            "fitted": None if fitted is None else RigParameters.of_numbers(fitted),
            "hanging": tuple(facts["hanging"]),
        }
    )


def scan_orientation(
    rig: Rig, scan: PreparedScan, recipe: Recipe
) -> tuple[ScanOrientation, FitTask, tuple[FitIterate, ...]]:
    """The orientation, the task of fitting the scan without landmarks, and its iterates where the stance took a fit."""
    start = start_from_scan(rig, scan.target, scan.frame.fronts, scan.frame.known)
    task = FitTask(rig, scan.target, start.parameters, recipe, {})
    found = found_stance(task, scan.frame, start.opening)
    if found.stance == PRONE:
        start = found.start or prone_start(rig, scan.target, scan.frame)
        task = replace(task, start=start.parameters)
    last = found.iterates[-1] if found.iterates and found.iterates[-1].is_finite else None
    orientation = ScanOrientation(
        rig.sha256,
        scan.frame,
        start.similarity,
        start.margin,
        found.stance,
        found.reason,
        None if last is None else last.parameters,
        () if last is None else last.hanging,
        contradicted(rig, scan.target, scan.frame, found.stance),
    )
    return orientation, replace(task, stance=found.stance), found.iterates


def orientation_task(rig: Rig, scan: PreparedScan, orientation: ScanOrientation, recipe: Recipe) -> FitTask:
    """The task of fitting the scan without landmarks from where it was found to lie."""
    start = similar_parameters(rig, orientation.start)
    return FitTask(rig, scan.target, start, recipe, {}, stance=orientation.stance)


def with_start(task: FitTask, scan: PreparedScan, orientation: ScanOrientation | None) -> tuple[FitTask, float | None]:
    """The task with a start found for its scan and landmarks, and how clear that is (Start.margin).

    None where landmarks placed it.  `orientation` is that of the scan when it is known already.
    """
    if orientation is None and len(task.landmarks) < MIN_LANDMARKS:
        found = start_from_scan(task.rig, task.target, scan.frame.fronts, scan.frame.known)
        return replace(task, start=found.parameters), found.margin
    known = None if orientation is None else orientation.start
    frame = scan.frame
    start = best_start(task.rig, task.target, dict(task.landmarks), lambda: frame.fronts, known, frame.known)
    clear = orientation.margin if orientation is not None and len(task.landmarks) < MIN_LANDMARKS else None
    return replace(task, start=start), clear


def with_stance(
    task: FitTask, stance: str, scan: PreparedScan, orientation: ScanOrientation | None
) -> tuple[FitTask, FoundStance]:
    """A task that has its start, in the stance that was asked for or found, and how it was found.

    The body shows its stance in a fit: the one that was made when the orientation was found, so that landmarks change
    no answer, unless they lie elsewhere than it ended; else the fit itself, which then goes on from there.
    """
    if stance != AUTO:
        found = FoundStance(stance, "As asked for.")
    elif orientation is not None and _found(task, orientation):
        found = FoundStance(orientation.stance, orientation.stance_reason)
    else:
        found = found_stance(task, scan.frame)
    task = replace(task, stance=found.stance)
    if found.stance != PRONE or len(task.landmarks) >= MIN_LANDMARKS:
        return task, found
    if found.start is None and (orientation is None or orientation.stance != PRONE):
        found = replace(found, start=prone_start(task.rig, task.target, scan.frame))
    return (task if found.start is None else replace(task, start=found.start.parameters)), found


def contradiction(task: FitTask, scan: PreparedScan, orientation: ScanOrientation | None) -> bool:
    """Whether the scan, or so many landmarks that they place a body, show it another way round than the file says."""
    if scan.frame.known is None:
        return False
    if len(task.picked) >= SURE_LANDMARKS:
        picked = pose(task.rig, start_from_landmarks(task.rig, dict(task.landmarks)))
        if turned_from(body_axes(task.rig, picked), scan.frame.known, OBLIQUE):
            return True
    if orientation is not None:
        return orientation.contradicted
    return contradicted(task.rig, task.target, scan.frame, task.stance)


def _found(task: FitTask, orientation: ScanOrientation) -> bool:
    """Whether the fit of the orientation ended where the landmarks are; True where there is no such fit, or none."""
    fitted = orientation.fitted
    return fitted is None or not task.landmarks or agree(task.rig, fitted, task.landmarks)


def continued(task: FitTask, stance: str, earlier: str, start: RigParameters) -> tuple[FitTask, FoundStance]:
    """The task going on from the `start` at which a fit in an `earlier` stance ended, in that one unless asked for."""
    found = FoundStance(earlier, "As in the fit that this one goes on from.")
    if stance != AUTO:
        found = FoundStance(stance, "As asked for.")
    hanging = hanging_shapes(task.rig, start, task.recipe)
    return replace(task, start=start, recipe=task.recipe.continued, stance=found.stance, hanging=hanging), found


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A fit before its first iteration: its task, with start and stance, and what was found on the way there."""

    task: FitTask
    stance_reason: str
    clearness: float | None  # of the start, where the scan alone placed it
    shown: Mapping[str, Observation] | None  # what colours show of the landmarks; None: not looked at
    iterates: tuple[FitIterate, ...] = ()  # all iterates of the task's fit, where they were needed to find the stance


def found_hypothesis(
    task: FitTask, prepared: PreparedScan, scan: Scan, stance: str, orientation: ScanOrientation | None, clock: Clock
) -> Hypothesis:
    """The task with a start and with landmarks that the colours show, in the stance that was asked for or found.

    `orientation` is that of the scan when it is known already; `clock` counts `align` and what the stance takes.
    """
    task, clearness = with_start(task, prepared, orientation)
    clock.lap("align")
    task, found = with_stance(task, stance, prepared, orientation)
    clearness = clearness if found.start is None else found.start.margin
    known = orientation is not None and orientation.stance == task.stance and task.recipe is load_recipe("default")
    fitted = orientation.fitted if orientation is not None and known else None
    task, iterates, shown = _with_colour(task, found.iterates, fitted, clearness, scan)
    clock.lap("solve")
    return Hypothesis(task, found.reason, clearness, shown, iterates)


def continued_hypothesis(
    task: FitTask, scan: Scan, stance: str, earlier: str, start: RigParameters, clock: Clock
) -> Hypothesis:
    """The task going on from the `start` at which a fit in an `earlier` stance ended; else as `found_hypothesis`."""
    task, found = continued(task, stance, earlier, start)
    clock.lap("align")
    shown = None
    if _looks_at_colour(task, scan):
        with_colour, shown = _observed_from(task, task, task.start, None, scan)
        task = replace(with_colour, recipe=task.recipe)  # which goes on already
    clock.lap("solve")
    return Hypothesis(task, found.reason, None, shown)


def _with_colour(
    task: FitTask,
    known_iterates: tuple[FitIterate, ...],
    fitted: RigParameters | None,
    clearness: float | None,
    scan: Scan,
) -> tuple[FitTask, tuple[FitIterate, ...], Mapping[str, Observation] | None]:
    """The task with landmarks that the colours show, its iterates as far as they are known, and what is shown.

    `fitted` is where the task without landmarks is known to end.  Beside picks the form is fitted with them first: it
    knows better than without where to look for the others, which the colours show as they did before.
    """
    if not _looks_at_colour(task, scan):
        return task, known_iterates, None
    known = task
    if task.given or fitted is None:
        last = (known_iterates or tuple(checked_iterates(task)))[-1]
        if not last.is_finite:
            return task, known_iterates, {}
        fitted = last.parameters
        known = ended(task, last) if task.given else task
    going_on, shown = _observed_from(task, known, fitted, clearness, scan)
    return going_on, known_iterates if going_on is task else (), shown


def _looks_at_colour(task: FitTask, scan: Scan) -> bool:
    """Whether colours or the image can show a landmark that is not given."""
    is_looked_for = bool((LOOKED_FOR & {*task.rig.landmark_names}) - task.given.keys())
    return (scan.shows_colour or bool(scan.seen)) and is_looked_for


def _observed_from(
    task: FitTask, known: FitTask, fitted: RigParameters, clearness: float | None, scan: Scan
) -> tuple[FitTask, Mapping[str, Observation]]:
    """The task that goes on from where it `fitted` as far as it is `known`, and what the colours show from there."""
    shown = colour_observations(known, fitted, clearness, scan)
    return with_observations(task, shown, fitted), shown

"""Checks a fit's request, and prepares a scan for its first iteration.

Shared by fits from files (FitJob) and fits of a program that has read its scan already. Everything that can be wrong
with the request itself is found before the scan is read.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.clock import Clock
from breastrig.core.errors import BadLandmarks, BadSettings, unknown_name, unknown_names
from breastrig.core.picks import Length, Picks
from breastrig.core.stances import AUTO, STANCES
from breastrig.core.units import BEYOND, distance_text
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.patterns import AskedDrawing, asked_drawing
from breastrig.fitting.body.expected_body import cohort_posterior
from breastrig.fitting.hypotheses import (
    Hypothesis,
    ScanOrientation,
    continued_hypothesis,
    contradiction,
    found_hypothesis,
    orientation_from,
)
from breastrig.fitting.observed.landmarks import IN_IMAGE
from breastrig.fitting.prepare_scan import PreparedScan, prepared_scan
from breastrig.fitting.propose import expected_error
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.starts.orientation import sides_exchanged
from breastrig.fitting.task import FitTask, PickIssue
from breastrig.gltf.pose_nodes import posed_by_nodes
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.blocks import block
from breastrig.rig.cohort_prior import parsed_prior, with_prior
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.scan.hand_cuts import without_hand_cuts
from breastrig.scan.landmarks.landmark_files import checked_certain
from breastrig.scan.landmarks.marks import listed, with_marks
from breastrig.scan.landmarks.names import known_name
from breastrig.scan.orient import NOT_AS_STATED
from breastrig.scan.read import coloured_scan
from breastrig.scan.scan import Scan
from breastrig.scan.true_size import TrueSize, true_size
from breastrig.use.steps.settings import FIRST, EarlierFit, FitJob, FitSettings

ALL_EXCHANGED = "Left and right of the landmarks look exchanged, or the scan is mirrored; none of them was followed."
SHOWN_BY_COLOUR = 0.74  # confidence; on 98 scans form proposed none surer than 0.72, colour none less sure than 0.75
NOT_FOLLOWED = (
    "The image shows what may be the {}, far from where the form has it, so it was not followed; place it by hand."
)
FAR_LANDMARK = 0.1  # m from the scan; such a pick belongs to another scan or another unit


def checked_landmarks(rig: Rig, landmarks_mm: dict[str, list[float]]) -> dict[str, Array]:
    """Landmarks in metres under the model's names for them; BadLandmarks names the wrong word or value."""
    return checked_picks(rig, Picks(landmarks_mm))[0]


def checked_picks(rig: Rig, picks: Picks) -> tuple[dict[str, Array], dict[str, Array], Picks]:
    """Landmarks in metres under the model's names for them, the marks in metres, and the picks under these names.

    Raises BadLandmarks with one sentence, which names the wrong word or value.
    """
    named = with_marks(picks, landmark_words(rig))
    if unknown := [name for name in named.points_mm if name not in rig.landmark_names]:
        raise BadLandmarks(unknown_names("landmark of this model", unknown, rig.landmark_names))
    return _in_metres(named.points_mm), _in_metres(named.marks_mm, "The mark"), named


def _in_metres(points_mm: Mapping[str, Sequence[float]], kind: str = "The landmark") -> dict[str, Array]:
    result = {}
    for name, place in points_mm.items():
        point = np.asarray(place, dtype=np.float64)
        if point.shape != (3,) or not np.isfinite(point).all():
            raise BadLandmarks(f"{kind} {name} needs three finite numbers x y z.")
        if np.abs(point).max() > BEYOND:
            raise BadLandmarks(f"{kind} {name} has a coordinate larger than 1e9; check the file and its unit.")
        result[name] = 1e-3 * point
    return result


def landmark_words(rig: Rig) -> dict[str, tuple[str, str]]:
    """The English and Latin names of the model's landmarks."""
    return {each.name: (each.label, each.latin) for each in rig.landmarks}


def _near_the_scan(landmarks: dict[str, Array], marks: dict[str, Array], target: ScanTarget) -> None:
    if not landmarks and not marks:
        return
    names = [*landmarks, *marks]
    gaps = np.atleast_1d(target.vertex_tree.query(np.array([*landmarks.values(), *marks.values()]))[0])
    worst = int(np.argmax(gaps))
    if gaps[worst] > FAR_LANDMARK:
        name, away = names[worst], distance_text(float(gaps[worst]))
        if name in marks:
            raise BadLandmarks(f"The mark {name} is {away} away from the scan; place it on this scan.")
        raise BadLandmarks(
            f"The landmark {name} is {away} away from the scan; "
            "check that landmarks and scan have the same unit and frame."
        )


@dataclass(frozen=True, eq=False)
class FitPlan:
    """Settings that have been checked against the model."""

    settings: FitSettings
    rig: Rig
    recipe: Recipe
    drawing: AskedDrawing | None
    landmarks: dict[str, Array]  # picked, m, in the scan's frame
    proposed: dict[str, Array]  # the same of those that the scan's form proposed and nobody has checked
    unsure: tuple[str, ...]  # those of both that were proposed
    marks: dict[str, Array]  # places of any name on the skin, m, in the scan's frame
    taken_as_marks: tuple[str, ...]  # those of them that stood among the landmarks
    size: TrueSize | None  # by which the scan is scaled, as landmarks and marks are here; None: it has its true size


@dataclass(frozen=True, eq=False)
class ReadyScan:
    """A scan with its plan and its hypothesis, before the first iteration."""

    plan: FitPlan
    scan: Scan
    prepared: PreparedScan
    exchanged: tuple[PickIssue, ...]  # the landmarks whose sides look exchanged
    orientation: ScanOrientation | None  # as the upload has found it
    hypothesis: Hypothesis
    contradicted: bool  # whether scan or landmarks show the body another way round than the file says
    notes: tuple[str, ...]


def read_model(job: FitJob) -> Rig:
    """The job's rig, with its prior."""
    rig = read_rig(job.model or default_rig_path())
    return rig if job.prior is None else with_prior(rig, parsed_prior(job.prior, "The prior"))


def check_prior(recipe: Recipe, prior: object | None) -> None:
    """Raises BadSettings for a prior that this preset would not look at."""
    if prior is not None and recipe.body is None:
        raise BadSettings(f"The preset {recipe.name} expects nothing of bodies together; leave the prior out.")


def named_drawing(rig: Rig, text: str | None) -> str | None:
    """The request with the rig's own name in the place of `first`; None where nothing is left of it."""
    parts = [] if text is None else text.split("+")
    names = [name for part in parts for name in (rig.drawing_names[:1] if part == FIRST else [part])]
    return "+".join(names) or None


def fit_plan(settings: FitSettings, rig: Rig, landmarks_mm: dict[str, list[float]]) -> FitPlan:
    """The settings and landmarks (mm, in the scan's frame) checked; a BadInput says what is wrong with them."""
    if settings.stance not in STANCES:
        raise BadSettings(unknown_name("stance", settings.stance, STANCES))
    recipe = load_recipe(settings.preset)
    named = named_drawing(rig, settings.drawing)
    drawing = None if named is None else asked_drawing(rig, named)
    for name in settings.locked:
        block(rig, name)
    given = Picks(landmarks_mm, settings.certain, settings.landmark_confidence, settings.marks_mm, settings.open_names)
    landmarks, marks, picks = checked_picks(rig, given)
    size = _size(settings.length, rig, landmarks | marks, named)
    if size is not None:
        landmarks, marks = ({name: size.factor * at for name, at in each.items()} for each in (landmarks, marks))
    confidence = picks.confidence
    settings = replace(settings, drawing=named, landmark_confidence=confidence, certain=picks.certain)
    checked_certain(settings.certain, landmarks, confidence)
    proposed = _only_proposed(landmarks, confidence)
    picked = {name: place for name, place in landmarks.items() if name not in proposed}
    unsure = tuple(name for name in landmarks if confidence.get(name, 1.0) < 1.0)
    unchecked = {name: landmarks[name] for name in proposed}
    taken = tuple(name for name in marks if name not in settings.marks_mm)
    return FitPlan(settings, rig, recipe, drawing, picked, unchecked, unsure, marks, taken, size)


def _size(length: Length | None, rig: Rig, places: dict[str, Array], drawing: str | None) -> TrueSize | None:
    """The scan's true size by the length; BadInput says what is wrong."""
    if length is None:
        return None
    if drawing is not None and "tumour_at:" in drawing:
        raise BadSettings("A place at:X,Y,Z has the file's size; where a length scales the scan give it by the clock.")
    words = landmark_words(rig)
    start, end = (name if name in places else known_name(name, words) for name in (length.start, length.end))
    return true_size(Length(start, end, length.mm), places)


def _only_proposed(landmarks: Collection[str], confidence: Mapping[str, float]) -> frozenset[str]:
    """The landmarks that are no observations: a proposal is made of this very scan, which would count twice.

    Fits of 60 warped bodies with all likely proposals confirmed are as near the true places as fits without them
    (development, validation half: 7.0 and 8.6 mm for 7.2 and 8.7), but the radii that should hold 90 % of the true
    places held 10 and 11 % where they counted as picks, 18 and 14 % where each counted with its error; without, 98 and
    88 %.

    What colours show of landmarks that are not given is looked for again; beside picks such proposals are observations
    with an error of their own.
    """
    unsure = {name for name in landmarks if confidence.get(name, 1.0) < 1.0}
    if unsure.issuperset(landmarks):
        return frozenset(unsure)
    return frozenset(name for name in unsure if confidence[name] < SHOWN_BY_COLOUR)


def scan_of_job(job: FitJob) -> Scan:
    """The job's scan; a BadInput says what is wrong with it."""
    answers = job.answers.without_lesions if job.lesions else job.answers
    scan = without_hand_cuts(coloured_scan(job.scan, job.file_type, job.units, answers), job.cuts)
    if not job.lesions:
        return scan
    from breastrig.scan.images.read_lesions import with_lesions

    return with_lesions(scan, job.lesions, job.answers)


def prepare_fit(plan: FitPlan, scan: Scan, clock: Clock) -> ReadyScan:
    """Cleans and indexes the scan, and finds the start; a BadInput says what is wrong."""
    clock.lap()
    settings, rig, landmarks, earlier = plan.settings, plan.rig, plan.landmarks, plan.settings.earlier
    scan = scan if plan.size is None else scan.in_true_size(plan.size)
    orientation = orientation_from(settings.orientation, rig)
    wished = earlier.stance if earlier is not None and settings.stance == AUTO else settings.stance
    prepared = prepared_scan(scan, wished, None if orientation is None else orientation.frame)
    target = prepared.target
    _near_the_scan(landmarks | plan.proposed, plan.marks, target)
    errors = {name: expected_error(share) for name, share in settings.landmark_confidence.items() if name in landmarks}
    _build(target)
    clock.lap("prepare")
    exchanged = _exchanged(rig, plan.recipe, landmarks, target, settings.certain, prepared.frame.known)
    doubted = {name for doubt in exchanged for name in doubt.names}
    followed = {name: place for name, place in landmarks.items() if name not in doubted}
    task = FitTask(rig, target, rest_parameters(rig), plan.recipe, {}, locked=settings.locked)
    task = task.with_picks(followed, errors, settings.certain)
    if earlier is None:
        found = found_hypothesis(task, prepared, scan, settings.stance, orientation, clock)
    else:
        start = _pose_of(rig, earlier)
        found = continued_hypothesis(task, scan, settings.stance, earlier.stance, start, clock)
    return ReadyScan(
        plan=plan,
        scan=scan,
        prepared=prepared,
        exchanged=exchanged,
        orientation=orientation,
        hypothesis=found,
        contradicted=contradiction(found.task, prepared, orientation),
        notes=(
            *scan.notes,
            *prepared.notes,
            *_not_as_stated(found, scan),
            *_seen(found, scan),
            *_unchecked(plan),
            *_as_marks(plan),
            *_of_cohort(found.task),
        ),
    )


def _pose_of(rig: Rig, earlier: EarlierFit) -> RigParameters:
    """The final pose of an earlier fit; BadSettings when another rig made it."""
    if earlier.model_sha256 != rig.sha256:
        raise BadSettings("The fit to go on from was made with another model; fit the scan anew.")
    return posed_by_nodes(rig, earlier.nodes)


def _unchecked(plan: FitPlan) -> tuple[str, ...]:
    """A note of landmarks that did not count."""
    if not plan.proposed:
        return ()
    first, *others = plan.proposed
    which = f"{1 + len(others)} landmarks are" if others else f"The landmark {first} is"
    return (f"{which} as proposed from this scan, and did not pull at the fit.",)


def _as_marks(plan: FitPlan) -> tuple[str, ...]:
    """A note of names that no landmark has."""
    if not plan.taken_as_marks:
        return ()
    return (f"Taken as marks, as no landmark has these names: {listed(plan.taken_as_marks)}.",)


def _of_cohort(task: FitTask) -> tuple[str, ...]:
    """A note of whose bodies are expected beside the built-in ones."""
    recipe = task.recipe
    posterior = None if recipe.body is None else cohort_posterior(task.rig, recipe.shapes, recipe.body, task.stance)
    if posterior is None:
        return ()
    return (f"Fitted with what {posterior.women} patients in this stance have in common.",)


def _not_as_stated(found: Hypothesis, scan: Scan) -> tuple[str, ...]:
    """A note where the image's header states another position than that of the fit."""
    stated, stance = scan.stated_stance, found.task.stance
    return () if stated in (None, stance) else (NOT_AS_STATED.format(stated, stance),)


def _seen(found: Hypothesis, scan: Scan) -> tuple[str, ...]:
    """Notes of what colours or the image show and nobody has picked, and of what was not followed of the image."""
    if found.shown is None:
        return ()
    task = found.task
    unpicked = {name: each.reason for name, each in found.shown.items() if name not in task.picked}
    by_colour = {name: reason for name, reason in unpicked.items() if reason != IN_IMAGE}
    in_image = [name for name in unpicked if name not in by_colour]
    left = {each.name for each in scan.seen} - found.shown.keys() - set(task.picked)
    notes = [NOT_FOLLOWED.format(each.label) for each in task.rig.landmarks if each.name in left]
    if in_image:
        notes.insert(0, f"Found in the image: {', '.join(in_image)}.")
    if by_colour:
        notes.insert(0, f"Found by colour: {', '.join(by_colour)} ({', '.join(sorted(set(by_colour.values())))}).")
    return tuple(notes)


def _exchanged(
    rig: Rig,
    recipe: Recipe,
    landmarks: dict[str, Array],
    target: ScanTarget,
    certain: Collection[str],
    known: Array | None,
) -> tuple[PickIssue, ...]:
    """The doubt that all sides are exchanged; none where a person is certain of a side."""
    knows_sides = any(landmark.name in certain and landmark.mirror != landmark.name for landmark in rig.landmarks)
    if knows_sides or not sides_exchanged(rig, landmarks, target, recipe.outliers, known):
        return ()
    return (PickIssue(tuple(name for name in landmarks if name not in certain), ALL_EXCHANGED, exchanged=True),)


def _build(target: ScanTarget) -> None:
    """Builds what is built on first use, so that its time counts as preparation and not as solving."""
    _ = target.rays, target.search, target.vertex_tree, target.normals, target.on_border, target.face_normals
    target.may_be_matched(target.vertices[:1], 0.0, reject_border=True)

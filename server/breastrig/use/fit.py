"""One fit: `read -> prepare -> hypothesis -> solve -> judge -> write`, as a stream of iterates, or at once.

What can be wrong with a request is found before the scan is read (steps/prepare.py), which is then cleaned and indexed
and gets its start and stance (fitting/hypotheses.py); fitting/solve.py yields iterates, steps/outcome.py judges where
they end, folder/fit_files.py writes.  Command line, batch, service and programs consume the same iterates.  Whoever
stops consuming a generator cancels the fit; nothing is written then but what was already there.
"""

import inspect
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, wraps
from pathlib import Path
from typing import Any, Generic, ParamSpec, TypeAlias, TypeVar

from numpy.typing import ArrayLike

from breastrig.core.arrays import Array, frozen
from breastrig.core.clock import Clock
from breastrig.core.errors import BadSettings, FitFailed
from breastrig.core.one_thread import one_thread
from breastrig.core.stances import AUTO
from breastrig.drawings.patterns import tumour_text
from breastrig.fitting.solve import checked_iterates
from breastrig.gltf.pose_nodes import node_poses
from breastrig.rig.named_parameters import Parameters, in_metres, parameters_by_name
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose
from breastrig.scan.true_size import length_of
from breastrig.use.folder.fit_files import write_fit_files
from breastrig.use.landmarks import NOTHING, Landmarks, landmarks_in_mm
from breastrig.use.scan import ScanLike, ScanSource
from breastrig.use.steps.events import Done, Event
from breastrig.use.steps.outcome import FitOutcome, RecordedIterate, outcome_of, record, started
from breastrig.use.steps.prepare import ReadyScan, check_prior, fit_plan, prepare_fit, read_model, scan_of_job
from breastrig.use.steps.settings import FIRST, EarlierFit, FitJob, FitSettings
from breastrig.use.values.fit_result import Fit, fit_of_outcome
from breastrig.use.values.model import Model, Rig, files_of, public, with_cohort

Step = TypeVar("Step")
Result = TypeVar("Result")
Given = ParamSpec("Given")
Preset: TypeAlias = str | Mapping[str, Any]


def fit_steps(ready: ReadyScan, clock: Clock) -> Iterator[RecordedIterate | FitOutcome]:
    """Every iterate of the fit, then its outcome; FitFailed when there is none.  `clock` began with the fit."""
    found, recorded = ready.hypothesis, list[RecordedIterate]()
    iterates = iter(found.iterates) if found.iterates else checked_iterates(found.task)
    while True:
        clock.lap()  # without the consumer's time
        iterate = next(iterates, None)
        clock.lap("solve")
        if iterate is None:
            break
        recorded.append(record(ready, iterate))
        yield recorded[-1]
    yield outcome_of(ready, recorded, clock)


def run_fit(job: FitJob) -> Generator[Event, None, None]:
    """Started, Iterated …, Done; a BreastRigError instead when it cannot be done.

    Writes all FIT_FILES (files/result.py) into job.out before Done.
    """
    clock = Clock()
    plan = fit_plan(job, read_model(job), job.landmarks_mm)
    clock.lap()
    scan = scan_of_job(job)
    clock.lap("read")
    ready = prepare_fit(plan, scan, clock)
    yield started(ready)
    for step in fit_steps(ready, clock):
        if isinstance(step, FitOutcome):
            yield Done(result=write_fit_files(step, job.out))
        else:
            yield step.event


@dataclass(frozen=True, eq=False, repr=False)
class Iterate:
    """One state of a fit; numbers in mm are means over what is matched at that moment."""

    iteration: int  # 0 is the start
    stage: str
    energy: float  # comparable within one iteration only: matches and sigmas change
    mean_distance_mm: float  # of matched model vertices to the scan
    landmark_distance_mm: float | None  # of the given landmarks; None without any
    coverage: float  # share of the model's vertices with an accepted match
    elapsed_s: float  # since the first iteration
    model: Rig
    in_metres: RigParameters  # in the scan's frame
    metres_per_unit: float

    @cached_property
    def vertices(self) -> Array:
        """(V, 3) the model at this moment, in the scan's unit and frame."""
        vertices: Array = frozen(pose(self.model, self.in_metres) / self.metres_per_unit)
        return vertices

    @cached_property
    def parameters(self) -> Parameters:
        """Pose and shape at this moment, by name, in the scan's unit and frame."""
        return parameters_by_name(self.model, self.in_metres, self.metres_per_unit)

    def __repr__(self) -> str:
        return f"<Iterate {self.iteration}: {self.stage}, {self.mean_distance_mm:.2f} mm>"


class FitRun(Iterator[Step], Generic[Step, Result]):
    """The iterates of a fit, one at a time; `result()` is what it ends with.

    Nothing is computed between two iterates.  `iterations_limit` is the most that can come.
    """

    def __init__(self, steps: Generator[Step, None, Result], iterations_limit: int) -> None:
        self._steps = steps
        self._result: Result | None = None
        self.iterations_limit = iterations_limit

    def __iter__(self) -> "FitRun[Step, Result]":
        return self

    def __next__(self) -> Step:
        with one_thread():
            try:
                return next(self._steps)
            except StopIteration as end:
                self._result = self._result if end.value is None else end.value
                raise StopIteration from None

    def result(self) -> Result:
        """The fit's result; runs the remaining iterations. Raises FitFailed, also when it was closed before."""
        for _ in self:
            pass
        if self._result is None:
            raise FitFailed("This fit was stopped before its end; start it again.")
        return self._result

    def close(self) -> None:
        """Cancels what is left."""
        self._steps.close()


def to_its_end(
    run: Callable[Given, FitRun[Step, Result]], name: str, returns: object, doc: str
) -> Callable[Given, Result]:
    """A function of the same arguments as `run`, that returns the result of its FitRun."""

    @wraps(run)
    def ended(*args: Given.args, **kwargs: Given.kwargs) -> Result:
        return run(*args, **kwargs).result()

    ended.__name__, ended.__qualname__, ended.__doc__ = name, run.__qualname__.replace(run.__name__, name), doc
    ended.__annotations__ = run.__annotations__ | {"return": returns}
    ended.__signature__ = inspect.signature(run).replace(return_annotation=returns)  # type: ignore[attr-defined]  # PEP 362
    return ended


def iterates(
    scan: "ScanLike | ScanSource",
    landmarks: Landmarks = None,
    *,
    certain: Sequence[str] = (),
    marks: Mapping[str, ArrayLike] = NOTHING,
    length: tuple[str, str, float] | None = None,
    units: str = "auto",
    stance: str = "auto",
    preset: Preset = "default",
    drawing: str | None = FIRST,
    tumours: Sequence[str] = (),
    refine: bool = True,
    start: Fit | Parameters | None = None,
    locked: Sequence[str] = (),
    model: Model = None,
    prior: str | Path | None = None,
    lesions: Sequence[str | Path | bytes] = (),
) -> FitRun[Iterate, Fit]:
    """A fit as an iterator of `Iterate` objects, each with its vertices (V, 3) in the scan's unit and frame::

        run = breastrig.iterates("scan.ply")
        for iterate in run:
            print(iterate.iteration, iterate.mean_distance_mm)
        fit = run.result()

    Arguments and errors are those of `fit`.  Everything up to the first iteration is done by this call; leaving the
    loop cancels the fit.
    """
    clock = Clock()
    source = scan if isinstance(scan, ScanSource) else ScanSource(scan, units, lesions=lesions)
    picks = landmarks_in_mm(landmarks, source, certain, marks)
    with one_thread():
        rig = with_cohort(model, prior)
        settings = FitSettings(
            stance=stance,
            preset=preset,
            drawing="+".join([*filter(None, [drawing]), *(tumour_text(short) for short in tumours)]) or None,
            landmark_confidence=picks.confidence,
            certain=picks.certain,
            marks_mm=picks.marks_mm,
            open_names=picks.open_names,
            length=length_of(length),
            refine=refine,
            earlier=_earlier(start, stance, rig),
            locked=tuple(locked),
        )
        plan = fit_plan(settings, rig, picks.points_mm)
        check_prior(plan.recipe, prior)
        read, clock.seconds["read"] = source.read()
        ready = prepare_fit(plan, read, clock)
    own = preset if isinstance(preset, str) and preset.endswith(".toml") else None  # a preset of the user's
    places = landmarks if isinstance(landmarks, str | Path) else None
    files = (source.file, places, own, *source.lesion_files)
    inputs = (*(Path(file) for file in files if file is not None), *files_of(model, prior))

    def steps() -> Generator[Iterate, None, Fit]:
        for step in fit_steps(ready, clock):
            if isinstance(step, FitOutcome):
                return fit_of_outcome(step, inputs)
            yield _iterate_of(step, ready)
        raise AssertionError("a fit ends with its outcome")

    return FitRun(steps(), ready.hypothesis.task.recipe.iterations_limit)


fit = to_its_end(
    iterates,
    "fit",
    Fit,
    """Fits the model to one scan, and returns a `Fit` with everything in the scan's unit and frame; writes nothing.

Args:
    scan: From `read_scan`, the path of a file, or a trimesh.Trimesh.
    landmarks: Name -> (3,) place in the scan's unit and frame, or a `Proposal`; or the path of a landmark file
        (JSON, CSV, .pp, .mrk.json, .fcsv, .pts); None: the scan alone decides.
    certain: Names of landmarks that are always followed, besides those that the file names so.
    marks: Name -> (3,) place on the skin in the scan's unit and frame: moles, dots, ends of pen lines, under any names,
        besides those of the file.  `transfer` follows those that both scans have.
    length: ("nipple_L", "suprasternal_notch", 187.0), two landmarks or marks and the straight way between them in mm,
        as measured on the patient: the scan is scaled to it about its frame's origin, and all of the result is in that
        size (`fit.result["scale"]`).  None: the scan has its true size.
    units: Of a path: auto, m, dm, cm, mm, in, ft.
    stance: auto, standing, supine or prone (of an MRI).
    preset: default, paper, the path of a TOML file, or a dict of what differs from the default or from
        "base", another preset: {"scales": {"sigma": 0.1}, "stages": {"settle": {"iterations": 5}}}
        (`breastrig presets show default` has the names).
    drawing: first: the model's first drawing, if it has any (the torso's: lumpectomy); one by its name (anatomy,
        mastectomy), a pattern in mm (reduction:areola_mm=42), several joined by +, or None.  A pattern that does
        not fit on this patient is left out, and `fit.drawing_missing` says why.
    tumours: Circles on the skin, in mm: "L:10,45,12" (side: hour, distance from the nipple, radius), or
        "at:X,Y,Z,RADIUS" around a place in the scan's frame.
    refine: Whether a smooth free-form layer follows the skin that the scan shows; the model's own distances are in
        `fit.result["model_alone"]`.
    start: A `Fit` of the same scan, or `Parameters` in its unit and frame, to go on from; None: it is found.
    locked: Blocks that stay where they start: scales, shapes, rotations, translations, the name of a bone or a
        shape, or one part of a bone (lumbar.scale).
    model: From `load_model`, or the path of a .glb; None: the torso of the package.
    prior: A file of `breastrig cohort`, of fits with this model; None: the built-in prior.
    lesions: Files of lesions that were drawn on the image that `scan` is (NIfTI, NRRD, DICOM SEG, RTSTRUCT). Where one
        leaves something open, `Scan.with_lesions` takes the answer.

Raises:
    BadInput: BadScan, BadLandmarks, BadDrawing, BadModel or BadSettings, for what can be mended.
    FitFailed: When the fit fails.
    """,
)


def _earlier(start: Fit | Parameters | None, stance: str, rig: Rig) -> EarlierFit | None:
    """The fit to continue from; BadSettings for one of another rig."""
    if start is None:
        return None
    x = in_metres(rig, start.parameters if isinstance(start, Fit) else start)
    stance = start.stance if isinstance(start, Fit) else stance
    if stance == AUTO:
        raise BadSettings("Parameters do not say the stance that they are of; give stance as well.")
    return EarlierFit(stance, node_poses(rig, x), rig.sha256)


def _iterate_of(step: RecordedIterate, ready: ReadyScan) -> Iterate:
    """A recorded iterate for programs."""
    event = step.event
    return Iterate(
        iteration=event.iteration,
        stage=event.stage,
        energy=event.energy,
        mean_distance_mm=event.mean_distance_mm,
        landmark_distance_mm=event.landmark_distance_mm,
        coverage=event.coverage,
        elapsed_s=event.elapsed_s,
        model=public(ready.plan.rig),
        in_metres=step.iterate.parameters,
        metres_per_unit=ready.scan.metres_per_unit,
    )

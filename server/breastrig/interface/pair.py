"""Two stances of one patient fitted together, with bodies held alike: as a stream of iterates, or at once."""

import json
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadInput
from breastrig.core.output_files import Output, OutputSet, all_or_nothing
from breastrig.core.private_files import read_ordinary, write_files
from breastrig.files.result import RESULT, fit_set
from breastrig.fitting.two_stances import ALIKE, ONE_BODY
from breastrig.interface.fit_result import Fit, fit_of_outcome
from breastrig.interface.landmarks import Landmarks
from breastrig.interface.model import Model, files_of, loaded, with_cohort
from breastrig.interface.one_thread import one_thread
from breastrig.interface.run import FitRun, GivenScan, Iterate, Preset, Settings, iterate_of
from breastrig.interface.scan import ScanLike, ScanSource
from breastrig.workflow.jobs import FIRST
from breastrig.workflow.run_pair import PAIR_SCHEMA, PairOutcome, pair_document, pair_steps, prepare_pair
from breastrig.workflow.scan_fit import Clock, check_prior

PAIR = "pair.json"
FOLDERS = ("first", "second")
PAIR_BYTES = 1_000_000  # a pair.json has some thousand
PAIR_SETS = (*(fit_set(Path(name)) for name in FOLDERS), OutputSet(Path(), (PAIR,), PAIR, PAIR_SCHEMA))


@dataclass(frozen=True, eq=False)
class FitPair:
    """Two fits of one patient; each is in the unit and frame of its own scan."""

    first: Fit
    second: Fit
    document: dict[str, Any] = field(repr=False)  # of pair.json: what the two have in common

    def save(self, folder: str | Path, *, force: bool = False) -> None:
        """Writes what `breastrig fit --with` writes: first/ and second/ as `Fit.save` does, and pair.json.

        All of it or nothing; `force` and errors as in `Fit.save`.
        """
        output = Output(Path(folder), PAIR_SETS, (*self.first.inputs, *self.second.inputs), force)
        with all_or_nothing(output) as staging:
            self.write(staging)

    def write(self, folder: Path) -> None:
        """Writes the files into a folder that is the caller's to protect.  Raises BadInput."""
        for name, fit in zip(FOLDERS, (self.first, self.second), strict=True):
            fit.write(folder / name)
        write_files({PAIR: json_bytes(self.document)}, folder)

    @staticmethod
    def load(folder: str | Path, model: Model = None) -> "FitPair":
        """What `save` or `breastrig fit --with` wrote; each fit in its scan's unit and frame.  Raises BadInput."""
        place, rig = Path(folder), loaded(model)
        try:
            document = json.loads(read_ordinary(place / PAIR, PAIR_BYTES))
        except (OSError, ValueError, AttributeError, RecursionError) as error:
            raise BadInput(
                f"There is no pair of fits in {place.name[:100]}; give a folder that `breastrig fit --with` wrote."
            ) from error
        return FitPair(Fit.load(place / FOLDERS[0], rig), Fit.load(place / FOLDERS[1], rig), document)


def pair_iterates(
    first: ScanLike,
    second: ScanLike,
    landmarks: Landmarks = None,
    second_landmarks: Landmarks = None,
    *,
    certain: Sequence[str] = (),
    second_certain: Sequence[str] = (),
    units: str = "auto",
    second_units: str = "auto",
    stance: str = "auto",
    second_stance: str = "auto",
    preset: Preset = "default",
    drawing: str | None = FIRST,
    tumours: Sequence[str] = (),
    refine: bool = True,
    alike: bool = True,
    model: Model = None,
    prior: str | Path | None = None,
) -> FitRun[tuple[Iterate, Iterate], FitPair]:
    """As `fit_pair`, as an iterator of two `Iterate`s at a time, each in its scan's unit and frame; see `iterates`."""
    clock = Clock()
    coupling = ALIKE if alike else ONE_BODY
    settings = [Settings(each, preset, drawing, tuple(tumours), refine) for each in (stance, second_stance)]
    given = (
        GivenScan(ScanSource(first, units), landmarks, certain),
        GivenScan(ScanSource(second, second_units), second_landmarks, second_certain),
    )
    with one_thread():
        rig = with_cohort(model, prior)
        plans = given[0].plan(settings[0], rig), given[1].plan(settings[1], rig)
        check_prior(plans[0].recipe, prior)
        ready = prepare_pair(plans, [each.scan.read() for each in given])
    inputs = (
        *given[0].files,
        *given[1].files,
        *settings[0].files,
        *files_of(model, prior),
    )

    def steps() -> Generator[tuple[Iterate, Iterate], None, FitPair]:
        for step in pair_steps(ready, coupling, clock):
            if isinstance(step, PairOutcome):
                fits = fit_of_outcome(step.first, inputs), fit_of_outcome(step.second, inputs)
                places = [f"{name}/{RESULT}" for name in FOLDERS]
                return FitPair(*fits, pair_document(rig, [each.in_metres.result for each in fits], places, coupling))
            yield iterate_of(step[0], ready[0]), iterate_of(step[1], ready[1])
        raise AssertionError("a fit ends with its outcome")

    return FitRun(steps(), ready[0].task.recipe.iterations_limit)


def fit_pair(
    first: ScanLike,
    second: ScanLike,
    landmarks: Landmarks = None,
    second_landmarks: Landmarks = None,
    *,
    certain: Sequence[str] = (),
    second_certain: Sequence[str] = (),
    units: str = "auto",
    second_units: str = "auto",
    stance: str = "auto",
    second_stance: str = "auto",
    preset: Preset = "default",
    drawing: str | None = FIRST,
    tumours: Sequence[str] = (),
    refine: bool = True,
    alike: bool = True,
    model: Model = None,
    prior: str | Path | None = None,
) -> FitPair:
    """Fits two scans of one patient in two stances together; each `Fit` is in its own scan's unit and frame.

    Their bodies (the bones' scales, the shapes) are held alike, for chests flatten when lying.  `alike=False` gives
    both one body instead, which is better only where the body keeps its shape (docs/decisions/0007 has figures).
    The other arguments are those of `fit`; those whose names begin with `second` are of the second scan,
    drawing, tumours, preset and model of both.  Nothing is written.

    Raises what `fit` raises, and BadScan when both scans are the same file.
    """
    return pair_iterates(
        first,
        second,
        landmarks,
        second_landmarks,
        certain=certain,
        second_certain=second_certain,
        units=units,
        second_units=second_units,
        stance=stance,
        second_stance=second_stance,
        preset=preset,
        drawing=drawing,
        tumours=tumours,
        refine=refine,
        alike=alike,
        model=model,
        prior=prior,
    ).result()

"""A patient in a stance that was not scanned, for programs."""

from collections.abc import Generator
from contextlib import ExitStack
from pathlib import Path

from breastrig.core.private_files import write_files
from breastrig.core.scratch import scratch_folder
from breastrig.core.stances import Stance
from breastrig.interface.fit_result import Fit
from breastrig.interface.model import Model, loaded
from breastrig.interface.run import FitRun
from breastrig.interface.transfer import folder_of
from breastrig.volume.gravity.simulated import Progress
from breastrig.workflow.predictions.predict import predict_steps

MOST = 12  # parts that are said, with all that can be asked


def predict(
    fit: Fit | str | Path,
    stance: Stance,
    model: Model = None,
    *,
    other: Fit | str | Path | None = None,
    simulate: bool = False,
) -> Fit:
    """The patient of a fit, or of its folder, as she would be in another `stance`: standing, supine or prone.

    Its trunk stays in the scan's unit and frame; `uncertainty` (V,) holds the true place with 90 %, prediction and
    fit together.  Its result says `predicted`; drawings are transferred to it as to a fit.  `simulate`: her own
    breasts are solved by finite elements, which takes minutes; `other`, a fit of the same patient in a further stance,
    says how stiff they are.  `model` is that of folders.  Raises BadInput, also for a model of which nobody knows
    what gravity does to it; BreastRigError where her breasts do not come to rest.
    """
    return predicting(fit, stance, model, other=other, simulate=simulate).result()


def predicting(
    fit: Fit | str | Path,
    stance: Stance,
    model: Model = None,
    *,
    other: Fit | str | Path | None = None,
    simulate: bool = False,
) -> FitRun[Progress, Fit]:
    """The same as an iterator of `Progress`, with the `share` that is done and what is `said` of the next part.

    The fit that it ends with is in the scan's unit and frame; arguments and errors are those of `predict`.
    """
    rig = fit.model if isinstance(fit, Fit) else loaded(model)

    def steps() -> Generator[Progress, None, Fit]:
        with ExitStack() as stack:
            folder = stack.enter_context(folder_of(fit, with_drawing=True))
            second = None if other is None else stack.enter_context(folder_of(other, with_drawing=False))
            made = stack.enter_context(scratch_folder())
            write_files((yield from predict_steps(rig, folder, stance, simulate, second)), made)
            return Fit.load(made, rig)

    return FitRun(steps(), MOST)

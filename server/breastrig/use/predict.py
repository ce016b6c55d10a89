"""A patient in a stance that was not scanned, for programs."""

from pathlib import Path

from breastrig.core.one_thread import one_thread
from breastrig.core.private_files import write_files
from breastrig.core.scratch import scratch_folder
from breastrig.core.stances import Stance
from breastrig.use.predictions.predict import prediction
from breastrig.use.transfer import READ, folder_of
from breastrig.use.values.fit_result import Fit
from breastrig.use.values.model import Model, loaded


def predict(fit: Fit | str | Path, stance: Stance, model: Model = None) -> Fit:
    """The patient of a fit, or of its folder, in another `stance`: standing, supine or prone.

    The trunk stays in the scan's unit and frame; `uncertainty` (V,) holds the true place with 90 %, prediction and
    fit together.  The result says `predicted`; drawings are transferred to it as to a fit.  `model` is that of
    folders.  Raises BadInput, also for a model of which nobody knows what gravity does to it.
    """
    rig = fit.model if isinstance(fit, Fit) else loaded(model)
    with one_thread(), folder_of(fit, (*READ, "drawing.json")) as folder, scratch_folder() as made:
        write_files(prediction(rig, folder, stance), made)
        return Fit.load(made, rig)

"""Landmarks proposed from the scan alone: a fit without any, its landmarks laid on the skin, an error each.

The error is the radius that holds the true place with 90 %, from the posterior of that very fit (uncertainty/radii.py):
it knows which part of the body the scan shows, that a navel on a slim belly slides, and that a body whose orientation
was not clear may lie the other way round.  The confidence is 1 / (1 + (e / 10 mm)²) with the root mean square error e
that belongs to that radius.
"""

from dataclasses import dataclass, replace

import numpy as np

from breastrig.colour.areolae import ObservedAreola
from breastrig.core.arrays import Array
from breastrig.fitting.fit import FitTask
from breastrig.fitting.hypotheses import ScanOrientation, orientation_task, scan_orientation
from breastrig.fitting.observed.landmarks import areola_of, colour_observations, with_observations
from breastrig.fitting.posterior import Posterior, laid_on_scan, to_skin
from breastrig.fitting.prepare_scan import PreparedScan
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.solve import iterates_with_second_start
from breastrig.fitting.uncertainty.radii import HOLDS_90, radii
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.scan.scan import Scan

USEFUL = 0.01  # m; a proposal this far off still saves the user a search: confidence one half
LEAST = 0.01  # confidence; 0.1 m off, which no longer pulls at anything
UNKNOWN = 0.02  # m, error with models of which nobody knows how far bodies are from them


def expected_error(confidence: float) -> float:
    """m, how far off a landmark of this confidence (0 to 1) is expected to be: 1 is a person's own pick."""
    return USEFUL * float(np.sqrt(1.0 / max(confidence, LEAST) - 1.0))


@dataclass(frozen=True, eq=False)
class Proposal:
    """A proposed landmark."""

    point: Array  # (3,) m, in the scan's frame
    confidence: float  # 0 to 1
    on_scan: bool  # on skin that the scan shows
    error: float | None = None  # m, radius that holds the true place with 90 %; None: nobody knows it for this model
    reason: str | None = None  # what shows it beside the form of the body, in a few words
    areola: ObservedAreola | None = None  # around a nipple that colour shows
    to_skin: float = 0.0  # m, to the nearest of the scan's vertices


def confidence_of(error: float) -> float:
    """0 to 1, the inverse of `expected_error`: of a landmark that is expected to be `error` m off."""
    return 1.0 / (1.0 + (error / USEFUL) ** 2)


def propose_landmarks(
    rig: Rig,
    scan: PreparedScan,
    recipe: Recipe,
    orientation: ScanOrientation | None = None,
    coloured: Scan | None = None,
) -> dict[str, Proposal]:
    """All landmarks of the rig on a scan, those too that it does not show; `orientation` when it is known already.

    `coloured` is the scan as it was read, of which only the colours are looked at (observed/landmarks.py).
    """
    if orientation is None:
        orientation, _, _ = scan_orientation(rig, scan, recipe)
    task = orientation_task(rig, scan, orientation, recipe)
    if orientation.fitted is None:
        ended, fitted = _fitted(task)
    else:
        ended, fitted = replace(task, hanging=orientation.hanging), orientation.fitted
    shown = {} if coloured is None else colour_observations(ended, fitted, orientation.margin, coloured)
    if shown:
        ended, fitted = _fitted(with_observations(task, shown, fitted))
    posterior = Posterior(ended, fitted)
    places, on_scan = laid_on_scan(posterior, {name: each.place for name, each in shown.items()})
    known = radii(posterior, orientation.margin, expected=True)
    proposals = {}
    for k, name in enumerate(rig.landmark_names):
        if name in shown:
            each = shown[name]
            sure = round(confidence_of(each.error), 2)
            proposals[name] = Proposal(each.place, sure, True, HOLDS_90 * each.error, each.reason, areola_of(each))
            continue
        observation = posterior.relief.get(name)
        radius = None if known is None else known.landmarks[name]
        confidence = confidence_of(UNKNOWN if radius is None else radius / HOLDS_90)
        reason = None if observation is None else observation.reason
        sure, away = round(confidence, 2), to_skin(scan.target, places[k])
        proposals[name] = Proposal(places[k], sure, bool(on_scan[k]), radius, reason, to_skin=away)
    return proposals


def _fitted(task: FitTask) -> tuple[FitTask, RigParameters]:
    """The task with what its fit saw of the skin's hollows, and where it ends."""
    *_, last = iterates_with_second_start(task)
    return replace(task, relief=last.relief, hanging=last.hanging), last.parameters

"""What a fit is asked and what it answers: one task in, a stream of frozen iterates out."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.recipe import Recipe
from breastrig.least_squares.newton import Status
from breastrig.relief.observe import ReliefObservation
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters


@dataclass(frozen=True)
class Doubt:
    """Picks that belong together in one question, and why they are asked about, as a sentence."""

    names: tuple[str, ...]
    reason: str
    followed: bool = False  # True: unusual, but followed all the same
    exchanged: bool = False  # left and right of these look exchanged


@dataclass(frozen=True, eq=False)
class FitIterate:
    """One state of a fit, in the scan's frame (m)."""

    iteration: int  # 0 is the start
    stage: str
    parameters: RigParameters
    energy: float
    mean_distance: float  # m, over the accepted matches; nan when there are none
    coverage: float  # share of the model's vertices with an accepted match
    landmark_distance: float | None  # m, mean over the picked landmarks
    elapsed_s: float
    status: Status  # RUNNING on all but the last
    not_followed: tuple[Doubt, ...] = ()  # rejected picks
    relief: Mapping[str, ReliefObservation] | None = (
        None  # landmarks that the skin's form shows; None: not looked at yet
    )
    hanging: tuple[str, ...] = ()  # shapes by which breasts were seen to hang

    @property
    def is_finite(self) -> bool:
        """Whether there is a model on skin: False where the fit broke down or found none."""
        return self.status is not Status.NOT_FINITE and bool(np.isfinite(self.mean_distance))


@dataclass(frozen=True, eq=False)
class FitTask:
    """What is to be fitted to what."""

    rig: Rig
    target: ScanTarget
    start: RigParameters
    recipe: Recipe
    landmarks: dict[str, Array]  # name -> (3,) m, in the scan's frame
    stance: str = "standing"  # standing | supine | prone
    landmark_errors: Mapping[str, float] = field(default_factory=dict)  # m, expected beyond a click's; absent: none
    certain: frozenset[str] = frozenset()  # picks that are followed whatever all else says
    from_colour: frozenset[str] = frozenset()  # landmarks observed in the scan's colours, not picked
    relief: Mapping[str, ReliefObservation] | None = (
        None  # what the skin's form shows, where a fit has looked; None: it will
    )
    hanging: tuple[str, ...] = ()  # shapes by which breasts were seen to hang (body/hanging_start.py)
    locked: tuple[str, ...] = ()  # blocks of the unknowns that stay where they start, see rig/blocks.py

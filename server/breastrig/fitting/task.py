"""Input and output of a fit: one task in, a stream of frozen iterates out."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.energies.landmarks import LandmarkObservation
from breastrig.fitting.recipe import Recipe
from breastrig.least_squares.newton import Status
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters


@dataclass(frozen=True)
class PickIssue:
    """An issue with one or several picks: the names, and the reason as a sentence."""

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
    not_followed: tuple[PickIssue, ...] = ()  # rejected picks
    relief: Mapping[str, LandmarkObservation] | None = None  # that the skin's form shows; None: not looked at yet
    hanging: tuple[str, ...] = ()  # shapes by which breasts were seen to hang

    @property
    def is_finite(self) -> bool:
        """Whether there is a model on skin: False where the fit broke down or found none."""
        return self.status is not Status.NOT_FINITE and bool(np.isfinite(self.mean_distance))


@dataclass(frozen=True, eq=False)
class FitTask:
    """The input of a fit: rig, scan, start, recipe and observations."""

    rig: Rig
    target: ScanTarget
    start: RigParameters
    recipe: Recipe
    given: Mapping[str, LandmarkObservation]  # by name: picked, or seen in the scan's colours
    stance: str = "standing"  # standing | supine | prone
    relief: Mapping[str, LandmarkObservation] | None = None  # what the skin's form shows; None: the fit will look
    hanging: tuple[str, ...] = ()  # shapes by which breasts were seen to hang (body/hanging.py)
    locked: tuple[str, ...] = ()  # blocks of the unknowns that stay where they start, see rig/blocks.py

    landmarks: dict[str, Array] = field(init=False)  # name -> (3,) m of the given landmarks
    picked: frozenset[str] = field(init=False)  # the names of those that a person has placed
    certain: frozenset[str] = field(init=False)  # the names of those that are always followed

    def __post_init__(self) -> None:
        given = self.given.items()
        object.__setattr__(self, "landmarks", {name: each.place for name, each in given})
        object.__setattr__(self, "picked", frozenset(name for name, each in given if each.source == "pick"))
        object.__setattr__(self, "certain", frozenset(name for name, each in given if not each.outlier))

    def beyond_click(self, name: str) -> float:
        """Error (m, each axis) of the given landmark of this name beyond a click's."""
        return float(np.sqrt(max(np.trace(self.given[name].covariance) / 3.0 - self.recipe.observed.landmark**2, 0.0)))

    def without(self, names: Collection[str]) -> "FitTask":
        """The task without these landmarks."""
        return replace(self, given={name: each for name, each in self.given.items() if name not in names})

    def with_picks(
        self, landmarks: Mapping[str, Array], unsure: Mapping[str, float] | None = None, certain: Collection[str] = ()
    ) -> "FitTask":
        """The task with a person's picks, (3,) m by name, given; `unsure`: m, expected error beyond a click's."""
        click, odds = self.recipe.observed.landmark, self.recipe.outliers.anywhere
        given = {
            name: LandmarkObservation(
                name,
                np.asarray(place),
                (click**2 + (unsure or {}).get(name, 0.0) ** 2) * np.eye(3),
                outlier=0.0 if name in certain else odds,
            )
            for name, place in landmarks.items()
        }
        return replace(self, given=given)


def without(task: FitTask, doubts: Sequence[PickIssue]) -> FitTask:
    """The task without the rejected picks."""
    return task.without({name for doubt in doubts if not doubt.followed for name in doubt.names})


def ended(task: FitTask, last: FitIterate) -> FitTask:
    """The task as its fit ended: without the rejected picks, with the relief observations."""
    return replace(without(task, last.not_followed), relief=last.relief, hanging=last.hanging)

"""Reasons as sentences: what was found and what to do about it, without advice that was given or followed before."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.fitting.starts.orientation import MIN_LANDMARKS
from breastrig.fitting.task import PickIssue
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import face_normals
from breastrig.rig.model import Rig
from breastrig.rig.near_breasts import OUTSIDE, near_breasts
from breastrig.scan.piece import BallInside

VOUCHING = 6  # landmarks; 36 random sets of 6 to 12 on what is no torso leave no line known, 1 of 20 of 4 does (0022)
LOOK_AGAIN = "look at what is asked about {}"


@dataclass(frozen=True)
class GivenLandmarks:
    """Counts of a rig's landmarks that a person has given."""

    picked: int  # not those that were only agreed to
    left: int  # of the others those that the scan shows
    followed: int  # as observations
    agreed: int = 0  # proposed, and only agreed to
    repeated: bool = False  # those that are followed lie where they were proposed

    @property
    def placed(self) -> bool:
        """Whether these landmarks determined the start."""
        return self.followed >= MIN_LANDMARKS

    @property
    def on_their_own(self) -> bool:
        """Whether they have placed it and are more than what the program has proposed."""
        return self.placed and not self.repeated

    @property
    def vouch(self) -> bool:
        """Whether so many of them lie as on a torso: on what is none they would scatter, and lines not be known."""
        return self.on_their_own and self.followed >= VOUCHING

    @property
    def advice(self) -> str:
        """The advice on landmarks to place; empty where none is left."""
        if not self.left:
            return ""
        return f"place {'more' if self.picked >= MIN_LANDMARKS else 'at least three'} landmarks by hand"


@dataclass(frozen=True)
class Reason:
    """One sentence without its end."""

    fact: str
    advice: tuple[str, ...] = ()  # one or the other; empty ones do not count
    note: bool = False  # said of a good fit, too

    def without(self, given: Iterable[str]) -> "Reason":
        """The reason without advice that was given before."""
        return replace(self, advice=tuple(each for each in self.advice if each and each not in given))

    def __str__(self) -> str:
        return f"{'; '.join(filter(None, (self.fact, ', or '.join(filter(None, self.advice)))))}."


def sentences(reasons: Sequence[Reason]) -> tuple[str, ...]:
    """The reasons in their order; advice stands where it is given first."""
    given: set[str] = set()
    said = []
    for reason in reasons:
        said.append(str(reason.without(given)))
        given |= set(reason.advice)
    return tuple(said)


def of_agreed(given: GivenLandmarks) -> tuple[Reason, ...]:
    """A note that landmarks keep the error of their proposals."""
    if not given.agreed:
        return ()
    one = "One landmark was only agreed to where it was proposed; it keeps the proposal's error"
    more = f"{given.agreed} landmarks were only agreed to where they were proposed; they keep the proposals' errors"
    return (Reason(one if given.agreed == 1 else more, note=True),)


def of_doubts(doubts: Sequence[PickIssue], far: Collection[str] = ()) -> tuple[Reason, ...]:
    """The number of questioned landmarks, as a note where all are `far` from the plan's region.

    Each doubt has its own sentence, which names them.
    """
    exchanged = sum(len(doubt.names) for doubt in doubts if doubt.exchanged)
    others = sum(len(doubt.names) for doubt in doubts if not doubt.exchanged)
    parts = [f"{exchanged} landmarks look exchanged between left and right"] if exchanged else []
    if others:
        count = "one landmark is" if others == 1 else f"{others} landmarks are"
        parts.append(f"{count} in doubt")
    fact = ", and ".join(parts)
    which = "it" if exchanged + others == 1 else "them"
    note = not exchanged and all(name in far for doubt in doubts for name in doubt.names)
    return (Reason(fact[:1].upper() + fact[1:], (LOOK_AGAIN.format(which),), note),) if parts else ()


REPEATED = 0.002  # m; at least three true picks of each of 92 parts lie farther from proposals, 3 mm: of all but 3


def picked_names(picks: Mapping[str, Array], proposed: Mapping[str, Array]) -> frozenset[str]:
    """Names of the picks ((3,) m each) that are not where they were proposed."""
    return frozenset(
        name
        for name, place in picks.items()
        if name not in proposed or float(np.linalg.norm(place - proposed[name])) > REPEATED
    )


COMPARE = ("compare model and scan",)


def of_lesions(rig: Rig, vertices: Array, lesions: Sequence[BallInside]) -> tuple[tuple[Reason, ...], bool]:
    """(reasons, whether a lesion lies outside) for the (V, 3) m fitted skin: then the fit lies elsewhere."""
    if not lesions:
        return (), False
    centers = np.array([each.center for each in lesions])
    nearest = ClosestPointSearch(vertices, rig.faces).query(centers)
    above = np.einsum("li,li->l", centers - nearest.points, face_normals(vertices, rig.faces)[nearest.faces])
    outside = (above > 0.0) & (nearest.distances > OUTSIDE)
    is_near: Booleans = np.any(near_breasts(rig)[rig.faces[nearest.faces]], axis=1)
    reasons = [
        Reason(f"{each.name} lies {1e3 * distance:.0f} mm outside the fitted skin", COMPARE)
        for each, distance, out in zip(lesions, nearest.distances, outside, strict=True)
        if out
    ]
    reasons += [
        Reason(f"{each.name} lies far from the breasts of the fitted model", COMPARE)
        for each, near, out in zip(lesions, is_near, outside, strict=True)
        if not near and not out
    ]
    return tuple(reasons), bool(outside.any())

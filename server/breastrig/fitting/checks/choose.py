"""Landmarks whose check by a person would narrow lines most, chosen one after another from a fit's posterior.

An observed landmark adds its information to a Gaussian and takes away what it replaces (Woodbury); how much lines
narrow follows without a fit. Each next landmark is the one that leaves the least mean square radius (greedy choice for
the trace of a covariance: A-optimal design), each observed as well as bodies have it where the model has it: one that
lies anywhere on bodies says little of lines. The width that is stated after it is the fit's, which follows a pick
exactly: line_error_mm with the radii of uncertainty/radii.py. docs/decisions/0032 says what checks are worth.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from scipy.linalg import block_diag

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.drawings.line_error import FINGER, across, fingers

MOST = 3  # landmarks that a person is asked to look at
WORTH = 0.0005  # m; what narrows the lines by less is not asked for: the number that is shown stays the same


@dataclass(frozen=True, eq=False)
class Gaussian:
    """Where L landmarks and N vertices lie, together; m²."""

    landmarks: Array  # (3 L, 3 L)
    cross: Array  # (N, 3, 3 L), of each vertex with the landmarks
    vertices: Array  # (N,), variance over all three axes

    def with_information(self, added: Array) -> "Gaussian":
        """With this (3 L, 3 L) 1/m² information on the landmarks added; negative parts take information away."""
        gain = added @ np.linalg.inv(np.eye(len(added)) + self.landmarks @ added)
        left = self.cross @ gain
        landmarks = self.landmarks - self.landmarks @ gain @ self.landmarks
        return Gaussian(
            0.5 * (landmarks + landmarks.T),
            self.cross - left @ self.landmarks,
            np.maximum(self.vertices - np.einsum("nij,nij->n", left, self.cross), 0.0),
        )


@dataclass(frozen=True, eq=False)
class Observable:
    """What a fit knows of its L landmarks beside the posterior: which can be checked, and what a pick would tell."""

    names: tuple[str, ...]  # (L)
    open: Booleans  # (L,) the scan shows it, and nobody has picked it
    pick: float  # 1/m² on each axis, of a person's pick
    replaced: Array  # (L, 3, 3) 1/m², what else was observed of each and a pick replaces
    partners: Mapping[int, tuple[int, float]]  # of each that tells of its partner: which, and 1/m² on each axis
    beside: Array  # (L, 3, 3) m², of bodies' landmarks beside the model's

    def picked(self, index: int) -> tuple["Observable", Array, Array]:
        """What is left to check after this pick; the (3 L, 3 L) 1/m² that it adds, as fits count it, and on bodies."""
        added, replaced, still = np.zeros_like(self.replaced), self.replaced.copy(), self.open.copy()
        added[index] = self.pick * np.eye(3) - replaced[index]
        replaced[index], still[index] = 0.0, False
        partner, shared = self.partners.get(index, (index, 0.0))
        added[partner] += shared * np.eye(3)
        replaced[partner] += shared * np.eye(3)
        left = {which: each for which, each in self.partners.items() if index not in (which, each[0])}
        on_bodies = added.copy()
        on_bodies[index] += np.linalg.inv(np.eye(3) / self.pick + self.beside[index]) - self.pick * np.eye(3)
        return replace(self, open=still, replaced=replaced, partners=left), block_diag(*added), block_diag(*on_bodies)


@dataclass(frozen=True, eq=False)
class ModelLine:
    """A line as M places on the triangles of N vertices, or a part of the skin on which lines are drawn."""

    corners: Integers  # (M, 3), of the N or of the model
    shares: Array  # (M, 3), barycentric
    times: Array | float = 1.0  # (M,) of the vertices' radii
    beyond: Array | float = 0.0  # (M,) m², what squares of radii have from elsewhere

    def radii(self, vertices: Array) -> Array:
        """(M,) m, from the vertices' (N,) m."""
        here = self.times * np.einsum("mc,mc->m", self.shares, vertices[self.corners])
        return np.asarray(np.sqrt(here**2 + self.beyond))


@dataclass(frozen=True, eq=False)
class Widths:
    """Radii of lines from variances: (N,) of the vertices."""

    lines: Sequence[ModelLine]
    factors: Array  # (N,) from deviations to radii
    lost: Array | float = 0.0  # m, radii for the chance that the body lies another way, which no landmark here settles

    def radii(self, variances: Array) -> list[Array]:
        """(M,) m of each line, from (N,) m²."""
        vertices = np.hypot(self.factors * np.sqrt(variances), self.lost)
        return [line.radii(vertices) for line in self.lines]


@dataclass(frozen=True)
class Check:
    """A landmark to look at."""

    index: int
    width: float  # m, the lines' error (90 %, across) that is expected after it and those before


def widest(radii: Sequence[Array]) -> float:
    """m, the largest line error (90 %, across) of these radii."""
    return max(across(each) for each in radii)


def mean_square(radii: Sequence[Array]) -> float:
    """m², over the places of all lines."""
    return float(np.mean(np.square(np.concatenate(radii))))


def next_checks(known: Gaussian, observable: Observable, widths: Widths) -> Iterator[Check]:
    """The landmarks that narrow the lines most, each after those before, as long as there are any."""
    on_bodies = known
    while observable.open.any():
        ways = []
        for index in np.flatnonzero(observable.open).tolist():
            left, added, as_seen = observable.picked(index)
            after = on_bodies.with_information(as_seen)
            ways.append((mean_square(widths.radii(after.vertices)), index, left, added, after))
        _, index, observable, added, on_bodies = min(ways, key=lambda way: way[:2])
        known = known.with_information(added)
        yield Check(index, widest(widths.radii(known.vertices)))


@dataclass(frozen=True)
class Checks:
    """The landmarks to be asked about, and whether asking pays."""

    width: float  # m, the lines' error now
    asked: tuple[Check, ...]
    worth_it: bool  # they narrow the lines by at least one finger


def asked_checks(now: float, steps: Iterator[Check]) -> Checks:
    """The first of `steps` that are worth a look, at most MOST: no more than gain fingers, or else half a millimetre.

    now: m, the lines' error.
    """
    asked = tuple(islice(steps, MOST))
    widths = [now, *(each.width for each in asked)]
    gained = [fewer_fingers(now, width) for width in widths]
    enough = gained.index(max(gained)) or next(k for k, width in enumerate(widths) if width - widths[-1] < WORTH)
    return Checks(now, asked[:enough], any(gained))


def fewer_fingers(before: float, after: float) -> int:
    """By how many fingers lines are surer that were `before` off and are `after` (m): as marked, or as wide."""
    return max(fingers(before) - fingers(after), int((before - after) // FINGER), 0)

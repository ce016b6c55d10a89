"""A polyline on a scan: the one type from reading and fitting to files, transfers and reports.

Its form in files and on the wire is `drawings/drawing_schema.py`; `drawings/drawing_file.py` turns one into the other.
A line on the *model* is another thing (`rig.model.DrawnShape`): it has places of the mesh and no positions.
"""

from collections.abc import Iterable, Sized
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Self

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers, frozen


@dataclass(frozen=True, eq=False)
class Polyline:
    """P points, at least one; its frame is that of a scan unless its maker states another."""

    name: str
    closed: bool  # the last point is joined to the first
    color: str  # "#rrggbb"
    points: Array  # (P, 3) m
    bridged: Booleans  # (P,) not on the scan's skin, which has a hole there
    corners: tuple[int, ...] = ()  # points at which it turns sharply, where they are known; the ends are none
    error: Array | None = None  # (P,) m, radius that holds the true place with 90 %; nan, or None for all: not known

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", frozen(self.points))
        object.__setattr__(self, "bridged", frozen(self.bridged, np.bool_))
        assert len(self.points) > 0
        assert self.points.shape == (len(self.points), 3)
        assert self.bridged.shape == (len(self.points),)
        assert all(0 <= corner < len(self.points) for corner in self.corners)
        if self.error is not None:
            object.__setattr__(self, "error", frozen(self.error))
            assert self.error.shape == (len(self.points),)

    def __len__(self) -> int:
        return len(self.points)

    def moved(self, by: Array) -> Self:
        """The line shifted by (3,) m."""
        return replace(self, points=self.points + by)

    @property
    def outline(self) -> Array:
        """(P, 3) m, or (P + 1, 3) for a closed line, which comes back to its first point."""
        return np.concatenate([self.points, self.points[:1]]) if self.closed else self.points

    @property
    def edges(self) -> Integers:
        """(E, 2) which points are joined; a closed line of two points goes there and not back."""
        count = len(self.points)
        first = np.arange(count if self.closed and count > 2 else count - 1)
        return np.stack([first, (first + 1) % count], axis=1)

    def runs(self) -> list[tuple[Array, bool]]:
        """((M, 3) m, whether they are bridged) for each run of the outline that lies on the skin or is bridged."""
        ends = np.concatenate([self.bridged, self.bridged[:1]]) if self.closed else self.bridged
        cuts = np.flatnonzero(ends[1:] != ends[:-1]) + 1
        return [
            (run, bool(bridged[0]))
            for run, bridged in zip(np.split(self.outline, cuts), np.split(ends, cuts), strict=True)
        ]

    def distances(self, places: Array) -> Array:
        """(M,) m from (M, 3) m places to the nearest place of the line."""
        outline = self.outline
        if len(outline) == 1:
            return np.asarray(np.linalg.norm(places - outline[0], axis=1))
        best = np.full(len(places), np.inf)
        for start, end in pairwise(outline):  # lines have some hundred points
            way = end - start
            share = np.clip((places - start) @ way / max(float(way @ way), 1e-30), 0.0, 1.0)
            best = np.minimum(best, np.linalg.norm(places - start - share[:, None] * way, axis=1))
        return best


def parts(lines: Iterable[Sized]) -> list[slice]:
    """The slice of each line in one array of the points of all lines."""
    return [slice(start, end) for start, end in pairwise(np.cumsum([0, *map(len, lines)]).tolist())]


def arc_lengths(points: Array) -> Array:
    """(M,) m from the first point of a (M, D) polyline to each; the first three columns are positions (m)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points[:, :3], axis=0), axis=1))])


def interpolated(at: Array | float, known: Array, values: Array) -> Array:
    """(..., D) linearly between (M, D) values at (M,) ascending places `known`; beyond their ends as there."""
    return np.stack([np.interp(at, known, column) for column in values.T], axis=-1)


def length(points: Array, closed: bool = False) -> float:
    """m along a (M, 3) polyline."""
    line = np.concatenate([points, points[:1]]) if closed else points
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def point_along(points: Array, distance: float) -> Array:
    """(3,) m: the point of a (M, 3) m polyline after so many metres."""
    return interpolated(distance, arc_lengths(points), points)


def resampled(points: Array, spacing: float, closed: bool) -> Array:
    """(N, D) points evenly along a (M, D) polyline whose first three columns are positions (m).

    Ends are kept; a closed line is not repeated at its end; further columns are carried along linearly.
    """
    line = np.concatenate([points, points[:1]]) if closed else points
    length = arc_lengths(line)
    if length[-1] == 0.0:
        return points[:1].copy()
    count = max(int(np.ceil(length[-1] / spacing)), 3 if closed else 1)
    at = np.linspace(0.0, length[-1], count + 1)[: count if closed else count + 1]
    return interpolated(at, length, line)

"""The numbers of a fit (paragraph 4 of the specification), in millimetres.

`surface_distance` is the paper's quantity: from each model vertex with an accepted pair to the scan.
`scan_to_model` looks the other way, from each scan point inside the model's reach.  Both use the exact search, not
the rays of the fit.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers, any_in_row
from breastrig.correspondence.match import Correspondences, MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.boundary import boundary_vertices
from breastrig.geometry.closest_point import ClosestPointSearch, closest_barycentric
from breastrig.geometry.normals import face_normals, vertex_normals

ACCEPTED = MatchRules(method="tree", max_distance=0.05, max_angle=np.pi / 3)
REACH = 0.05  # m; scan points farther from the model belong to something that the model does not have
MAX_SCAN_POINTS = 20_000  # a larger scan is sampled evenly: the mean changes by up to 0.012 mm


@dataclass(frozen=True, eq=False)
class SurfaceDistances:
    """Distances of the model's vertices, nan where no pair was accepted, and of the scan points in reach."""

    model: Array  # (V,) m
    scan: Array  # (M,) m
    signed: Array  # (V,) m, of the model's vertices: above zero where they lie outside the scan's skin


def summary_mm(distances: Array) -> dict[str, float | None]:
    """mean, std, max, p95 of the finite entries of distances in m; None where there are none."""
    values = 1e3 * distances[np.isfinite(distances)]
    if not len(values):
        return {"mean": None, "std": None, "max": None, "p95": None}
    named = {
        "mean": values.mean(),
        "std": values.std(),
        "max": values.max(),
        "p95": np.percentile(values, 95),
    }
    return {name: round(float(value), 4) for name, value in named.items()}


class Comparison:
    """A fitted surface and a scan, compared in both directions; computed on first use, and cached."""

    def __init__(self, target: ScanTarget, vertices: Array, faces: Integers) -> None:
        """vertices: (V, 3) m, in the target's frame; faces: (F, 3)"""
        self.target, self.vertices, self.faces = target, vertices, faces
        self._seen: dict[int, tuple[Array, Booleans, Booleans]] = {}  # from the scan, by stride

    @cached_property
    def normals(self) -> Array:
        """(V, 3) unit, of the fitted surface."""
        return vertex_normals(self.vertices, self.faces)

    @cached_property
    def search(self) -> ClosestPointSearch:
        """Closest-point search on the fitted surface."""
        return ClosestPointSearch(self.vertices, self.faces)

    @cached_property
    def accepted(self) -> Correspondences:
        """The pairs of the fitted surface's vertices and the scan."""
        return match(self.target, self.vertices, self.normals, ACCEPTED)

    @cached_property
    def _stride(self) -> int:
        return max(1, -(-len(self.target.vertices) // MAX_SCAN_POINTS))  # never more points than that

    def from_scan(self, stride: int) -> tuple[Array, Booleans, Booleans]:
        """Distances (M,) m from every `stride`-th vertex of the scan to the model, and two masks.

        (M,) not beyond one of the model's openings, (M,) facing as the model does.
        """
        known = stride if stride % self._stride else self._stride
        if known not in self._seen:
            self._seen[known] = self._looked_at(known)
        distances, inside, facing = self._seen[known]
        step = stride // known
        return distances[::step], inside[::step], facing[::step]

    def _looked_at(self, stride: int) -> tuple[Array, Booleans, Booleans]:
        points, normals = self.target.vertices[::stride], self.target.normals[::stride]
        near, distances = self.search.distances(points)
        rim = boundary_vertices(self.faces, len(self.vertices))
        inside = np.ones(len(points), dtype=np.bool_)
        of_rim = any_in_row(rim[self.faces])
        at_rim = np.flatnonzero(of_rim[near])  # only there one has to know where on the triangle
        corners = self.faces[near[at_rim]]
        barycentric = closest_barycentric(points[at_rim], self.vertices[corners])
        inside[at_rim] = (barycentric * rim[corners]).sum(axis=1) < 0.999
        facing = np.einsum("mi,mi->m", face_normals(self.vertices, self.faces)[near], normals)
        return distances, inside, facing > np.cos(ACCEPTED.max_angle)

    @cached_property
    def distances(self) -> SurfaceDistances:
        """Distances in both directions."""
        model = np.full(len(self.vertices), np.nan)
        model[self.accepted.vertices] = self.accepted.distances
        distances, inside, facing = self.from_scan(self._stride)
        scan = distances[inside & facing & (distances <= REACH)]
        return SurfaceDistances(model, scan, _signed(self.accepted, self.vertices))


def surface_distances(target: ScanTarget, vertices: Array, faces: Integers) -> SurfaceDistances:
    """Distances between (V, 3) m fitted vertices and the scan, both ways."""
    return Comparison(target, vertices, faces).distances


def signed_distances(target: ScanTarget, vertices: Array, faces: Integers) -> Array:
    """(V,) m, above zero where the model lies outside the scan's skin; nan where no pair was accepted."""
    return _signed(match(target, vertices, vertex_normals(vertices, faces), ACCEPTED), vertices)


def _signed(found: Correspondences, vertices: Array) -> Array:
    result = np.full(len(vertices), np.nan)
    outside = np.einsum("mi,mi->m", vertices[found.vertices] - found.points, found.normals)
    result[found.vertices] = np.where(outside < 0.0, -found.distances, found.distances)
    return result


def surface_summary_mm(model: Array) -> dict[str, float | None]:
    """summary_mm with coverage, the share of model vertices that have a pair."""
    return {**summary_mm(model), "coverage": round(float(np.isfinite(model).mean()), 4)}


def landmark_summary_mm(model: Mapping[str, Array], picked: Mapping[str, Array]) -> dict[str, object]:
    """mean, std, max, min and each distance between the model's and the picked landmarks (m)."""
    each = {name: float(1e3 * np.linalg.norm(model[name] - picked[name])) for name in picked}
    if not each:
        return {"mean": None, "std": None, "max": None, "min": None, "each": {}}
    values = np.array(list(each.values()))
    named = {"mean": values.mean(), "std": values.std(), "max": values.max(), "min": values.min()}
    summary: dict[str, object] = {name: round(float(value), 4) for name, value in named.items()}
    return summary | {"each": {name: round(value, 4) for name, value in each.items()}}

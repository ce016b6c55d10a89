"""The skin around planned lines as one fine, hole-free mesh: the fitted model split, and laid on the scan's skin."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Integers
from breastrig.core.stances import split_side
from breastrig.correspondence.match import match
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.project_drawing import ON_SKIN
from breastrig.geometry.boundary import boundary_edges, triangle_components
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.flatten import unpinched
from breastrig.geometry.half_edges import neighbours, split_flat
from breastrig.geometry.normals import face_areas, vertex_normals
from breastrig.geometry.polyline import Polyline, resampled
from breastrig.report.stance import Stance, places

SPLITS = 2  # of the model's triangles, whose edges are some 10 mm
AROUND = 0.03  # m of skin around the lines, beyond what is asked for
LIFTED = 0.004  # m, the farthest that a fitted vertex is from the skin it was fitted to; farther is another sheet
ROUNDS = 3  # of averaging the heights: a scanner's noise would lengthen every way along the skin
PAPILLA = 0.008  # m around a nipple
FLATTENING = 60  # rounds, after which eight millimetres of 2 mm edges are a membrane
STEP = 0.002  # m between places of a line


@dataclass(frozen=True, eq=False)
class SkinAround:
    """V vertices around lines."""

    vertices: Array  # (V, 3) m
    faces: Integers  # (F, 3) counter-clockwise from outside
    distance: Array  # (V,) m along the edges to the nearest line

    def within(self, margin: float, filled: float) -> tuple[Array, Integers]:
        """The vertices and triangles with a corner up to `margin` (m) from a line; holes below `filled` (m²) closed."""
        chosen = np.asarray((self.distance[self.faces] <= margin).any(axis=1))
        left = self.faces[~chosen]
        _, part = triangle_components(left, len(self.vertices))
        areas = np.bincount(part[left[:, 0]], face_areas(self.vertices, left), len(self.vertices))
        areas[part[boundary_edges(self.faces).ravel()]] = np.inf  # what goes on to the end of the skin is no hole
        chosen[~chosen] = areas[part[left[:, 0]]] < filled
        chosen = unpinched(self.faces, chosen)
        used, faces = np.unique(self.faces[chosen], return_inverse=True)
        return self.vertices[used], faces.reshape(-1, 3).astype(np.int64)


def skin_around(stance: Stance, lines: Sequence[Polyline], reach: float) -> SkinAround:
    """The skin up to `reach` (m) from the lines, and some more."""
    places = np.concatenate([resampled(line.points, STEP, line.closed) for line in lines])
    gaps = np.asarray(cKDTree(places).query(stance.vertices)[0])
    near = stance.rig.faces[(gaps[stance.rig.faces] < reach + AROUND).any(axis=1)]
    used, renumbered = np.unique(near, return_inverse=True)
    vertices, faces = stance.vertices[used], renumbered.reshape(-1, 3)
    for _ in range(SPLITS):
        vertices, faces, _ = split_flat(vertices, faces)
    vertices = _without_papillae(stance, _on_scan(stance, vertices, faces), faces)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    spans = np.linalg.norm(np.diff(vertices[edges], axis=1)[:, 0], axis=1)
    graph = csr_array((spans, tuple(edges.T)), shape=(len(vertices), len(vertices)))
    below = faces[ClosestPointSearch(vertices, faces).query(places).faces]
    distance = dijkstra(graph, directed=False, indices=np.unique(below), min_only=True)
    return SkinAround(vertices, faces, np.asarray(distance))


def _without_papillae(stance: Stance, vertices: Array, faces: Integers) -> Array:
    """The skin as if no nipple stood out: that goes through a hole, and lengths count from the areola's level."""
    tips = [place.point for name, place in places(stance).items() if split_side(name)[0] == "nipple"]
    inside = (np.linalg.norm(vertices[:, None] - np.array(tips)[None], axis=2) < PAPILLA).any(axis=1)
    if not inside.any():
        return vertices
    mean, flat = neighbours(faces, len(vertices))[inside], vertices.copy()
    for _ in range(FLATTENING):
        flat[inside] = mean @ flat
    return flat


def _on_scan(stance: Stance, vertices: Array, faces: Integers) -> Array:
    """The vertices moved along their normals onto the scan where it shows skin."""
    normals = vertex_normals(vertices, faces)
    found = match(ScanTarget(stance.scan_vertices, stance.scan_faces), vertices, normals, ON_SKIN[0])
    heights = np.zeros(len(vertices))
    offsets = np.einsum("mi,mi->m", found.points - vertices[found.vertices], normals[found.vertices])
    heights[found.vertices] = np.where(np.abs(offsets) <= LIFTED, offsets, 0.0)
    mean = neighbours(faces, len(vertices))
    for _ in range(ROUNDS):
        heights = 0.5 * (heights + mean @ heights)
    return np.asarray(vertices + heights[:, None] * normals)

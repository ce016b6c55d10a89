"""A fit for other programs: the drawing as lines, and the model as a closed surface for tetrahedral meshing.

The surface is the fitted model with its neck, arms and waist capped and its crossings smoothed out; the first V
vertices and F triangles are the model's, in its order.  The named sets beside it say which vertices are landmarks,
drawn lines, regions and caps, so that a simulation can fix, load and read them without looking; for where vertices
are too coarse, landmarks and lines also stand there as points of triangles.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Integers
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.geometry.caps import Closed, closed
from breastrig.geometry.polyline import Polyline
from breastrig.geometry.self_intersections import crossing_faces, untangled
from breastrig.report.stance import Stance
from breastrig.report.volume import enclosed_volume

SET_FORMAT = "breastrig/vertex_sets@1"


@dataclass(frozen=True, eq=False)
class ClosedModel:
    """The capped surface and what was done to it."""

    surface: Closed
    moved: float  # m, farthest that a vertex was moved to undo a crossing
    crossing: int  # triangles that still cross others


def closed_model(stance: Stance) -> ClosedModel:
    """The fitted model without openings, in the scan's frame, m."""
    capped = closed(stance.vertices, stance.rig.faces)
    vertices = untangled(capped.vertices, capped.faces)
    return ClosedModel(
        Closed(vertices, capped.faces, capped.caps),
        float(np.linalg.norm(vertices - capped.vertices, axis=1).max()),
        len(crossing_faces(vertices, capped.faces)),
    )


def vertex_sets(stance: Stance, model: ClosedModel, unit: str) -> dict[str, Any]:
    """The document beside the surface: sets of vertex numbers (from 0) by name, and what the surface is."""
    surface, rig = model.surface, stance.rig
    tree = cKDTree(surface.vertices[: len(stance.vertices)])
    landmarks = rig.landmark_points().positions(surface.vertices, rig.faces)
    gaps, nearest = _nearest(tree, landmarks)
    return {
        "schema": SET_FORMAT,
        "notice": LIMITS_OF_USE,
        "unit": unit,
        "vertices": len(surface.vertices),
        "triangles": len(surface.faces),
        "volume_ml": round(1e6 * enclosed_volume(surface.vertices - surface.vertices.mean(axis=0), surface.faces), 1),
        "smoothed_by_mm": round(1e3 * model.moved, 3),
        "crossing_triangles": model.crossing,
        "landmarks": {
            mark.name: {"vertex": int(vertex), "distance_mm": round(1e3 * float(gap), 3)}
            | _surface_point(mark.face, mark.barycentric)
            for mark, vertex, gap in zip(rig.landmarks, nearest, gaps, strict=True)
        },
        "lines": {line.name: _on_vertices(line, tree) | _on_faces(stance, line) for line in stance.lines},
        "regions": {name: [int(vertex) for vertex in members] for name, members in sorted(rig.regions.items())},
        "caps": [sorted({int(vertex) for vertex in surface.faces[cap].ravel()}) for cap in surface.caps],
    }


def _nearest(tree: "cKDTree[None]", points: Array) -> tuple[Array, Integers]:
    """((M,) m, (M,)) the vertex nearest to each of (M, 3) m points."""
    gaps, nearest = tree.query(points)
    return np.asarray(gaps), np.asarray(nearest, dtype=np.int64)


def _on_vertices(line: Polyline, tree: "cKDTree[None]") -> dict[str, Any]:
    """The vertices along a line, in its order, each once in a row, and how far the line is from them."""
    gaps, nearest = _nearest(tree, line.points)
    kept = np.concatenate([[True], nearest[1:] != nearest[:-1]])
    path = [int(vertex) for vertex in nearest[kept]]
    if line.closed and len(path) > 1 and path[0] == path[-1]:
        path.pop()
    return {"closed": line.closed, "vertices": path, "distance_mm": round(1e3 * float(gaps.max()), 3)}


def _on_faces(stance: Stance, line: Polyline) -> dict[str, Any]:
    """The line exactly: the model's point under each of its points."""
    on = stance.on_model(line.points)
    return {"surface_points": [_surface_point(f, b) for f, b in zip(on.faces, on.barycentric, strict=True)]}


def _surface_point(face: int, barycentric: Array) -> dict[str, Any]:
    return {"face": int(face), "barycentric": [round(float(share), 6) for share in barycentric]}

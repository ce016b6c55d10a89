"""Matches between model vertices and the scan, and their dismissal.

embreex answers rays only, so "closest point" is found in three ways that a preset chooses between:

* `rays`: shoot along +normal and -normal of the model, take the nearer hit that agrees; what they miss and is neither
  far from all of the scan nor beyond its border goes to the tree.  About 2 ms for 2,200 vertices whatever the scan's
  size; right once the model is near.
* `tree`: the exact closest point; right from far away, three times slower.
* `nearest_vertex`: the paper's way, nearest scan vertex and projection on the primitives around it.

A match is dismissed when it is too far, when the normals disagree, or when it lies on the scan's open border
(a closest point there only says that the scan ends).
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers, lengths
from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.closest_point import closest_barycentric


@dataclass(frozen=True, eq=False)
class Correspondences:
    """M accepted pairs."""

    vertices: Integers  # (M,) model vertex
    points: Array  # (M, 3) m, on the scan
    normals: Array  # (M, 3) unit, of the scan there
    distances: Array  # (M,) m


@dataclass(frozen=True)
class MatchRules:
    """The search method and the limits of accepted matches."""

    method: str = "rays"  # rays | tree | nearest_vertex
    max_distance: float = 0.05  # m
    max_angle: float = 1.0  # rad, between the model's and the scan's normal
    reject_border: bool = True


@dataclass(frozen=True, eq=False)
class _Found:
    faces: Integers  # (M,) -1: nothing
    barycentric: Array  # (M, 3)


def _by_rays(target: ScanTarget, points: Array, normals: Array, rules: MatchRules) -> _Found:
    """The nearer of the hits along both directions whose scan normal agrees."""
    count = len(points)
    assert target.rays is not None
    hits = target.rays.hits(np.concatenate([points, points]), np.concatenate([normals, -normals]), rules.max_distance)
    met = np.flatnonzero(hits.faces >= 0)  # of 2M: along the normal, then against it
    agree = np.einsum("mi,mi->m", target.face_normals.take(hits.faces[met], axis=0), normals.take(met % count, axis=0))
    met = met[agree > np.cos(rules.max_angle)]
    distances = np.full(2 * count, np.inf)
    distances[met] = hits.distances[met]
    points_met = np.flatnonzero(np.isfinite(distances[:count]) | np.isfinite(distances[count:]))
    chosen = points_met + (distances[count:] < distances[:count])[points_met] * count
    found = _Found(np.full(count, -1, dtype=np.int64), np.zeros((count, 3)))
    second, third = hits.second[chosen], hits.third[chosen]
    found.faces[points_met] = hits.faces[chosen]
    found.barycentric[points_met] = np.stack([1.0 - second - third, second, third], axis=1)
    return found


def _by_tree(target: ScanTarget, points: Array, rules: MatchRules) -> _Found:
    closest = target.search.query(points, rules.max_distance)
    return _Found(closest.faces, closest.barycentric)


def _by_nearest_vertex(target: ScanTarget, points: Array) -> _Found:
    _, nearest = target.vertex_tree.query(points)
    offsets, around = target.faces_of_vertex
    counts = offsets[nearest + 1] - offsets[nearest]
    query = np.repeat(np.arange(len(points)), counts)
    first = np.repeat(offsets[nearest] - np.concatenate([[0], np.cumsum(counts)[:-1]]), counts)
    faces = around[first + np.arange(len(query))]
    barycentric = closest_barycentric(points[query], target.vertices[target.faces[faces]])
    at = np.einsum("mc,mcd->md", barycentric, target.vertices[target.faces[faces]])
    gap = lengths(at - points[query])
    order = np.lexsort((gap, query))
    best = order[np.concatenate([[True], np.diff(query[order]) > 0])] if len(order) else order
    result = np.full(len(points), -1, dtype=np.int64)
    weights = np.zeros((len(points), 3))
    result[query[best]] = faces[best]
    weights[query[best]] = barycentric[best]
    return _Found(result, weights)


def _accepted(target: ScanTarget, points: Array, normals: Array, found: _Found, rules: MatchRules) -> Correspondences:
    index = np.flatnonzero(found.faces >= 0)
    faces, barycentric = found.faces[index], found.barycentric[index]
    at, scan_normals, border = target.surface_at(faces, barycentric)
    gaps = at - points[index]
    distances = np.sqrt(np.einsum("mi,mi->m", gaps, gaps))
    good: Booleans = distances <= rules.max_distance
    good &= np.einsum("mi,mi->m", scan_normals, normals[index]) >= np.cos(rules.max_angle)
    if rules.reject_border:
        good &= border < 0.999
    return Correspondences(index[good], at[good], scan_normals[good], distances[good])


def match(target: ScanTarget, points: Array, normals: Array, rules: MatchRules) -> Correspondences:
    """Matches of (V, 3) m model points with unit (V, 3) normals; dismissed ones are absent."""
    if rules.method == "nearest_vertex":
        found = _by_nearest_vertex(target, points)
    elif rules.method == "tree" or target.rays is None:
        found = _by_tree(target, points, rules)
    else:
        found = _by_rays(target, points, normals, rules)
        missed = np.flatnonzero(found.faces < 0)
        missed = missed[target.may_be_matched(points[missed], rules.max_distance, rules.reject_border)]
        rest = _by_tree(target, points[missed], rules)
        found.faces[missed], found.barycentric[missed] = rest.faces, rest.barycentric
    return _accepted(target, points, normals, found, rules)

"""A smooth free-form layer over the parametric fit, for what 55 shapes cannot show.

Every vertex may move along its own normal only, by h_i, so nothing slides along the skin.  h solves

    Σ_matched w_i (n_i·q_i (h_i + g_i) / σ)²  +  hᵀ (K M⁻¹ K) h / b²  +  hᵀ K_u h / c²  +  hᵀ M (1 + (d / f)⁴) h / s²

(linear, sparse, SPD) with the gap g_i to the matched scan point along the model normal n_i (q_i: the scan's normal
there), the cotangent stiffness K and the lumped areas M of the fitted surface (Botsch and Sorkine, On linear
variational surface deformation methods, 2008).  Bending keeps it smooth.  Where the scan shows nothing the slope counts
too (K_u), or bending alone would carry the slope of the last skin on and overshoot, and the last term lets the layer
die out with the distance d from what is matched.  A match counts less the fewer of its neighbours are matched: at the
edge of a scan one vertex alone is no skin.  Matches are renewed a few times; around a triangle that would turn over the
layer is held back until it does not.

Where no scan shows the skin, the layer is aimed at the mean distance from the fitted model to true skin there, by
place, data beside the rig.  It is estimated on virtual bodies whose whole skin is known (breastrig_studies/bodies);
evidence: docs/decisions/0005.  Of supine bodies only the back's form is kept; how much deeper its hidden skin is says
the height of the belly above the table: beyond a threshold times a slope at each place, no farther than down to the
table, added to that mean.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from pydantic import BaseModel, Field, FiniteFloat, model_validator
from scipy.linalg import solveh_banded
from scipy.sparse import coo_array, csc_array, csr_array, diags_array
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Integers, lengths
from breastrig.correspondence.match import MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.normals import VertexNormals, face_normals, turned_triangles, vertex_normals
from breastrig.geometry.plane import Plane
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig

SCHEMA = "breastrig/hidden-skin@1"
WIDTH = 0.02  # m, of the Gaussian that blends the places' heights; they are this far apart
NOTHING = -50.0  # of a weight's logarithm: 1e-22; numbers too small for the processor take it ten times as long
ROWS = 64  # of vertices at once: what is computed of them stays in the processor's cache
BEYOND = 0.1  # of the weight of one place: where there is less, the heights die out


@dataclass(frozen=True, eq=False)
class HiddenSkin:
    """N places of a template's left side; the right side is alike, mirrored."""

    places: Array  # (N, 3) m
    normals: Array  # (N, 3) unit: an arm and the trunk beside it are not blended
    heights: Array  # (N,) m along the fitted model's normals

    def at(self, template: Array, normals: Array) -> Array:
        """(V,) m: the heights of a template's (V, 3) m vertices with (V, 3) unit normals."""
        sides = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]])
        places, facing = ((each * sides[:, None]).reshape(-1, 3) for each in (self.places, self.normals))
        heights, result = np.tile(self.heights, 2), np.zeros(len(template))
        lengths, doubled = (places**2).sum(axis=1), -2.0 * places.T
        for first in range(0, len(template), ROWS):
            part = slice(first, first + ROWS)
            squares = (template[part] ** 2).sum(axis=1)[:, None] + lengths + template[part] @ doubled
            weights = np.exp(np.maximum(-0.5 / WIDTH**2 * squares, NOTHING)) * np.maximum(normals[part] @ facing.T, 0.0)
            result[part] = weights @ heights / np.maximum(weights.sum(axis=1), BEYOND)
        return result


class PlacesFile(BaseModel):
    """Places of a template's left side with their normals."""

    places_mm: list[tuple[FiniteFloat, FiniteFloat, FiniteFloat]]
    normals: list[tuple[FiniteFloat, FiniteFloat, FiniteFloat]]

    def check(self, numbers: list[float]) -> None:
        """ValueError when there is not one number for each place."""
        if not len(self.places_mm) == len(self.normals) == len(numbers):
            raise ValueError("it needs one normal and one number for each place")


class _File(PlacesFile):
    schema_: Literal["breastrig/hidden-skin@1"] = Field(alias="schema")
    heights_mm: list[FiniteFloat]

    @model_validator(mode="after")
    def _fits_together(self) -> "_File":
        self.check(self.heights_mm)
        return self


@lru_cache(maxsize=8)
def hidden_skin(rig: Rig, stance: str) -> Array | None:
    """(V,) m along the normals of the rig's vertices; None for a rig or stance without data."""
    stored = known_part(rig, f"hidden_{stance}.json", _File)
    if stored is None:
        return None
    kept = HiddenSkin(1e-3 * np.array(stored.places_mm), np.array(stored.normals), 1e-3 * np.array(stored.heights_mm))
    return kept.at(rig.template, vertex_normals(rig.template, rig.faces))


DEPTH_SCHEMA = "breastrig/trunk-depth@1"


@dataclass(frozen=True, eq=False)
class TrunkDepth:
    slopes: Array  # (V,) m along the normals, for a metre of the belly's height beyond `ordinary`
    ordinary: float  # m, mean height of the belly above the table up to which nothing is added
    most: float  # m beyond it that count
    reach: float  # m, mean height of the fitted back above what is its table; a plane farther off is none

    def added(self, rig: Rig, table: Plane, vertices: Array, expected: Array) -> Array:
        """(V,) m along the normals of (V, 3) m fitted vertices, beyond the (V,) m that are expected of all bodies."""
        above = vertices @ table.normal - table.height
        if above[rig.regions["back"]].mean() > self.reach:
            return np.zeros(len(vertices))
        excess = np.clip(above[rig.regions["belly"]].mean() - self.ordinary, 0.0, self.most)
        down = -vertex_normals(vertices, rig.faces) @ table.normal
        room = np.maximum(above - expected * down, 0.0) / np.maximum(down, 1e-9)  # to the table
        return np.asarray(np.minimum(self.slopes * excess, np.where(down > 0.0, room, np.inf)))


class _DepthFile(PlacesFile):
    schema_: Literal["breastrig/trunk-depth@1"] = Field(alias="schema")
    slopes: list[FiniteFloat]
    ordinary_mm: FiniteFloat
    most_mm: FiniteFloat
    reach_mm: FiniteFloat

    @model_validator(mode="after")
    def _fits_together(self) -> "_DepthFile":
        self.check(self.slopes)
        return self


@lru_cache(maxsize=8)
def trunk_depth(rig: Rig) -> TrunkDepth | None:
    """The rig's data; None for a rig without any."""
    stored = known_part(rig, "trunk_depth.json", _DepthFile)
    if stored is None or not {"back", "belly"} <= rig.regions.keys():
        return None
    places = HiddenSkin(1e-3 * np.array(stored.places_mm), np.array(stored.normals), np.array(stored.slopes))
    slopes = places.at(rig.template, vertex_normals(rig.template, rig.faces))
    return TrunkDepth(slopes, *(1e-3 * each for each in (stored.ordinary_mm, stored.most_mm, stored.reach_mm)))


def skin_behind(rig: Rig, stance: str, target: ScanTarget, vertices: Array) -> Array | None:
    """(V,) m along the normals of the (V, 3) m fitted vertices to the expected skin where the scan shows none.

    None for a rig or stance without data.
    """
    expected = hidden_skin(rig, stance)
    deeper = trunk_depth(rig) if stance == "supine" else None
    if expected is None or deeper is None or target.table is None:
        return expected
    return expected + deeper.added(rig, target.table, vertices, expected)


ROUNDS = 2  # renewals of the matches; a third gains nothing
RULES = MatchRules(method="rays", max_distance=0.015, max_angle=0.87)  # as the fit's last stage
SIGMA = 0.0010  # m, noise of the scan where a vertex meets it
BENDING = 0.7  # 1/m, expected root of the summed squared curvature change: folds and muscles, not noise
SLOPE = 0.007  # m, expected root of the summed squared slope where nothing is matched; half of it is as good
DYING = 0.004  # m·m, expected root of the summed squared displacement on the scan's skin
FADE = (
    0.012  # m from the matched skin, where the layer begins to die out; at three times half is left, at seven nothing
)
HIDDEN = 0.02  # m from the matched skin, where the layer is half way to what is expected of hidden skin
ALONE = 4  # power of the share of matched neighbours that a match counts with: jumps at edges 3.6 instead of 4.5 mm
HELD = 0.25  # of the weight of a match, with which a turned triangle is held at the model; HOLDING_TRIES times
HELD_MORE = 10.0  # by which it grows each time
HOLDING_TRIES = 5
BAND_WORK = 3e9  # multiplications of a banded factor; beyond them (about 10,000 vertices) a sparse one is faster


@dataclass(frozen=True, eq=False)
class Refined:
    """The refined surface."""

    vertices: Array  # (V, 3) m
    displacement: Array  # (V,) m along the fitted model's normals


def stiffness_and_area(vertices: Array, faces: Integers) -> tuple[csc_array, Array]:
    """((V, V) cotangent stiffness, (V,) m² a third of the area around each vertex)."""
    count = len(vertices)
    rows, columns, values = [], [], []
    area = np.zeros(count)
    corners = vertices[faces]
    double = lengths(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    for k in range(3):
        i, j = faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        cotangent = 0.5 * np.einsum("fi,fi->f", a, b) / np.maximum(double, 1e-12)
        cotangent = np.maximum(cotangent, 1e-3)  # obtuse corners must not make it indefinite
        rows += [i, j, i, j]
        columns += [j, i, i, j]
        values += [-cotangent, -cotangent, cotangent, cotangent]
        area += np.bincount(faces[:, k], weights=double / 6.0, minlength=count)
    index = (np.concatenate(rows), np.concatenate(columns))
    return csc_array(coo_array((np.concatenate(values), index), shape=(count, count))), area


def _matched_around(stiffness: csc_array, matched: Array) -> Array:
    """(V,) share of each vertex's neighbours that are matched (1.0, else 0.0)."""
    joined = csc_array((np.ones(stiffness.nnz), stiffness.indices, stiffness.indptr), shape=stiffness.shape)
    return np.asarray((joined @ matched - matched) / (np.diff(joined.indptr) - 1.0))


class _Systems:
    """The matrices of one surface, which differ in few numbers: all have the places of the bending's entries."""

    def __init__(self, stiffness: csc_array, area: Array) -> None:
        """stiffness: (V, V); area: (V,)"""
        bending = csc_array(stiffness @ diags_array(1.0 / (area * BENDING**2)) @ stiffness)
        bending.sort_indices()
        stiffness.sort_indices()
        count = len(area)
        edges = stiffness.indices.astype(np.int64), np.repeat(np.arange(count), np.diff(stiffness.indptr))
        places = bending.indices + count * np.repeat(np.arange(count), np.diff(bending.indptr))  # column after column
        apart = edges[0] != edges[1]
        self._bending, self._count = bending, count
        self._order = reverse_cuthill_mckee(csr_array(bending), symmetric_mode=True)
        place = np.argsort(self._order)
        rows, columns = place[bending.indices], place[np.repeat(np.arange(count), np.diff(bending.indptr))]
        self._lower = np.flatnonzero(rows >= columns)
        self._band_places = (rows - columns)[self._lower], columns[self._lower]
        self._band_width = int(np.max(self._band_places[0], initial=0))
        self._i, self._j, self._stiffness = edges[0][apart], edges[1][apart], stiffness.data[apart]
        self._edge = np.searchsorted(places, self._i + count * self._j)
        self._diagonal = np.searchsorted(places, (count + 1) * np.arange(count))

    def system(self, weight: Array, flat: Array) -> csc_array:
        """The bending, (V,) weights of the displacements, and the stiffness with each edge times the mean of its two
        vertices' (V,) `flat`."""
        edges = 0.5 * (flat[self._i] + flat[self._j]) * self._stiffness
        data = self._bending.data.copy()
        data[self._edge] += edges
        data[self._diagonal] += weight - np.bincount(self._i, edges, self._count)
        return csc_array((data, self._bending.indices, self._bending.indptr), shape=self._bending.shape)

    def solved(self, weight: Array, flat: Array, right: Array) -> Array:
        """(V,) displacements with `system` times them = (V,) right."""
        matrix = self.system(weight, flat)
        if self._count * self._band_width**2 > BAND_WORK:
            return np.asarray(splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(right))
        band = np.zeros((self._band_width + 1, self._count), order="F")
        band[self._band_places] = matrix.data[self._lower]
        result = np.zeros(self._count)
        result[self._order] = solveh_banded(band, right[self._order], lower=True, overwrite_ab=True, check_finite=False)
        return result


def precompute_layers(vertices: Array, faces: Integers) -> None:
    """Finds what all layers over these (F, 3) triangles share, whatever the (V, 3) places of their vertices."""
    _Systems(*stiffness_and_area(vertices, faces))


def _turned(before: Array, vertices: Array, faces: Integers) -> Integers:
    """Vertices of triangles that turned over."""
    return np.unique(faces[np.einsum("fi,fi->f", before, face_normals(vertices, faces)) <= 0.0])


def refined(target: ScanTarget, vertices: Array, faces: Integers, hidden: Array | None = None) -> Refined:
    """(V, 3) m fitted vertices, moved along their normals onto the scan where it shows skin.

    (V,) m `hidden` is where skin that it does not show is expected above the model; the layer goes over into that.
    """
    normals_of = VertexNormals(faces, len(vertices))
    normals, facing = normals_of(vertices), face_normals(vertices, faces)
    stiffness, area = stiffness_and_area(vertices, faces)
    systems = _Systems(stiffness, area)
    of_match = area / area.mean() / SIGMA**2
    held = np.zeros(len(vertices))
    heights = np.zeros(len(vertices))
    away = np.full(len(vertices), np.inf)
    for _ in range(ROUNDS):
        moved = vertices + heights[:, None] * normals
        found = match(target, moved, normals_of(moved), RULES)
        at = found.vertices
        if not len(at):
            break
        matched = np.zeros(len(vertices))
        matched[at] = 1.0
        q = np.einsum("mi,mi->m", found.normals, normals[at])
        gap = np.einsum("mi,mi->m", found.normals, vertices[at] - found.points)
        trust = of_match[at] * _matched_around(stiffness, matched)[at] ** ALONE
        weight, right = np.zeros(len(vertices)), np.zeros(len(vertices))
        weight[at], right[at] = trust * q**2, -trust * q * gap
        away = np.asarray(cKDTree(vertices[at]).query(vertices)[0])
        weight += area / DYING**2 * (1.0 + (away / FADE) ** 4)
        for _ in range(HOLDING_TRIES + 1):
            flat = np.where(held > 0.0, 1.0, 1.0 - matched) / SLOPE**2
            candidate = systems.solved(weight + held * of_match, flat, right)
            turned = _turned(facing, vertices + candidate[:, None] * normals, faces)
            if not len(turned):
                heights = candidate
                break
            around = np.unique(faces[np.isin(faces, turned).any(axis=1)])
            held[around] = np.maximum(HELD_MORE * held[around], HELD)
    if hidden is not None:
        heights = _with_hidden(vertices, faces, normals, heights, hidden * (1.0 - 1.0 / (1.0 + (away / HIDDEN) ** 4)))
    return Refined(vertices + heights[:, None] * normals, heights)


def _with_hidden(vertices: Array, faces: Integers, normals: Array, heights: Array, hidden: Array) -> Array:
    """(V,) m: the heights with those of hidden skin, but for where the skin would fold, and all around there."""
    folded = turned_triangles(vertices + heights[:, None] * normals, faces)
    for _ in range(HOLDING_TRIES):
        turned = turned_triangles(vertices + (heights + hidden)[:, None] * normals, faces) & ~folded
        if not turned.any():
            return heights + hidden
        hidden = hidden.copy()
        hidden[np.unique(faces[np.isin(faces, faces[turned]).any(axis=1)])] = 0.0
    return heights

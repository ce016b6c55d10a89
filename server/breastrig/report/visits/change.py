"""The signed change of the skin of both breasts between two visits, along the normal, and of their volumes.

From each vertex of the earlier fit the way along its normal to the later fit's skin, so that it does not matter how
vertices slide along the skin.  The band follows from what untouched skin differs by between these two scans, by factors
that were measured on bodies of known change (docs/decisions/0042).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadInput
from breastrig.core.settings_file import NotNegative, Positive, SettingsPart
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import face_areas, unit_vectors, vertex_normals
from breastrig.report.stance import Stance
from breastrig.report.table import Value
from breastrig.report.visits.alignment import Alignment, aligned, on_breasts
from breastrig.report.volume import enclosed_volume, vertices_within
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig

STEPS = 8  # of the ray to a tangent plane and on to the skin there
LARGEST = 0.08  # m, beyond which a ray has missed the breast
STEEP = 0.3  # cosine between both skins' normals below which they do not face each other
SEEN = 0.5  # share of a breast that both scans show, below which its volume's change is not said
MET = 0.002  # m, from where a ray ends to the skin


class VisitCalibration(SettingsPart):
    """visits.toml: 90 % errors between two visits in one stance."""

    points: Positive  # of half the band of a point, in spreads of untouched skin
    least: NotNegative  # m of that half
    volume: Positive  # of half the band of a volume over its skin's area, likewise
    lengths: Positive  # of the band of a length's change, in those that both fits state
    shape: NotNegative  # m, half the band of shape symmetry


@lru_cache(maxsize=8)
def visit_calibration(rig: Rig) -> VisitCalibration | None:
    """This rig's calibration; None when it has none."""
    return known_part(rig, "visits.toml", VisitCalibration)


@dataclass(frozen=True, eq=False)
class Change:
    """What changed between two fits, by vertex of the earlier one."""

    earlier: Stance
    alignment: Alignment
    normals: Array  # (V, 3) of the earlier skin
    along: Array  # (V,) m outwards; nan off the breasts and where a scan shows no skin
    half: float  # m, half the 90 % band; within it nothing is said

    @property
    def said(self) -> Booleans:
        """(V,) where the change is larger than its band."""
        return np.abs(self.along) > self.half  # nan is not

    def volume(self, side: str) -> Value | None:
        """ml that the breast on `side` ("L" or "R") gained; None where both scans show less than half of it."""
        rig, vertices = self.earlier.rig, self.earlier.vertices
        inside, calibration = vertices_within(rig, side), visit_calibration(rig)
        if inside is None or calibration is None:
            return None
        place = np.flatnonzero(inside & np.isfinite(self.along))
        if len(place) < SEEN * inside.sum():
            return None
        nearest = place[cKDTree(vertices[place]).query(vertices[inside])[1]]  # itself, or next to what is hidden
        moved = vertices.copy()
        moved[inside] += self.along[nearest, None] * self.normals[inside]
        gained = enclosed_volume(moved, rig.faces) - enclosed_volume(vertices, rig.faces)
        area = float(face_areas(vertices, rig.faces[inside[rig.faces].all(axis=1)]).sum())
        half = calibration.volume * area * self.alignment.spread
        return Value(*(1e6 * each for each in (gained, gained - half, gained + half)))


def change_between(earlier: Stance, later: Stance) -> Change:
    """Raises BadInput where scans share too little skin, or nobody has measured how sure changes are for this model."""
    rig, calibration = earlier.rig, visit_calibration(earlier.rig)
    if calibration is None:
        raise BadInput(f"How sure a change between two visits is was not measured for the model {rig.name}.")
    alignment = aligned(earlier, later)
    normals = vertex_normals(earlier.vertices, rig.faces)
    members = on_breasts(rig)
    members = members[np.isfinite(earlier.distances[members])]
    way, faces = way_to(earlier.vertices[members], normals[members], later.search, alignment)
    along = np.full(len(normals), np.nan)
    along[members] = np.where(np.isfinite(later.distances)[rig.faces[faces]].all(axis=1), way, np.nan)
    return Change(earlier, alignment, normals, along, max(calibration.points * alignment.spread, calibration.least))


def way_to(points: Array, normals: Array, later: ClosestPointSearch, alignment: Alignment) -> tuple[Array, Integers]:
    """(M,) m from (M, 3) m points along (M, 3) normals to the later skin, nan where it misses; (M,) which triangle.

    Newton's steps on the tangent planes of the closest triangles.
    """
    facing = vertex_normals(later.vertices, later.triangles)
    start, ways = (points - alignment.translation) @ alignment.rotation, normals @ alignment.rotation
    along = np.zeros(len(points))
    for _ in range(STEPS):
        found = later.query(start + along[:, None] * ways)
        at = unit_vectors(np.einsum("mc,mcd->md", found.barycentric, facing[later.triangles[found.faces]]))
        cosine = np.einsum("mi,mi->m", ways, at)
        along = np.einsum("mi,mi->m", found.points - start, at) / np.maximum(cosine, STEEP)
        along = np.clip(along, -LARGEST, LARGEST)
    off = np.linalg.norm(found.points - start - along[:, None] * ways, axis=1)
    return np.where((cosine < STEEP) | (np.abs(along) >= LARGEST) | (off > MET), np.nan, along), found.faces

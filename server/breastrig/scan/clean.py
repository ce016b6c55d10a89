"""Cleaning steps from the scanner's surface to one that can be fitted; each returns new arrays.

The scan itself is never changed on disk; drawings are projected on the cleaned surface, which is a part of it.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers, lengths
from breastrig.core.errors import BadScan
from breastrig.geometry.boundary import triangle_components
from breastrig.geometry.normals import face_crosses
from breastrig.scan.caps import caps
from breastrig.scan.scan import Scan
from breastrig.scan.winding import outwards

KEY_LIMIT = 2**21  # µm, 2.1 m: three such numbers fit into one
MIN_TRIANGLES = 200  # fewer cannot show a torso
INWARD_SHARE = 0.01  # fewer are scraps whose side nobody can tell: left as they are
LONG = 0.2  # m; triangles that long show no form, those of a torso of MIN_TRIANGLES are half as long
THIN = 0.005  # m², of all others; one breast has 0.03
NO_AREA = 1e-12  # m², twice the area of a triangle that has none
FRAGMENT_SHARE = 0.02  # pieces smaller than this share of the largest are dust


@dataclass(frozen=True, eq=False)
class Surface:
    """A cleaned scan."""

    vertices: Array  # (V, 3) m
    faces: Integers  # (F, 3)
    notes: tuple[str, ...]  # what was cut away around the body


def welded(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """Vertices at the same place (to 1 µm) become one: STL and split OBJ files repeat them."""
    keys = np.round(vertices * 1e6).astype(np.int64)
    keys -= keys.min(axis=0) if len(keys) else 0
    if (keys < KEY_LIMIT).all():  # as one number each: rows would sort slowly
        keys = (keys[:, 0] * KEY_LIMIT + keys[:, 1]) * KEY_LIMIT + keys[:, 2]
    if keys.ndim == 1:
        ordered = np.sort(keys)
        if (ordered[1:] != ordered[:-1]).all():
            return vertices, faces
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    if len(first) == len(vertices):
        return vertices, faces
    return vertices[first], inverse.ravel()[faces].astype(np.int64)


def have_area(crosses: Array) -> Booleans:
    """(F,) of triangles with these (F, 3) face_crosses, which have an area."""
    return np.asarray(np.einsum("fi,fi->f", crosses, crosses) > NO_AREA**2)


def large_pieces(vertices: Array, faces: Integers) -> tuple[Booleans, int]:
    """(F,) in pieces of at least FRAGMENT_SHARE of the largest (by triangles), and how many others there are."""
    _, labels = triangle_components(faces, len(vertices))
    piece = labels[faces[:, 0]]
    sizes = np.bincount(piece)
    kept = sizes >= FRAGMENT_SHARE * sizes.max()
    return np.asarray(kept[piece]), int((sizes > 0).sum() - kept.sum())


def compact(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """The mesh with only the vertices that a triangle uses."""
    used = np.zeros(len(vertices), dtype=np.bool_)
    used[faces] = True
    index = np.cumsum(used) - 1
    return vertices[used], index[faces].astype(np.int64)


def _check_skin(vertices: Array, faces: Integers, crosses: Array) -> None:
    """Raises BadScan for a surface of almost no area, or of a few long triangles; `crosses` are its face_crosses."""
    corners = [vertices.take(corner, axis=0) for corner in faces.T]
    ends = (corners[k] - corners[k - 1] for k in range(3))
    is_short = np.max([np.einsum("fi,fi->f", end, end) for end in ends], axis=0) < LONG**2
    area = 0.5 * float(lengths(crosses[is_short]).sum())
    if area < THIN:
        raise BadScan(
            f"Only {1e4 * area:.0f} cm² of the scan's surface are in triangles shorter than {100 * LONG:.0f} cm, "
            "too little to show a torso; export the whole mesh, and check its unit."
        )


def clean(scan: Scan) -> Surface:
    """The part of a scan that can be fitted: no dust, no triangles without area, all faces outwards, no flat lids.

    Only removed lids are reported: the other steps need no action and do not change a fit.
    """
    vertices, faces = welded(np.asarray(scan.vertices, dtype=np.float64), np.asarray(scan.faces, dtype=np.int64))
    crosses = face_crosses(vertices, faces)
    solid = have_area(crosses)
    if not solid.all():
        faces, crosses = faces[solid], crosses[solid]
    if not len(faces):
        raise BadScan("The scan has no triangle with an area; export it again as a mesh.")
    large, dropped = large_pieces(vertices, faces)
    if dropped:
        faces, crosses = faces[large], crosses[large]
    if len(faces) < MIN_TRIANGLES:
        raise BadScan(
            f"The scan has only {len(faces)} usable triangles; at least {MIN_TRIANGLES} are needed to show a torso."
        )
    turned, count = outwards(vertices, faces, crosses)
    if count > INWARD_SHARE * len(faces):
        faces, crosses = turned, face_crosses(vertices, turned)
    lids = caps(vertices, faces, crosses)
    skin = ~lids if lids.any() and not lids.all() else np.ones_like(lids)
    _check_skin(vertices, faces[skin], crosses[skin])
    if lids.any() and np.count_nonzero(~lids) >= MIN_TRIANGLES:
        area = 0.5e4 * np.linalg.norm(face_crosses(vertices, faces[lids]), axis=1).sum()
        return Surface(
            *compact(vertices, faces[~lids]), (f"Flat lids that closed the scan were cut away: {area:,.0f} cm².",)
        )
    return Surface(*compact(vertices, faces), ())

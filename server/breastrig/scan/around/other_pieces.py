"""Pieces beside the body that are none of its skin, such as a helper's hand, cut away before the fit.

A piece continues the body if much of its border runs within a few centimetres of the body's border and both lie in one
surface: neither rises above the other's tangent plane.  An arm scanned more than 3 cm apart counts as another person's;
what touches the body is never cut.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.boundary import boundary_vertices, triangle_components
from breastrig.geometry.normals import face_areas, face_crosses, vertex_normals
from breastrig.scan.around.background import is_flat, only_body

LARGE = 0.3  # of the body's area, as seen from one side; a side of the patient shows it, a whole arm does not
REACH = 0.06  # m from border to border; tears are narrower
RISE = 0.5  # sine: how far each may lie above or below the other's tangent plane; 6 cm on a breast bend by 0.45
ALIKE = 0.3  # cosine between the normals on both sides of a tear
SHARE = 0.15  # of a piece's border that has to continue the body
FLAT = 0.006  # m, standard deviation; a table of 1 cm has 5 mm, a quarter of a trunk 14 mm
NO_LENGTH = 1e-9  # m
ROUNDS = 6  # pieces that continue pieces; each round adds all that continue what is body by then


@dataclass(frozen=True, eq=False)
class Piece:
    """A piece beside the body."""

    place: Array  # (3,) m, on it: with no more than that it is found again on any mesh of the scan
    area: float  # m²


def without_other_pieces(vertices: Array, faces: Integers, in_room: bool) -> tuple[Booleans, tuple[Piece, ...]]:
    """(F,) the body's triangles among (F, 3) `faces`, and the other pieces, the largest first.

    `in_room`: floors or walls were cut away. Pieces beside the patient are then furniture and not examined further.
    """
    count, labels = triangle_components(faces, len(vertices))
    piece = labels[faces[:, 0]]
    if (piece == piece[0]).all():
        return np.ones(len(faces), dtype=np.bool_), ()
    of_body = only_body(vertices, faces) if in_room else _body_pieces(vertices, faces, labels, count)[piece]
    areas = face_areas(vertices, faces)
    whole = np.bincount(piece[~of_body], areas[~of_body], count)
    others = np.argsort(-whole, kind="stable")[: np.count_nonzero(whole)]
    return of_body, tuple(_piece(vertices, faces, np.flatnonzero(piece == other), areas) for other in others)


def _piece(vertices: Array, faces: Integers, own: Integers, areas: Array) -> Piece:
    largest = own[np.argmax(areas[own])]
    return Piece(vertices[faces[largest]].mean(axis=0), float(areas[own].sum()))


def _body_pieces(vertices: Array, faces: Integers, labels: Integers, count: int) -> Booleans:
    """(P,) which pieces are the body: the largest that is not flat, other sides of it, and what continues them."""
    piece, crosses = labels[faces[:, 0]], 0.5 * face_crosses(vertices, faces)
    areas = np.bincount(piece, np.linalg.norm(crosses, axis=1), count)
    facing = np.linalg.norm([np.bincount(piece, along, count) for along in crosses.T], axis=0)
    is_body = np.zeros(count, dtype=np.bool_)
    body = None
    for which in np.argsort(-areas, kind="stable"):
        if areas[which] == 0.0 or (body is not None and areas[which] < LARGE * areas[body]):
            break
        if is_flat(vertices[np.unique(faces[piece == which])], FLAT):
            continue  # a table or a wall that was not found as one, larger than the patient
        body = which if body is None else body
        is_body[which] = which == body or facing[which] >= LARGE * areas[body]
    if body is None:
        is_body[np.argmax(areas)] = True
    on_border = np.flatnonzero(boundary_vertices(faces, len(vertices)))
    border = _Border(vertices[on_border], vertex_normals(vertices, faces)[on_border], labels[on_border])
    for _ in range(ROUNDS):
        joins = border.continuing(is_body)
        if not joins.any():
            break
        is_body = is_body | joins
    return np.asarray(is_body)


class _Border:
    """All borders of a scan's pieces: (B, 3) m places, (B, 3) unit normals, (B,) pieces."""

    def __init__(self, places: Array, normals: Array, pieces: Integers) -> None:
        self.places, self.normals, self.pieces = places, normals, pieces

    def continuing(self, is_body: Booleans) -> Booleans:
        """(P,) pieces of which enough of the border continues that of the (P,) pieces that are the body's."""
        of_body = is_body[self.pieces]
        if of_body.all() or not of_body.any():
            return np.zeros(len(is_body), dtype=np.bool_)
        others = np.flatnonzero(~of_body)
        own = np.flatnonzero(of_body)
        found = cKDTree(self.places[own]).query(self.places[others], distance_upper_bound=REACH)
        distance, nearest = np.asarray(found[0]), np.asarray(found[1])
        near = np.isfinite(distance)
        one, other = others[near], own[nearest[near]]
        across = (self.places[one] - self.places[other]) / (distance[near, None] + NO_LENGTH)
        rises = np.maximum(*(np.abs(np.einsum("bi,bi->b", across, self.normals[side])) for side in (one, other)))
        alike = np.einsum("bi,bi->b", self.normals[one], self.normals[other])
        goes_on = one[(rises < RISE) & (alike > ALIKE)]
        length, continued = (np.bincount(self.pieces[of], minlength=len(is_body)) for of in (others, goes_on))
        return np.asarray((length > 0) & (continued >= SHARE * length))

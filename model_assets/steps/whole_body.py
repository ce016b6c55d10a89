"""The half body and its mirror image, joined along the mid-plane: exact symmetry by construction."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from steps.half_body import HalfBody
from steps.source import Array, Integers

FLIP = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Template:
    """The model's mesh at rest, with what the later steps need to know of it."""

    vertices: Array  # (V, 3) m
    triangles: Integers  # (F, 3)
    mix: sparse.csr_matrix  # (V, S) of source vertices
    mirror: Integers  # (V,)
    rings: list[Integers]  # the left areola: border first, tip last
    axis: Array  # (3,) direction of the left nipple

    def carry(self, field: Array) -> Array:
        """A (S, ...) field of the source on the template."""
        return np.asarray(self.mix @ field)

    def mirrored(self, field: Array) -> Array:
        """The mirror image of a (V, 3) vector field."""
        return np.asarray(FLIP * field[self.mirror])

    def symmetric(self, field: Array) -> Array:
        """The symmetric part of a (V, 3) vector field."""
        return np.asarray(0.5 * (field + self.mirrored(field)))


def whole_body(half: HalfBody, mirror_of_source: Integers, decimals: int) -> Template:
    """Both halves; coordinates are rounded to `decimals` so that every machine writes the same bytes."""
    left = half.surface
    count = len(left.vertices)
    twin = np.arange(count)
    sided = np.flatnonzero(~half.middle)
    twin[sided] = count + np.arange(len(sided))
    points = np.round(left.vertices, decimals)
    points[half.middle, 0] = 0.0
    vertices = np.concatenate([points, FLIP * points[sided]])
    triangles = np.concatenate([left.triangles, twin[left.triangles][:, ::-1]])
    swapped = left.mix[sided].tocoo()
    right = sparse.csr_matrix((swapped.data, (swapped.row, mirror_of_source[swapped.col])), swapped.shape)
    mirror = np.concatenate([twin, sided])
    return Template(vertices, triangles, sparse.vstack([left.mix, right]).tocsr(), mirror, half.rings, half.axis)

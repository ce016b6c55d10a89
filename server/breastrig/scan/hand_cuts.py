"""Parts that a person has cut out of a scan with a lasso: left out of fits and proposals; the stored scan stays whole.

A cut is the lasso's corners in a picture, and the projective map from the scan's own axes to that picture. It removes
everything within the lasso, however deep. So it is small and needs no numbering of triangles, and the page and this
module find the same triangles: both take a triangle's middle, in numbers as short as the page's.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadScan
from breastrig.core.private_files import read_ordinary, shown
from breastrig.scan.clean import MIN_TRIANGLES
from breastrig.scan.scan import Scan


@dataclass(frozen=True, eq=False)
class HandCut:
    """One lasso."""

    to_picture: Array  # (4, 4) from metres in the scan's axes, homogeneous; w > 0 is before the eye
    lasso: Array  # (N, 2) its corners there

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> "HandCut":
        """Reads {to_picture: 16 numbers, column by column, lasso: [[x, y], ...]}."""
        return cls(np.reshape(document["to_picture"], (4, 4)).T.astype(np.float64), np.array(document["lasso"], float))


def cut_triangles(vertices: Array, faces: Integers, cuts: Sequence[HandCut]) -> Booleans:
    """(F,) the triangles whose middle lies within one of the lassos."""
    result = np.zeros(len(faces), dtype=np.bool_)
    if not cuts:
        return result
    short = np.asarray(vertices, dtype=np.float32).astype(np.float64)
    middles = (short[faces[:, 0]] + short[faces[:, 1]] + short[faces[:, 2]]) / 3.0
    for cut in cuts:
        left = np.flatnonzero(~result)
        result[left[_within(cut, middles[left])]] = True
    return result


def are_cut(places: Array, documents: Sequence[Mapping[str, Any]]) -> Booleans:
    """(N,) which of the (N, 3) m places lie within one of these cuts (see HandCut.of)."""
    result = np.zeros(len(places), dtype=np.bool_)
    for document in documents:
        result[_within(HandCut.of(document), places)] = True
    return result


def cut_in(cut: dict[str, Any], factor: float) -> dict[str, Any]:
    """A cut by hand of the scan times the factor; the picture in which it was drawn is the same."""
    turned, moved = cut["to_picture"][:12], cut["to_picture"][12:]
    return cut | {"to_picture": [*(value / factor for value in turned), *moved]}


def without_hand_cuts(scan: Scan, documents: Sequence[Mapping[str, Any]]) -> Scan:
    """The scan without these cuts (see HandCut.of). Raises BadScan where almost nothing is left."""
    left = without_cuts(scan.vertices, scan.faces, documents)
    count = len(scan.faces) - len(left)
    if not count:
        return scan
    note = f"{count:,} triangles were cut away by hand." if count > 1 else "One triangle was cut away by hand."
    return replace(scan, faces=left, cut_by_hand=count, notes=(*scan.notes, note))


def without_cuts(vertices: Array, faces: Integers, documents: Sequence[Mapping[str, Any]]) -> Integers:
    """The remaining triangles of (V, 3) m vertices and (F, 3) faces. Raises BadScan where almost nothing is left."""
    cut = cut_triangles(vertices, faces, [HandCut.of(document) for document in documents])
    if cut.any() and len(cut) - np.count_nonzero(cut) < MIN_TRIANGLES:
        raise BadScan("What was cut away by hand leaves nothing to look at; take one of the cuts back.")
    return faces[~cut]


def _within(cut: HandCut, places: Array) -> Integers:
    """Indices of the (N, 3) m places that the lasso holds."""
    m, (x, y, z) = cut.to_picture, places.T
    w = m[3, 0] * x + m[3, 1] * y + m[3, 2] * z + m[3, 3]
    seen = np.flatnonzero(w > 0.0)
    x, y, z, w = x[seen], y[seen], z[seen], w[seen]
    u = (m[0, 0] * x + m[0, 1] * y + m[0, 2] * z + m[0, 3]) / w
    v = (m[1, 0] * x + m[1, 1] * y + m[1, 2] * z + m[1, 3]) / w
    (left, low), (right, high) = cut.lasso.min(axis=0), cut.lasso.max(axis=0)
    near = np.flatnonzero((u >= left) & (u <= right) & (v >= low) & (v <= high))
    near = near[np.argsort(v[near])]  # then each edge is crossed by places in one row
    u, v = u[near], v[near]
    inside = np.zeros(len(near), dtype=np.bool_)  # a ray to the right crosses an odd number of edges
    for (x_end, y_end), (x_start, y_start) in zip(cut.lasso, np.roll(cut.lasso, 1, axis=0), strict=True):
        if y_end == y_start:
            continue
        first, last = np.searchsorted(v, (min(y_end, y_start), max(y_end, y_start)))  # low <= v < high
        row = slice(int(first), int(last))
        inside[row] ^= u[row] < ((x_start - x_end) * (v[row] - y_end)) / (y_start - y_end) + x_end
    return np.asarray(seen[near[inside]])


LIMIT_BYTES = 1_000_000
MOST_CUTS = 32  # as many as the service keeps of one scan, and corners of one lasso
MOST_CORNERS = 300
BEYOND = 1e9  # no number of a cut is so large
WHAT = "a file of cuts is what GET /api/scans/ID/cuts answers"


def read_cuts(source: Path | Mapping[str, Any]) -> tuple[dict[str, Any], ...]:
    """The cuts of a file, or of what it holds, as `hand_cuts.HandCut.of` reads them.  BadScan with one sentence."""
    document = _document(source) if isinstance(source, Path) else source
    cuts = document.get("cuts") if isinstance(document, Mapping) else None
    if not isinstance(cuts, list) or len(cuts) > MOST_CUTS:
        raise BadScan(f'There is no list "cuts" of at most {MOST_CUTS} in this file; {WHAT}.')
    return tuple(_checked(cut, place) for place, cut in enumerate(cuts, 1))


def _document(file: Path) -> Any:
    try:
        data = read_ordinary(file, LIMIT_BYTES)
        if len(data) > LIMIT_BYTES:
            raise BadScan(f"This file of cuts is larger than {LIMIT_BYTES // 10**6} MB; {WHAT}.")
        return json.loads(data)
    except OSError as error:
        name = shown(str(file))
        raise BadScan(f"The file of cuts {name} cannot be read ({error.strerror}); check the name.") from error
    except (ValueError, RecursionError) as error:
        raise BadScan(f"This file of cuts is not valid JSON; {WHAT}.") from error


def _checked(cut: Any, place: int) -> dict[str, Any]:
    try:
        picture, lasso = np.array(cut["to_picture"], dtype=float), np.array(cut["lasso"], dtype=float)
        is_formed = picture.shape == (16,) and lasso.ndim == 2 and lasso.shape[1] == 2
        if is_formed and 3 <= len(lasso) <= MOST_CORNERS and max(_largest(picture), _largest(lasso)) <= BEYOND:
            return {"to_picture": picture.tolist(), "lasso": lasso.tolist()}
    except (KeyError, TypeError, ValueError, OverflowError):
        pass
    needs = f"it needs 16 numbers to_picture and 3 to {MOST_CORNERS} corners"
    raise BadScan(f"Cut {place} of this file is none: {needs}; {WHAT}.")


def _largest(numbers: Array) -> float:
    """The largest absolute value; infinite where one is no number."""
    return float(np.abs(np.nan_to_num(numbers, nan=np.inf)).max())

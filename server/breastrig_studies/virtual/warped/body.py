"""One warped body from a source and its numbers: both stances, corresponding, with the landmarks that are left."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.sparse.linalg import spsolve
from trimesh.graph import face_adjacency

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.half_edges import neighbours
from breastrig.geometry.normals import face_crosses
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.warped.numbers import HANGING, Numbers, draw_numbers, with_hanging
from breastrig_studies.virtual.warped.proportions import changed
from breastrig_studies.virtual.warped.sources import Lying, Source
from breastrig_studies.virtual.warped.stances import carried, carrier

TENSION = 0.02  # of the graph's Laplacian; 0 is pure bending
MEDIAL = 0.014  # m that stay beside the midline
LATERAL = 0.078  # m outwards of the nipple
ABOVE, BELOW = 0.115, 0.030  # m above the nipple and below the fold
ALONG = 0.19  # m along the skin from the nipple at most, so that the arm stays
FRONT = -0.01  # m; behind it the back begins


def breast_region(vertices: Array, faces: Integers, nipple: Array, fold: Array, middle: float) -> Booleans:
    """(V,) the vertices of a standing body's breast; `middle` is the x of the midline (m)."""
    side = np.sign(nipple[0] - middle)
    out = side * (vertices[:, 0] - middle)
    inner, outer = MEDIAL, side * (nipple[0] - middle) + LATERAL
    low, high = min(fold[1], nipple[1] - 0.02) - BELOW, nipple[1] + ABOVE
    across = (out - 0.5 * (inner + outer)) / (0.5 * (outer - inner))
    along = (vertices[:, 1] - 0.5 * (low + high)) / (0.5 * (high - low))
    inside = (across**2 + along**2 < 1.0) & (vertices[:, 2] > FRONT)
    i, j = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    ways = coo_array((np.linalg.norm(vertices[i] - vertices[j], axis=1), (i, j)), shape=2 * (len(vertices),)).tocsr()
    start = int(np.linalg.norm(vertices - nipple, axis=1).argmin())
    inside &= dijkstra(ways, directed=False, indices=[start], limit=ALONG)[0] < np.inf
    kept = inside[i] & inside[j]
    links = coo_array((np.ones(int(kept.sum())), (i[kept], j[kept])), shape=2 * (len(vertices),))
    _, piece = connected_components(links, directed=False)
    return np.asarray(inside & (piece == piece[start]))


def filled(vertices: Array, faces: Integers, region: Booleans) -> Array:
    """(V, 3) m with the region as the smooth continuation of what is around it."""
    links = neighbours(faces, len(vertices))
    links.data[:] = 1.0
    degree = np.maximum(links.sum(axis=1), 1.0)
    laplacian = csr_array(diags_array(degree) - links)
    energy = csr_array(laplacian @ diags_array(1.0 / degree) @ laplacian + TENSION * laplacian)
    inner = np.flatnonzero(region)
    outer = np.flatnonzero(~region)
    rows = energy[inner]
    result = vertices.copy()
    result[inner] = spsolve(rows[:, inner].tocsc(), -(rows[:, outer] @ vertices[outer]))
    return result


TURNED = 0.0  # cosine between a triangle before and after, turned with its surroundings
SQUEEZED, TORN = 0.15, 6.0  # of its area
FOLDED = -0.3  # cosine between neighbouring triangles: a fold under a breast has 0.1, a triangle turned over near -1
FEW = 0.001  # share of the triangles that may be unsound under a breast that hangs: narrower than a camera sees


def is_sound(before: Array, after: Array, faces: Integers) -> bool:
    """Whether no triangle turns over, collapses or tears between two skins (V, 3) m on the same (F, 3) triangles."""
    old, new = face_crosses(before, faces), face_crosses(after, faces)
    areas, grown = np.linalg.norm(old, axis=1), np.linalg.norm(new, axis=1)
    flat = areas < 1e-9  # m², no triangle to speak of in the source
    cosines = np.einsum("fi,fi->f", old, new) / np.maximum(areas * grown, 1e-18)
    share = grown / np.maximum(areas, 1e-18)
    return bool((flat | ((cosines > TURNED) & (share > SQUEEZED) & (share < TORN))).all())


def is_sound_hanging(before: Array, after: Array, faces: Integers) -> bool:
    """`is_sound` for a body whose breasts came to hang: skin there turns far, but not against the skin beside it."""
    old, new = face_crosses(before, faces), face_crosses(after, faces)
    areas, grown = (np.maximum(np.linalg.norm(each, axis=1), 1e-12) for each in (old, new))
    share = grown / areas
    a, b = face_adjacency(faces).T
    was, came = (
        np.einsum("ei,ei->e", crosses[a], crosses[b]) / (size[a] * size[b])
        for crosses, size in ((old, areas), (new, grown))
    )
    bad = (areas > 1e-9) & ((share < SQUEEZED) | (share > TORN))
    folded = (came < FOLDED) & (was >= FOLDED)
    bad[a[folded]] = True
    return bool(bad.mean() <= FEW)


def bump_shift(vertices: Array, bumps: tuple[tuple[float, ...], ...]) -> Array:
    """(V, 3) m of the bumps, each (which vertex as a share of all, length m, x, y, z m).

    The length is from one flank of the bell to the other: twice its standard deviation.
    """
    shift = np.zeros_like(vertices)
    for share, length, *size in bumps:
        centre = vertices[min(int(share * len(vertices)), len(vertices) - 1)]
        square = ((vertices - centre) ** 2).sum(axis=1)
        shift += np.exp(-2.0 * square / length**2)[:, None] * np.array(size)
    return shift


TRIES = 20


@dataclass(frozen=True, eq=False)
class WarpedBody:
    """A synthetic patient, in body coordinates (m)."""

    source: Source
    numbers: Numbers
    lying: str  # the source's lying model
    tries: int  # how many were drawn until one was sound
    standing: VirtualBody
    supine: VirtualBody


def draw_body(
    source: Source, random: np.random.Generator, hanging: np.random.Generator | None = None, share: float = HANGING
) -> WarpedBody:
    """A body whose triangles are sound in both stances; numbers are drawn again until it is.

    `hanging` decides whether its breasts hang, as a `share` of all do, and how, and leaves all other numbers as they
    are; None: as the source's.
    """
    lying = source.lying[int(random.integers(len(source.lying)))]
    hangs = hanging is not None and bool(hanging.random() < share)
    for tries in range(1, TRIES + 1):
        numbers = draw_numbers(random)
        if hanging is not None and hangs:
            numbers = with_hanging(numbers, hanging)
        body = warped_body(source, lying, numbers, tries)
        if body is not None:
            return body
    raise RuntimeError(f"No sound warp of {source.name} in {TRIES} tries.")


def warped_body(source: Source, lying: Lying, numbers: Numbers, tries: int = 1) -> WarpedBody | None:
    """The body of these numbers; None when a triangle turned over."""
    before = source.standing, lying.vertices
    left_out: set[str] = set()
    if numbers.mastectomy:
        side = numbers.mastectomy
        places = source.landmarks(source.standing)
        nipple, fold = places[f"nipple_{side}"], places[f"inframammary_fold_{side}"]
        region = breast_region(source.standing, source.faces, nipple, fold, float(places["xiphoid"][0]))
        before = filled(before[0], source.faces, region), filled(before[1], source.faces, region)
        left_out = {f"nipple_{side}", f"inframammary_fold_{side}"}
    moved = changed(before[0], source.landmarks, numbers)
    moved = moved + bump_shift(moved, numbers.bumps)
    lain = carried(before[0], moved, before[1], lying.table, carrier(before[0], before[1], source.faces))
    sound = is_sound if numbers.nipples_over_folds is None else is_sound_hanging
    if not (sound(before[0], moved, source.faces) and sound(before[1], lain, source.faces)):
        return None

    def body(stance: str, vertices: Array, table: float | None) -> VirtualBody:
        places = {name: at for name, at in source.landmarks(vertices).items() if name not in left_out}
        return VirtualBody(stance, vertices, places, table)

    standing, supine = body("standing", moved, None), body("supine", lain, lying.table)
    return WarpedBody(source, numbers, lying.kind, tries, standing, supine)

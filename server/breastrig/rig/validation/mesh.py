"""Rules for the surface of a rig: one clean, outward sheet whose triangles survive every single shape."""

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.boundary import boundary_loops, directed_edges
from breastrig.geometry.normals import face_crosses
from breastrig.rig.model import Rig
from breastrig.rig.validation.finding import Finding, named

SLIVER = np.radians(5.0)  # smallest angle of a triangle; thinner ones make normals and projections unsteady
SHARPEST_TURN = np.radians(60.0)  # of a border at one vertex: a cut through quads zigzags by more
TOTAL_TURN = 1.75 * 2.0 * np.pi  # of a whole border; a convex one turns by exactly one full turn


def mesh_findings(rig: Rig) -> list[Finding]:
    """Findings on the surface; requires triangles whose indices are in range."""
    findings = [_used(rig), _manifold(rig), _one_direction(rig), _one_piece(rig)]
    if all(finding.ok for finding in findings):
        loops = boundary_loops(rig.faces)
        findings += [_outwards(rig, loops), _smooth_borders(rig, loops)]
    return [*findings, _template_triangles(rig), _shaped_triangles(rig), _uv(rig)]


def smallest_angles(vertices: Array, faces: Integers) -> Array:
    """(F,) rad: the smallest angle of each triangle; 0 for one without area."""
    corners = vertices[faces]
    sides = [np.linalg.norm(corners[:, (k + 2) % 3] - corners[:, (k + 1) % 3], axis=1) for k in range(3)]
    area = np.linalg.norm(face_crosses(vertices, faces), axis=1)  # twice the area = side · side · sine between
    angles = []
    for k in range(3):
        a, b, c = sides[(k + 1) % 3], sides[(k + 2) % 3], sides[k]
        angles.append(np.arctan2(area, 0.5 * (a**2 + b**2 - c**2)))
    return np.asarray(np.min(angles, axis=0))


def turning(loop: Array) -> Array:
    """(M,) rad: the angle by which a closed (M, 3) polyline turns at each of its points."""
    steps = np.roll(loop, -1, axis=0) - loop
    steps = steps / np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-12)
    return np.asarray(np.arccos(np.clip(np.einsum("mi,mi->m", steps, np.roll(steps, 1, axis=0)), -1.0, 1.0)))


def _used(rig: Rig) -> Finding:
    free = len(rig.template) - len(np.unique(rig.faces))
    detail = f"{free} vertices belong to no triangle: helper geometry?" if free else f"{len(rig.template)} vertices"
    return Finding("every vertex belongs to a triangle", free == 0, detail)


def _manifold(rig: Rig) -> Finding:
    name = "the surface is a manifold"
    edges = np.sort(directed_edges(rig.faces), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    if (counts > 2).any():
        return Finding(name, False, f"{int((counts > 2).sum())} edges belong to more than two triangles.")
    pinched = _pinched(rig.faces, len(rig.template))
    if pinched.any():
        first = int(np.flatnonzero(pinched)[0])
        return Finding(
            name, False, f"at {int(pinched.sum())} vertices (first {first}) two parts of the surface touch in a point."
        )
    return Finding(name, True, f"{len(rig.faces)} triangles, {len(counts)} edges")


def _pinched(faces: Integers, count: int) -> Booleans:
    """(V,) True where the triangles around a vertex form more than one fan."""
    size = faces.size  # one node for each corner of each triangle; corners at one vertex are joined along edges
    corner = np.arange(size).reshape(-1, 3)
    ends, owners = [], []
    for k in range(3):
        a, b = faces[:, k], faces[:, (k + 1) % 3]
        edge = np.minimum(a, b) * count + np.maximum(a, b)
        ends += [edge * count + a, edge * count + b]  # an edge seen from one of its ends
        owners += [corner[:, k], corner[:, (k + 1) % 3]]
    key, node = np.concatenate(ends), np.concatenate(owners)
    order = np.argsort(key, kind="stable")
    same = np.flatnonzero(key[order][1:] == key[order][:-1])
    links = csr_array((np.ones(len(same)), (node[order[same]], node[order[same + 1]])), shape=(size, size))
    fans, label = connected_components(links, directed=False)
    vertex_of_fan = np.zeros(fans, dtype=np.int64)
    vertex_of_fan[label] = faces.ravel()
    return np.asarray(np.bincount(vertex_of_fan, minlength=count) > 1)


def _one_direction(rig: Rig) -> Finding:
    _, counts = np.unique(directed_edges(rig.faces), axis=0, return_counts=True)
    wrong = int((counts > 1).sum())
    detail = f"at {wrong} edges two neighbours run in opposite directions." if wrong else "all neighbours agree"
    return Finding("triangles run in one direction", wrong == 0, detail)


def _one_piece(rig: Rig) -> Finding:
    edges = directed_edges(rig.faces)
    size = len(rig.template)
    graph = csr_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(size, size))
    _, label = connected_components(graph, directed=False)
    pieces = len(np.unique(label[rig.faces[:, 0]]))
    detail = "one piece" if pieces == 1 else f"it falls into {pieces} pieces; keep one."
    return Finding("the surface is one piece", pieces == 1, detail)


def _outwards(rig: Rig, loops: list[Integers]) -> Finding:
    """Whether the surface, closed by a fan at each border, has a positive volume."""
    origin = rig.template.mean(axis=0)
    corners = rig.template[rig.faces] - origin
    volume = float(np.linalg.det(corners).sum()) / 6.0
    for loop in loops:
        rim = rig.template[loop] - origin
        middle = np.broadcast_to(rim.mean(axis=0), rim.shape)
        volume += float(np.linalg.det(np.stack([middle, np.roll(rim, -1, axis=0), rim], axis=1)).sum()) / 6.0
    detail = f"encloses {1e3 * volume:.1f} litres"
    if volume <= 0:
        detail = "the normals point into the body; reverse the triangles."
    return Finding("normals point outwards", volume > 0, detail)


def _smooth_borders(rig: Rig, loops: list[Integers]) -> Finding:
    name = "borders are smooth"
    jagged = []
    for loop in loops:
        turns = turning(rig.template[loop])
        if turns.max() > SHARPEST_TURN or turns.sum() > TOTAL_TURN:
            jagged.append(
                f"the one through vertex {loop[0]} turns by up to {np.degrees(turns.max()):.0f} degrees at a vertex "
                f"and by {turns.sum() / (2 * np.pi):.1f} full turns in all"
            )
    detail = f"{len(loops)} borders of {', '.join(str(len(loop)) for loop in loops) or 'no'} vertices"
    return Finding(name, not jagged, named(jagged) + ": cut it smooth." if jagged else detail, "advice")


def _template_triangles(rig: Rig) -> Finding:
    angles = smallest_angles(rig.template, rig.faces)
    thin = int((angles < SLIVER).sum())
    detail = f"smallest angle {np.degrees(angles.min()):.1f} degrees"
    if thin:
        detail = f"{thin} triangles are slivers (first {int(angles.argmin())}, {detail})."
    return Finding("no slivers in the template", thin == 0, detail)


def _shaped_triangles(rig: Rig) -> Finding:
    """Checks that no triangle turns over or becomes a sliver under any shape at the ends of its range."""
    rest = face_crosses(rig.template, rig.faces)
    bad = []
    thinnest = np.pi
    for shape, displacement in zip(rig.shapes, rig.blendshapes, strict=True):
        for weight in sorted({shape.min, shape.max} - {0.0}):
            vertices = rig.template + weight * displacement
            flipped = int((np.einsum("fi,fi->f", face_crosses(vertices, rig.faces), rest) <= 0).sum())
            angles = smallest_angles(vertices, rig.faces)
            thin = int((angles < SLIVER).sum())
            thinnest = min(thinnest, float(angles.min()))
            if flipped or thin:
                bad.append(f"{shape.name} at {weight:g} ({flipped} turned over, {thin} slivers)")
    detail = named(bad) if bad else f"smallest angle {np.degrees(thinnest):.1f} degrees"
    return Finding("no shape turns a triangle over or makes a sliver", not bad, detail)


def _uv(rig: Rig) -> Finding:
    name = "texture coordinates are there"
    spread = np.ptp(rig.uv, axis=0)
    ok = bool((spread > 1e-3).all()) and bool((rig.uv > -1e-6).all()) and bool((rig.uv < 1 + 1e-6).all())
    detail = "within the unit square" if ok else "they are missing, all the same or outside of the unit square."
    return Finding(name, ok, detail, "advice")

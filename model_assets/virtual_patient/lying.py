"""From standing to lying: what gravity does to breast, belly and back when it turns from the feet to the back.

The breast is taken as a soft incompressible layer of height h on the chest wall.  A layer under a changed body
force shears by h²/(2G) times that force (the Poiseuille profile of thin layers), so its top moves by

    u = stiffness · h² · (Δg_t − |Δg_n| ∇h),     Δg = (0, 1, −1): no longer down, but backwards

with the tangential and normal part of Δg on the chest wall; the second term is the pressure that pushes tall
places apart.  The skin over it is a membrane, which evens u out over a few centimetres.  Continuity then says
how the height follows, δh = −⅔ h ∇·u + ⅓ u·∇h, and what discretisation loses is given back, so that the volume
between skin and chest wall stays.  The load is put on in small steps.

The belly flattens slice by slice with equal area (what it loses in depth it gains in width); the back is pressed
flat by the table.  All numbers are hand-set to look like clinical photographs; nothing here was measured, and
nothing is taken from the model's own shapes.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, diags, identity
from scipy.sparse.linalg import splu

from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import face_areas, face_crosses, vertex_normals

Array = np.ndarray

TURNED_GRAVITY = np.array([0.0, 0.35, -1.0])  # gravity lying minus gravity standing, in units of g
STEPS = 12


@dataclass(frozen=True)
class Tissue:
    """How soft she is."""

    shear: float = 56.0  # 1/m, so that a free layer of 20 mm moves by 25 mm under the whole of gravity
    pressure: float = 2.4  # of the flattening pressure against the shear
    skin: float = 0.012  # m of fat under the skin everywhere, which lets the breast's edge slide too
    membrane: float = 0.026  # m over which the skin evens out the motion
    crease: float = 0.010  # m over which creases of the result are evened out
    belly: float = 0.085  # largest loss of depth of the belly
    pressed: float = 0.016  # m of the back's depth that the table takes away
    bend: float = 0.030  # m over which the pressed back bends back to its own shape


def chest_wall(vertices: Array, faces: Array, footprint: Array) -> Array:
    """(V, 3) m: the surface without its breasts, a smooth sheet across the (V,) bool footprint.

    Solves the biharmonic equation there, which goes on from the surrounding skin with its slope.
    """
    inside, outside = np.flatnonzero(footprint), np.flatnonzero(~footprint)
    laplace, mass = _operators(vertices, faces)
    twice = (laplace @ diags(1.0 / mass) @ laplace).tocsr()
    result = vertices.copy()
    solver = splu(twice[inside][:, inside].tocsc())
    result[inside] = solver.solve(-np.asarray(twice[inside][:, outside] @ vertices[outside]))
    return result


def breasts_lying(vertices: Array, faces: Array, wall: Array, region: Array, tissue: Tissue) -> Array:
    """(V, 3) m: the skin after gravity has turned; only the (V,) bool region moves, its border stays."""
    share = _fade(vertices, faces, region)
    moving, inverse = np.unique(faces[(share[faces] > 0.0).any(axis=1)], return_inverse=True)
    result = vertices.copy()
    part = (vertices[moving], inverse.reshape(-1, 3), wall[moving], share[moving])
    result[moving] = _layer_lying(*part, tissue)
    return result


def _layer_lying(vertices: Array, faces: Array, wall: Array, fade: Array, tissue: Tissue) -> Array:
    """(V, 3) m: the soft layer between skin and wall under the turned gravity, held where `fade` (V,) is 0."""
    search = ClosestPointSearch(wall, faces)
    wall_normals = vertex_normals(wall, faces)
    current = vertices
    volume = _volume(vertices, faces)
    for _ in range(STEPS):
        found = search.query(current)
        normal = np.einsum("mc,mcd->md", found.barycentric, wall_normals[faces[found.faces]])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        laplace, mass = _operators(current, faces)
        even = splu((diags(mass) + tissue.membrane**2 * laplace).tocsc())
        height = fade * np.maximum(np.einsum("vi,vi->v", current - found.points, normal), 0.0)
        height = 0.5 * (height + even.solve(mass * height))
        slope = _gradient(current, faces, height)
        slope /= np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1.0)
        along = TURNED_GRAVITY - (normal @ TURNED_GRAVITY)[:, None] * normal
        against = np.maximum(-(normal @ TURNED_GRAVITY), 0.0)[:, None]
        push = tissue.shear / STEPS * ((height + tissue.skin) ** 2)[:, None]
        motion = even.solve(mass[:, None] * push * (along - tissue.pressure * against * slope))
        motion = fade[:, None] * (motion - np.einsum("vi,vi->v", motion, normal)[:, None] * normal)
        rise = -2.0 / 3.0 * height * _divergence(current, faces, motion)
        rise += np.einsum("vi,vi->v", motion, slope) / 3.0
        current = current + motion + (fade * even.solve(mass * rise))[:, None] * normal
        current = _refilled(current, faces, normal, fade * height, volume)
    moved = fade[:, None] * smoothed(vertices, faces, current - vertices, tissue.crease)
    return _refilled(vertices + moved, faces, normal, fade * height, volume)


def belly_lying(vertices: Array, torso: Array, navel: Array, back: float, tissue: Tissue) -> Array:
    """(V, 3) m: flatter and wider around the navel's height, each slice keeping its area.

    `torso` (V,) is 1 on the trunk and 0 on the arms; `back` is the depth z (m) that stays.
    """
    away = (vertices[:, 1] - navel[1] + 0.01) / np.where(vertices[:, 1] > navel[1] - 0.01, 0.085, 0.11)
    loss = tissue.belly * torso * np.exp(-(away**2))
    result = vertices.copy()
    result[:, 2] = back + (vertices[:, 2] - back) * (1.0 - loss)
    result[:, 0] = vertices[:, 0] / (1.0 - loss)
    return result


def back_on_table(vertices: Array, tissue: Tissue) -> tuple[Array, float]:
    """((V, 3) m, depth z of the table in m): the lowest part of the back is pressed flat."""
    table = float(vertices[:, 2].min()) + tissue.pressed
    below = (vertices[:, 2] - table) / tissue.bend
    result = vertices.copy()  # softplus: far in front unchanged, on the table flat
    result[:, 2] = table + tissue.bend * 0.5 * (below + np.sqrt(below**2 + 0.05))
    return result, table


def _operators(vertices: Array, faces: Array) -> tuple[csr_matrix, Array]:
    """((V, V) positive cotangent Laplacian, (V,) m² mass of each vertex)."""
    corners = vertices[faces]
    size = len(vertices)
    rows, columns, values = [], [], []
    for k in range(3):
        i, j = faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        area = np.maximum(np.linalg.norm(np.cross(a, b), axis=1), 1e-12)
        half = 0.5 * np.clip(np.einsum("fi,fi->f", a, b) / area, -3.0, 6.0)  # very flat triangles are tamed
        rows += [i, j, i, j]
        columns += [j, i, i, j]
        values += [-half, -half, half, half]
    laplace = csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (size, size))
    mass = np.bincount(faces.ravel(), np.repeat(face_areas(vertices, faces) / 3.0, 3), size)
    return laplace, np.maximum(mass, 1e-12)


def _hats(vertices: Array, faces: Array) -> tuple[Array, Array]:
    """((F, 3, 3) gradient of each corner's hat function, (F,) m² areas)."""
    crosses = face_crosses(vertices, faces)
    twice = np.maximum(np.linalg.norm(crosses, axis=1), 1e-12)
    unit = crosses / twice[:, None]
    corners = vertices[faces]
    opposite = np.stack([corners[:, (k + 2) % 3] - corners[:, (k + 1) % 3] for k in range(3)], axis=1)
    return np.cross(unit[:, None, :], opposite) / twice[:, None, None], 0.5 * twice


def _to_vertices(values: Array, areas: Array, faces: Array, size: int) -> Array:
    """(V, ...) area-weighted mean over the triangles around each vertex."""
    total = np.bincount(faces.ravel(), np.repeat(areas, 3), size)
    flat = values.reshape(len(values), -1)
    sums = np.stack([np.bincount(faces.ravel(), np.repeat(areas * column, 3), size) for column in flat.T], axis=1)
    return (sums / np.maximum(total, 1e-12)[:, None]).reshape(size, *values.shape[1:])


def _gradient(vertices: Array, faces: Array, field: Array) -> Array:
    """(V, 3) of a (V,) field along the surface."""
    hats, areas = _hats(vertices, faces)
    return _to_vertices(np.einsum("fc,fci->fi", field[faces], hats), areas, faces, len(vertices))


def _divergence(vertices: Array, faces: Array, field: Array) -> Array:
    """(V,) of a (V, 3) field along the surface."""
    hats, areas = _hats(vertices, faces)
    return _to_vertices(np.einsum("fci,fci->f", field[faces], hats), areas, faces, len(vertices))


def _fade(vertices: Array, faces: Array, region: Array) -> Array:
    """(V,) 1 well inside of the region, falling smoothly to 0 at its border."""
    laplace, mass = _operators(vertices, faces)
    soft = splu((diags(mass) + 0.025**2 * laplace).tocsc()).solve(mass * region)
    share = np.clip((soft - 0.5) / 0.45, 0.0, 1.0)
    return region * share * share * (3.0 - 2.0 * share)


def _volume(vertices: Array, faces: Array) -> float:
    """m³, up to a constant that the moving part does not change."""
    return float(np.einsum("fi,fi->", vertices[faces].mean(axis=1), face_crosses(vertices, faces))) / 6.0


def _refilled(vertices: Array, faces: Array, normal: Array, share: Array, volume: float) -> Array:
    """Moved along the normals in proportion to `share` until the volume is as before."""
    result = vertices
    for _ in range(3):
        crosses = face_crosses(result, faces) / 6.0
        swept = np.stack([np.bincount(faces.ravel(), np.repeat(column, 3), len(vertices)) for column in crosses.T], 1)
        gain = float(np.einsum("v,vi,vi->", share, normal, swept))
        result = result + (volume - _volume(result, faces)) / max(gain, 1e-9) * share[:, None] * normal
    return result


def smoothed(vertices: Array, faces: Array, field: Array, length: float) -> Array:
    """A (V,) or (V, n) field evened out over `length` (m) along the surface."""
    laplace, mass = _operators(vertices, faces)
    solver = splu((diags(mass) + length**2 * laplace + 1e-15 * identity(len(vertices))).tocsc())
    return np.asarray(solver.solve(mass[:, None] * field.reshape(len(field), -1)).reshape(field.shape))

"""Adaptive isotropic remeshing of a surface with borders (Botsch and Kobbelt 2004).

Split edges longer than 4/3 of the wished length, collapse those shorter than 4/5, flip towards even valence and
large angles, relax tangentially, project on the reference; repeat.  Border vertices stay on their border curve
and corners stay where they are, so the cuts come out straight and evenly sampled.  Each new vertex is a mixture
of three vertices of the reference, which is what carries shapes and weights over.
"""

import math
from collections.abc import Callable

import numpy as np
from scipy import sparse

from breastrig.geometry.closest_point import ClosestPointSearch
from steps.source import Array, Booleans, Integers
from steps.surface import Surface

Vector = list[float]  # three numbers
Sizing = Callable[[Array], Array]  # (M, 3) m -> (M,) m, the wished edge length
INSIDE, BORDER, CORNER = 0, 1, 2
LONG, SHORT = 4.0 / 3.0, 0.8


def border_edges(triangles: Integers) -> Integers:
    """(E, 2) directed edges that belong to one triangle only."""
    directed = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    codes = directed[:, 0] * (triangles.max() + 1) + directed[:, 1]
    reverse = directed[:, 1] * (triangles.max() + 1) + directed[:, 0]
    return np.asarray(directed[~np.isin(codes, reverse)])


class _Border:
    """The reference's border curves; each label is one curve family (a cut)."""

    def __init__(self, reference: Surface, labels: dict[str, Booleans]) -> None:
        self.edges = border_edges(reference.triangles)
        names = sorted(labels)
        on = np.stack([labels[name] for name in names], axis=1)  # (V, L)
        self.on = on
        both = on[self.edges[:, 0]] & on[self.edges[:, 1]]
        if not both.any(axis=1).all():
            raise ValueError("A border edge of the reference lies on no cut.")
        self.curve = both.argmax(axis=1)
        self.ends = reference.vertices[self.edges]

    def project(self, points: Array, curves: Integers) -> tuple[Integers, Array]:
        """The closest point on the right curve: ((M, 2) reference vertices, (M, 2) mixture)."""
        a, b = self.ends[:, 0], self.ends[:, 1]
        d = b - a
        vertices = np.zeros((len(points), 2), dtype=np.int64)
        shares = np.zeros((len(points), 2))
        for m, (p, curve) in enumerate(zip(points, curves, strict=True)):
            t = np.clip(((p - a) * d).sum(1) / (d * d).sum(1), 0.0, 1.0)
            gap = ((a + t[:, None] * d - p) ** 2).sum(1)
            gap[self.curve != curve] = np.inf
            best = int(gap.argmin())
            vertices[m] = self.edges[best]
            shares[m] = [1.0 - t[best], t[best]]
        return vertices, shares


class _Mesh:
    """Triangles that can be edited, with the triangles around each vertex."""

    def __init__(self, points: Array, triangles: Integers, kind: Integers, curve: Integers) -> None:
        self.points = list(points)
        self.kind = [int(k) for k in kind]
        self.curve = [int(c) for c in curve]
        self.triangles: dict[int, tuple[int, int, int]] = {}
        self.around: list[set[int]] = [set() for _ in points]
        self._next = 0
        for t in triangles:
            self.add((int(t[0]), int(t[1]), int(t[2])))

    def add(self, t: tuple[int, int, int]) -> None:
        self.triangles[self._next] = t
        for v in t:
            self.around[v].add(self._next)
        self._next += 1

    def remove(self, f: int) -> None:
        for v in self.triangles.pop(f):
            self.around[v].discard(f)

    def neighbours(self, v: int) -> set[int]:
        found: set[int] = set()
        for f in self.around[v]:
            found.update(self.triangles[f])
        found.discard(v)
        return found

    def sides(self, a: int, b: int) -> list[int]:
        return sorted(self.around[a] & self.around[b])

    def edges(self) -> list[tuple[int, int]]:
        return sorted({(min(a, b), max(a, b)) for t in self.triangles.values()
                       for a, b in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0]))})  # fmt: skip

    def corners(self, t: tuple[int, int, int]) -> tuple[Vector, Vector, Vector]:
        """In plain numbers: NumPy takes ten times as long over three of them."""
        return self.points[t[0]].tolist(), self.points[t[1]].tolist(), self.points[t[2]].tolist()

    def normal(self, t: tuple[int, int, int]) -> Vector:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = self.corners(t)
        ux, uy, uz, wx, wy, wz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        return [uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx]


def _length(mesh: _Mesh, a: int, b: int) -> float:
    return math.dist(mesh.points[a], mesh.points[b])


def _dot(u: Vector, w: Vector) -> float:
    return u[0] * w[0] + u[1] * w[1] + u[2] * w[2]


def _between(p: Vector, q: Vector) -> Vector:
    return [q[0] - p[0], q[1] - p[1], q[2] - p[2]]


def _smallest_angle(mesh: _Mesh, t: tuple[int, int, int]) -> float:
    a, b, c = mesh.corners(t)
    ab, bc, ca = _between(a, b), _between(b, c), _between(c, a)
    la, lb, lc = _dot(ab, ab), _dot(bc, bc), _dot(ca, ca)
    cosine = max(
        -_dot(ab, ca) / max(math.sqrt(la * lc), 1e-30),
        -_dot(bc, ab) / max(math.sqrt(lb * la), 1e-30),
        -_dot(ca, bc) / max(math.sqrt(lc * lb), 1e-30),
    )
    return math.acos(min(1.0, max(-1.0, cosine)))


def _split_long(mesh: _Mesh, size: list[float]) -> int:
    done = 0
    for a, b in mesh.edges():
        sides = mesh.sides(a, b)
        wished = 0.5 * (size[a] + size[b])
        if not sides or _length(mesh, a, b) <= LONG * wished:
            continue
        middle = len(mesh.points)
        mesh.points.append(0.5 * (mesh.points[a] + mesh.points[b]))
        mesh.around.append(set())
        size.append(wished)
        on_border = len(sides) == 1
        mesh.kind.append(BORDER if on_border else INSIDE)
        mesh.curve.append(_shared_curve(mesh, a, b) if on_border else -1)
        for f in sides:
            t = mesh.triangles[f]
            mesh.remove(f)
            mesh.add(tuple(middle if v == a else v for v in t))  # type: ignore[arg-type]
            mesh.add(tuple(middle if v == b else v for v in t))  # type: ignore[arg-type]
        done += 1
    return done


def _shared_curve(mesh: _Mesh, a: int, b: int) -> int:
    for v in (a, b):
        if mesh.kind[v] == BORDER:
            return mesh.curve[v]
    raise ValueError("Two corners share a border edge: the sizing is too coarse for this cut.")


def _can_collapse(mesh: _Mesh, gone: int, kept: int, size: list[float]) -> bool:
    sides = mesh.sides(gone, kept)
    if mesh.kind[gone] == CORNER:
        return False
    if mesh.kind[gone] == BORDER:
        if len(sides) != 1 or (mesh.kind[kept] == BORDER and mesh.curve[kept] != mesh.curve[gone]):
            return False
        if mesh.kind[kept] == INSIDE:
            return False
    if len(mesh.neighbours(gone) & mesh.neighbours(kept)) != len(sides):
        return False
    if mesh.kind[gone] == INSIDE and mesh.kind[kept] == INSIDE and len(mesh.around[kept]) + len(mesh.around[gone]) < 8:
        return False
    target = mesh.points[kept]
    for w in mesh.neighbours(gone) - {kept}:
        d = mesh.points[w] - target
        if float(np.sqrt(d @ d)) > LONG * 0.5 * (size[w] + size[kept]):
            return False
    for f in mesh.around[gone]:
        if f in sides:
            continue
        t = mesh.triangles[f]
        before = mesh.normal(t)
        saved, mesh.points[gone] = mesh.points[gone], target
        after = mesh.normal(t)
        angle = _smallest_angle(mesh, t)
        mesh.points[gone] = saved
        if _dot(before, after) <= 0.3 * math.sqrt(_dot(before, before) * _dot(after, after)) or angle < 0.1:
            return False
    return True


def _collapse_short(mesh: _Mesh, size: list[float]) -> int:
    done = 0
    short = [(_length(mesh, a, b) / (size[a] + size[b]), a, b) for a, b in mesh.edges()]
    for _, a, b in sorted(e for e in short if e[0] < 0.5 * SHORT):
        sides = mesh.sides(a, b)
        if not sides or _length(mesh, a, b) >= SHORT * 0.5 * (size[a] + size[b]):
            continue
        for gone, kept in ((a, b), (b, a)) if mesh.kind[a] <= mesh.kind[b] else ((b, a), (a, b)):
            if _can_collapse(mesh, gone, kept, size):
                for f in mesh.sides(gone, kept):
                    mesh.remove(f)
                for f in sorted(mesh.around[gone]):
                    t = mesh.triangles[f]
                    mesh.remove(f)
                    mesh.add(tuple(kept if v == gone else v for v in t))  # type: ignore[arg-type]
                done += 1
                break
    return done


def _flip(mesh: _Mesh, by_angle: bool) -> int:
    done = 0
    for a, b in mesh.edges():
        sides = mesh.sides(a, b)
        if len(sides) != 2:
            continue
        first, second = mesh.triangles[sides[0]], mesh.triangles[sides[1]]
        if first[(first.index(a) + 1) % 3] != b:
            first, second = second, first
        c = next(v for v in first if v not in (a, b))
        d = next(v for v in second if v not in (a, b))
        if d in mesh.neighbours(c):
            continue
        new = (c, a, d), (d, b, c)
        old_normal = [u + w for u, w in zip(mesh.normal(first), mesh.normal(second), strict=True)]
        if any(_dot(mesh.normal(t), old_normal) <= 0.0 for t in new):
            continue
        old_angle = min(_smallest_angle(mesh, first), _smallest_angle(mesh, second))
        new_angle = min(_smallest_angle(mesh, new[0]), _smallest_angle(mesh, new[1]))
        if by_angle:
            better = new_angle > old_angle + 1e-6
        else:
            wished = [4 if mesh.kind[v] else 6 for v in (a, b, c, d)]
            valence = [len(mesh.neighbours(v)) for v in (a, b, c, d)]
            before = sum((v - w) ** 2 for v, w in zip(valence, wished, strict=True))
            after = sum((v + s - w) ** 2 for v, w, s in zip(valence, wished, (-1, -1, 1, 1), strict=True))
            better = (after < before and new_angle > 0.6 * old_angle) or new_angle > 1.5 * old_angle
        if better:
            for f in sides:
                mesh.remove(f)
            for t in new:
                mesh.add(t)
            done += 1
    return done


def _packed(mesh: _Mesh) -> tuple[Array, Integers, Integers, Integers]:
    triangles = np.array([mesh.triangles[f] for f in sorted(mesh.triangles)])
    used, inverse = np.unique(triangles, return_inverse=True)
    points = np.array([mesh.points[v] for v in used])
    kind = np.array([mesh.kind[v] for v in used])
    curve = np.array([mesh.curve[v] for v in used])
    return points, inverse.reshape(-1, 3), kind, curve


def _relaxed(points: Array, triangles: Integers, kind: Integers, curve: Integers, sizing: Sizing) -> Array:
    """Each vertex towards the mean of its triangles' centres, weighted by area over wished area, along the surface."""
    corners = points[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    centre = corners.mean(axis=1)
    weight = area / sizing(centre) ** 2
    total, moment, normal = np.zeros(len(points)), np.zeros_like(points), np.zeros_like(points)
    for i in range(3):
        np.add.at(total, triangles[:, i], weight)
        np.add.at(moment, triangles[:, i], weight[:, None] * centre)
        np.add.at(normal, triangles[:, i], cross)
    step = moment / total[:, None] - points
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    step -= (step * normal).sum(1, keepdims=True) * normal
    result = points + 0.6 * step * (kind == INSIDE)[:, None]

    edges = border_edges(triangles)
    pull, count = np.zeros_like(points), np.zeros(len(points))
    wished = sizing(points[edges].mean(axis=1))
    for i, j in ((0, 1), (1, 0)):
        d = points[edges[:, j]] - points[edges[:, i]]
        length = np.linalg.norm(d, axis=1, keepdims=True)
        np.add.at(pull, edges[:, i], d / length * (length / wished[:, None]))
        np.add.at(count, edges[:, i], 1.0)
    on_border = kind == BORDER
    scale = sizing(points)[:, None]
    return np.where(on_border[:, None], points + 0.25 * scale * pull, result)


def remesh(
    reference: Surface, labels: dict[str, Booleans], sizing: Sizing, rounds: int
) -> tuple[Surface, dict[str, Booleans]]:
    """A new mesh of the same surface: (surface, for each cut the (V,) bools of the vertices that lie on it).

    `labels` says for each cut which reference vertices (V,) lie on it; a vertex on two cuts is a corner.
    """
    border = _Border(reference, labels)
    names = sorted(labels)
    on = border.on
    is_border = np.zeros(len(reference.vertices), dtype=bool)
    is_border[border.edges.ravel()] = True
    kind = np.where(is_border, np.where(on.sum(axis=1) > 1, CORNER, BORDER), INSIDE)
    curve = np.where(kind == BORDER, on.argmax(axis=1), -1)
    corners = np.flatnonzero(kind == CORNER)
    search = ClosestPointSearch(reference.vertices, reference.triangles)
    points, triangles = reference.vertices, reference.triangles
    for turn in range(rounds):
        mesh = _Mesh(points, triangles, kind, curve)
        size = [float(s) for s in sizing(points)]
        _split_long(mesh, size)
        _collapse_short(mesh, size)
        for _ in range(2):
            _flip(mesh, by_angle=turn > rounds // 2)
        points, triangles, kind, curve = _packed(mesh)
        for _ in range(3):
            points = _relaxed(points, triangles, kind, curve, sizing)
            points = _project(points, kind, curve, reference, border, search)[0]
    mesh = _Mesh(points, triangles, kind, curve)
    while _flip(mesh, by_angle=True):
        pass
    points, triangles, kind, curve = _packed(mesh)
    points, index, share = _project(points, kind, curve, reference, border, search)
    for v in np.flatnonzero(kind == CORNER):
        nearest = corners[((reference.vertices[corners] - points[v]) ** 2).sum(1).argmin()]
        index[v], share[v] = nearest, [1.0, 0.0, 0.0]
    count = len(points)
    matrix = sparse.csr_matrix(
        (share.ravel(), (np.repeat(np.arange(count), 3), index.ravel())), (count, len(reference.vertices))
    )
    result = Surface(matrix @ reference.vertices, triangles, (matrix @ reference.mix).tocsr())
    found: dict[str, Booleans] = {}
    for k, name in enumerate(names):
        flag = (kind == BORDER) & (curve == k)
        for v in np.flatnonzero(kind == CORNER):
            flag[v] = on[index[v, 0], k]
        found[name] = flag
    return result, found


def _project(
    points: Array, kind: Integers, curve: Integers, reference: Surface, border: _Border, search: ClosestPointSearch
) -> tuple[Array, Integers, Array]:
    """(points, (V, 3) reference vertices, (V, 3) mixture) after projection on the surface or the border curve."""
    nearest = search.query(points)
    index = reference.triangles[nearest.faces].copy()
    share = nearest.barycentric.copy()
    on_border = np.flatnonzero(kind == BORDER)
    pair, mixture = border.project(points[on_border], curve[on_border])
    index[on_border, :2], index[on_border, 2] = pair, pair[:, 0]
    share[on_border, :2], share[on_border, 2] = mixture, 0.0
    result = np.einsum("mc,mcd->md", share, reference.vertices[index])
    still = kind == CORNER
    result[still] = points[still]
    return result, index, share

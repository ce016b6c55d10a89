"""Maps points of one scan to the same skin on another scan of the same patient.

The model knows which skin is which only as well as its shapes do: two fits that lie on their scans to a
millimetre may still disagree along the skin by ten.  The picked landmarks know better where they are, the
scans' surfaces know the depth, and skin stretches smoothly.  So the way from A to B is a rigid motion plus a
smooth displacement u(x), a Gaussian process with three kinds of observations, each weighed by its error:

* landmarks present in both scans, picked by a person or seen by their colours, and marks that both scans have and that
  contradict nothing (marks.py),
* the surface of scan B: points of A must arrive on it (only along its normal),
* the two fitted models: the same point of the model on A and on B, weakly; without landmarks they are all there is.

    min_w  |w|² + Σ_l |a_l + u(a_l) − b_l|²/σ_l² + Σ_m |...|²/σ_m² + Σ_i (n_i · (x_i + u(x_i) − p_i))²/σ_n²

u = H w with the columns of H made from the Matérn-5/2 kernel at some points of A (w is white, so the prior is
|w|²), a small affine part, and the ways in which women's skin differs when they lie down.  All numbers are in
skin_maps/, one file for each rig.  Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, chapters 2
and 4.

Between standing and lying the displacement is expected around what skin does in everybody: arms go up, breasts sink
outwards, and no landmark is on the outer side to tell.  How far a woman's do, landmarks and surface say by those ways.

Evidence: docs/decisions/0008.
"""

from dataclasses import dataclass, field

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadDrawing
from breastrig.correspondence.match import Correspondences, MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.skin_maps.lying_motion import lying_motion
from breastrig.drawings.skin_maps.marks import SharedMarks, agreeing
from breastrig.drawings.skin_maps.settings import SkinMapSettings, skin_map_settings
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.least_squares.quadratic_program import cholesky, solve_lower
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama

INVERSE_ROUNDS = 8  # each leaves the way's local stretch, at most a third, of the gap
MIN_SEEN = 30  # vertices of the model that must lie on each scan


@dataclass(frozen=True, eq=False)
class FittedScan:
    """One scan with its fitted model, all in the scan target's frame (m)."""

    target: ScanTarget
    vertices: Array  # (V, 3) of the model
    landmarks: dict[str, Array]  # picked and not doubted, (3,)
    stance: str  # standing | supine | prone
    radii: Array | None = None  # (V,) m, each holds the vertex's true place with 90 %; None: not known
    seen: dict[str, Array] = field(default_factory=dict)  # (3,) landmarks that the scan's colours show
    predicted: bool = False  # no scan shows the patient so
    wall: ClosestPointSearch | None = None  # the chest wall that the scan shows, triangles towards the front
    marks: dict[str, Array] = field(default_factory=dict)  # (3,) on the scan's skin, of any names
    _shared: dict["FittedScan", SharedMarks] = field(default_factory=dict, init=False, repr=False)
    _searches: dict[Rig, ClosestPointSearch] = field(default_factory=dict, init=False, repr=False)

    @property
    def known(self) -> dict[str, Array]:
        """(3,) landmarks that are known better than by the model: picked, or observed."""
        return self.seen | self.landmarks

    def search(self, rig: Rig) -> ClosestPointSearch:
        """Closest-point search on the fitted model, built once."""
        if rig not in self._searches:
            self._searches[rig] = ClosestPointSearch(self.vertices, rig.faces)
        return self._searches[rig]


class SkinMap:
    """The smooth way from scan A to scan B and back; built once, then asked for any points."""

    def __init__(
        self,
        rig: Rig,
        a: FittedScan,
        b: FittedScan,
        settings: SkinMapSettings | None = None,
        motion: Array | None = None,
        ways: bool = True,
        marks: bool = True,
    ) -> None:
        """Fits the map with the rig's settings and its (1 + K, V, 3) m motions (lying_motion.py), or others.

        Without `ways` only the mean motion is used, without `marks` none of them is followed.  Raises BadDrawing when a
        model does not lie on its scan.
        """
        self._rig, self._a, self._b = rig, a, b
        lies_down = a.stance == "standing" and b.stance == "supine"
        expected = lying_motion(rig) if motion is None and lies_down else motion
        still = np.zeros((1, len(rig.template), 3))
        turned = (still if expected is None else expected if ways else expected[:1]) @ umeyama(
            rig.template, b.vertices
        ).rotation.T
        self._moves = np.moveaxis(turned, 0, -1).reshape(len(rig.template), -1)  # (V, 3 (1 + K))
        self._settings = own = settings or skin_map_settings(rig)
        on_scan = MatchRules("rays", own.on_scan_distance, own.on_scan_angle)
        seen = match(a.target, a.vertices, _normals(rig, a.vertices), on_scan)
        near = within_reach(rig, a.vertices, seen.points)
        on_a = Correspondences(seen.vertices[near], seen.points[near], seen.normals[near], seen.distances[near])
        on_b = match(b.target, b.vertices, _normals(rig, b.vertices), on_scan)
        if min(len(on_a.vertices), len(on_b.vertices)) < MIN_SEEN:
            raise BadDrawing("A fitted model does not lie on its scan; fit it again before carrying points.")
        self._source, self._goal = a.vertices[on_a.vertices].mean(axis=0), b.vertices[on_a.vertices].mean(axis=0)
        self._turn = umeyama(a.vertices[on_a.vertices], b.vertices[on_a.vertices]).rotation
        self._centre = on_a.points.mean(axis=0)
        self._kernel_points = on_a.points[spread_out(on_a.points, own.centres)]
        gram = _matern(_gaps(self._kernel_points, self._kernel_points) / own.length)
        self._factor = cholesky(gram + 1e-9 * np.eye(len(gram)))
        self._weights = self._solved(on_a, ())
        names = tuple(name for name in a.marks if name in b.marks) if marks else ()
        self.marks = self._agreeing(names) if names else SharedMarks()
        if names:
            a._shared[b] = b._shared[a] = self.marks
        if self.marks.followed:
            self._weights = self._solved(on_a, self.marks.followed)
        self._moved_model = ClosestPointSearch(self.moved(a.vertices), rig.faces)

    def expected(self, points: Array) -> Array:
        """(M, 3) m: expected locations of (M, 3) m points of A: a rigid motion, and the mean motion of the skin."""
        return np.asarray((points - self._source) @ self._turn.T + self._goal + self._motions(points)[:, :, 0])

    def _motions(self, points: Array) -> Array:
        """(M, 3, 1 + K) m: mean motion of the skin at (M, 3) points of A, and its modes of variation."""
        at = self._a.search(self._rig).query(points).on_mesh
        return at.positions(self._moves, self._rig.faces).reshape(len(points), 3, self._moves.shape[1] // 3)

    def _basis(self, points: Array) -> Array:
        """(M, 3, W) the displacements' basis H at (M, 3) points of A."""
        own = self._settings
        kernel = _matern(_gaps(points, self._kernel_points) / own.length)
        smooth = own.displacement * solve_lower(self._factor, kernel.T).T
        shift = np.full((len(points), 1), own.shift_length)
        each = np.concatenate([smooth, own.strain * shift, own.strain * (points - self._centre)], axis=1)
        axes = np.einsum("mk,ij->mijk", each, np.eye(3)).reshape(len(points), 3, 3 * each.shape[1])
        return np.concatenate([axes, self._motions(points)[:, :, 1:]], axis=2)

    def _agreeing(self, names: tuple[str, ...]) -> SharedMarks:
        """The marks of these names that contradict neither each other nor the map without marks."""
        here, there = (np.array([scan.marks[name] for name in names]) for scan in (self._a, self._b))
        return agreeing(names, here, there - self.moved(here), self._settings)

    def _solved(self, on_a: Correspondences, marks: tuple[str, ...]) -> Array:
        """(W,) the weights w, with the marks of these names."""
        a, b, own = self._a, self._b, self._settings
        names = [name for name in a.known if name in b.known]
        chosen = spread_out(on_a.points, own.model_points)
        known = [
            np.array([*(scan.known[name] for name in names), *(scan.marks[name] for name in marks)]).reshape(-1, 3)
            for scan in (a, b)
        ]
        off = np.array([own.landmark_error] * len(names) + [own.mark_error] * len(marks))[:, None]
        start, basis = self.expected(on_a.points), self._basis(on_a.points)
        size = basis.shape[2]
        at_landmarks, at_model = self._basis(known[0]) / off[..., None], basis[chosen] / own.model_error
        rows = np.concatenate([at_landmarks.reshape(-1, size), at_model.reshape(-1, size)])
        to_landmarks = (known[1] - self.expected(known[0])) / off
        to_model = (b.vertices[on_a.vertices[chosen]] - start[chosen]) / own.model_error
        placed = rows.T @ rows + np.eye(size)
        pull = rows.T @ np.concatenate([to_landmarks.ravel(), to_model.ravel()])
        weights = _solution(placed, pull)
        moved = self.expected(a.vertices)
        to_scan = MatchRules("tree", own.to_scan_distance, own.to_scan_angle)
        for _ in range(own.rounds - 1):
            moved[on_a.vertices] = start + basis @ weights
            normals = _normals(self._rig, moved)[on_a.vertices]
            found = match(b.target, moved[on_a.vertices], normals, to_scan)
            trust = 1.0 / (1.0 + (found.distances / own.surface_scale) ** 2) / own.surface_error  # Geman-McClure's root
            across = trust[:, None] * found.normals
            jacobian = np.einsum("mik,mi->mk", basis[found.vertices], across)
            depth = np.einsum("mi,mi->m", across, found.points - start[found.vertices])
            weights = _solution(placed + jacobian.T @ jacobian, pull + jacobian.T @ depth)
        return weights

    def moved(self, points: Array) -> Array:
        """(M, 3) m: points of A's frame moved into B's frame, not yet on B's skin."""
        return np.asarray(self.expected(points) + self._basis(points) @ self._weights)

    def moved_back(self, points: Array) -> Array:
        """(M, 3) m: points of B's frame moved into A's frame, not yet on A's skin: the inverse of `moved`."""
        at = self._moved_model.query(points).on_mesh.positions(self._a.vertices, self._rig.faces)
        for _ in range(INVERSE_ROUNDS):
            at = at + (points - self.moved(at)) @ self._turn
        return np.asarray(at)

    def to_b(self, points: Array) -> Array:
        """(M, 3) m: the skin of A at (M, 3) points, on the surface of scan B."""
        return np.asarray(self._b.target.search.query(self.moved(points)).points)

    def to_a(self, points: Array) -> Array:
        """(M, 3) m: the skin of B at (M, 3) points, on the surface of scan A."""
        return np.asarray(self._a.target.search.query(self.moved_back(points)).points)


def shared_marks(rig: Rig, a: FittedScan, b: FittedScan) -> SharedMarks:
    """The marks that both scans have; which of them contradict the rest is found by the map, once.

    Raises BadDrawing when a model does not lie on its scan.
    """
    if a.marks.keys().isdisjoint(b.marks):
        return SharedMarks()
    if b not in a._shared:
        _ = SkinMap(rig, b, a) if a.stance == "supine" and b.stance != "supine" else SkinMap(rig, a, b)
    return a._shared[b]


def carried(rig: Rig, a: FittedScan, b: FittedScan, points: Array) -> Array:
    """(M, 3) m: the skin of scan A at (M, 3) points, on the surface of scan B.

    Between a standing and a lying scan the way starts at the standing one, where the breast is roundest, and is
    gone backwards when needed: the other way round is 1 mm worse.
    """
    if a.stance == "supine" and b.stance != "supine":
        return SkinMap(rig, b, a).to_a(points)
    return SkinMap(rig, a, b).to_b(points)


def spread_out(points: Array, count: int) -> Integers:
    """(≤ count,) indices of points far from each other (farthest-point sampling)."""
    count = min(count, len(points))
    chosen = np.zeros(count, dtype=np.int64)
    gaps = np.linalg.norm(points - points[0], axis=1)
    for k in range(1, count):
        chosen[k] = int(gaps.argmax())
        gaps = np.minimum(gaps, np.linalg.norm(points - points[chosen[k]], axis=1))
    return chosen


def _normals(rig: Rig, vertices: Array) -> Array:
    return vertex_normals(vertices, rig.faces)


def within_reach(rig: Rig, vertices: Array, points: Array) -> Booleans:
    """(M,) whether (M, 3) m points are near enough to the breasts for the skin to be followed; all for a rig without.

    `vertices` (V, 3) m are the fitted model's, in the points' frame.
    """
    if not {"breast_L", "breast_R"} <= rig.regions.keys():
        return np.ones(len(points), dtype=np.bool_)
    left, right = (vertices[rig.regions[name]].mean(axis=0) for name in ("breast_L", "breast_R"))
    across = right - left
    share = np.clip((points - left) @ across / (across @ across), 0.0, 1.0)
    gaps = np.linalg.norm(points - left - share[:, None] * across, axis=1)
    return np.asarray(gaps < skin_map_settings(rig).reach)


def _gaps(points: Array, others: Array) -> Array:
    """(M, K) m between (M, 3) and (K, 3) points."""
    apart = points[:, None] - others
    return np.asarray(np.sqrt(np.einsum("mki,mki->mk", apart, apart)))


def _solution(matrix: Array, right: Array) -> Array:
    """(N,) of a symmetric positive definite (N, N) system."""
    factor = cholesky(matrix)
    return solve_lower(factor, solve_lower(factor, right), transposed=True)


def _matern(distances: Array) -> Array:
    """Matérn 5/2 of unit size and length."""
    r = np.sqrt(5.0) * distances
    return np.asarray((1.0 + r + r * r / 3.0) * np.exp(-r))

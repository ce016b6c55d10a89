"""Occlusion and closure of scans: clothes, closed surfaces, the scanner's pose, and small parts of a body.

Each condition changes a scan of a body whose true landmarks are known; made by formula, in the body's own axes.
docs/decisions/0026.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_closing, binary_erosion, binary_fill_holes, gaussian_filter, map_coordinates
from scipy.spatial import Delaunay

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.boundary import boundary_edges
from breastrig.geometry.normals import face_crosses, vertex_normals
from breastrig.geometry.rotations import exp_so3
from breastrig.scan.clean import compact, large_pieces
from breastrig_studies.virtual.depth_fusion import surface_nets
from breastrig_studies.virtual.warped.captures import shown

Landmarks = Mapping[str, Array]  # (3,) m
Mesh = tuple[Array, Integers]  # (V, 3) m, +X left, +Y head, +Z front, about the xiphoid; (F, 3)

SOFT = 0.004  # m, over which the edge of what is worn rises
CUP = 1.5  # of the way from nipple to fold: radius of a cup
BRIDGED = 40  # rounds of averaging: a cup spans folds and cleavage
BAND, STRAP = 0.02, 0.009  # m, half the widths
CLOTH, DRESSING = 0.003, 0.0025  # m thick
PLASTERS = (0.03, 0.045, 0.05)  # m: half the sides of a plaster, and how far it may lie from the landmark
LOCK = (0.01, 0.03), (0.03, 0.05), (0.06, 0.12)  # m: thickness, half the width and middle of hair to each side
CREASES, ROLL = (0.04, 0.08), (0.03, 0.06)  # m, under the navel at most, under the breasts at least; of a roll
BACK = 0.02  # m behind the shoulders' tips, where only a front was seen
WALL = (0.02, 0.06)  # m from the ragged border to the plate behind it
CELL, OUTLINE = 0.01, 3  # m, and cells: how near the outline a border is the outer one
SOLVED, NARROW = 0.005, 1.0  # m, a voxel of Poisson's surface; voxels, to which normals are blurred
MARGIN = 0.12  # m around the body
TILTED = 8.0  # degrees, of a scanner in the hand
FACING, DEEPEST = 0.3, -0.15  # cosine, and m behind the xiphoid: what one camera sees
ABOVE, BELOW, BESIDE = 0.03, 0.05, 0.03  # m around notch, folds and nipples: one picture of the breasts


def with_bra(mesh: Mesh, marks: Landmarks, random: np.random.Generator) -> Mesh:
    """Cups that span what they cover, a band under them and straps over the shoulders."""
    vertices, faces = mesh
    cups = np.zeros(len(vertices))
    for side in "LR":
        nipple, fold = marks.get(f"nipple_{side}"), marks.get(f"inframammary_fold_{side}")
        if nipple is not None and fold is not None:
            away = np.linalg.norm((vertices - nipple)[:, :2], axis=1)
            cups = np.maximum(cups, _edge(CUP * np.linalg.norm((nipple - fold)[:2]) - away) * (vertices[:, 2] > -0.05))
    smooth = vertices.copy()
    for _ in range(BRIDGED):
        smooth += 0.5 * cups[:, None] * (_neighbours_mean(smooth, faces) - smooth)
    folds = [at for name, at in marks.items() if name.startswith("inframammary")] or [marks["xiphoid"]]
    level, aside = np.mean([at[1] for at in folds]), np.mean([abs(marks[f"midclavicle_{s}"][0]) for s in "LR"])
    band = _edge(BAND - np.abs(vertices[:, 1] - level + BAND)) * (np.abs(vertices[:, 0]) < 0.2)
    straps = _edge(STRAP - np.abs(np.abs(vertices[:, 0]) - aside)) * (vertices[:, 1] > level)
    return _thicker((smooth, faces), CLOTH * np.maximum(cups, np.maximum(band, straps)))


def with_plaster(mesh: Mesh, marks: Landmarks, random: np.random.Generator) -> Mesh:
    """A dressing of some centimetres, somewhere on a breast."""
    at = marks[random.choice([name for name in marks if name.startswith(("nipple", "inframammary"))])]
    gaps = mesh[0] - at - random.uniform(-PLASTERS[2], PLASTERS[2], 3) * (1.0, 1.0, 0.0)
    here = (
        _edge(PLASTERS[0] - np.abs(gaps[:, 0])) * _edge(PLASTERS[1] - np.abs(gaps[:, 1])) * (np.abs(gaps[:, 2]) < 0.1)
    )
    return _thicker(mesh, DRESSING * here)


def with_long_hair(mesh: Mesh, marks: Landmarks, random: np.random.Generator) -> Mesh:
    """Before both shoulders, down to the nipples' height."""
    vertices, faces = mesh[0].copy(), mesh[1]
    nipples = [at[1] for name, at in marks.items() if name.startswith("nipple")] or [0.0]
    for side in (-1.0, 1.0):
        thick, half, middle = (random.uniform(*each) for each in LOCK)
        end = np.mean(nipples) + random.uniform(-0.03, 0.03)
        aside = (side * vertices[:, 0] - middle) / half
        lock = (
            np.exp(-(aside**4)) * _edge(vertices[:, 1] - end) * (vertices[:, 2] > marks["suprasternal_notch"][2] - 0.1)
        )
        vertices[:, 2] += thick * lock * (1.0 + 0.3 * np.sin(6.0 * aside))
    return vertices, faces


def belly_folds(mesh: Mesh, marks: Landmarks, random: np.random.Generator) -> Mesh:
    """Rolls of a belly that hang over creases, and flanks, farther out than the model's shapes reach."""
    vertices, faces = mesh[0].copy(), mesh[1]
    navel = marks["umbilicus"][1] if "umbilicus" in marks else -0.18
    lowest = min([at[1] for name, at in marks.items() if name.startswith(("nipple", "inframammary"))] or [0.0])
    for crease in random.uniform(navel - CREASES[0], max(navel, lowest - CREASES[1]), int(random.integers(1, 3))):
        above = vertices[:, 1] - crease
        out, wide = random.uniform(*ROLL), np.exp(-((vertices[:, 0] / 0.2) ** 4)) * (vertices[:, 2] > -0.08)
        roll = np.exp(-(((above - 0.03) / 0.03) ** 2))
        vertices[:, 2] += out * wide * (roll - 0.5 * np.exp(-((above / 0.012) ** 2)))
        vertices[:, 1] -= 0.8 * out * wide * roll
        vertices[:, 0] += 0.7 * out * roll * np.clip(vertices[:, 0] / 0.12, -1.0, 1.0) * (np.abs(vertices[:, 0]) < 0.22)
    return vertices, faces


def flat_back(mesh: Mesh, marks: Landmarks, random: np.random.Generator) -> Mesh:
    """Only the front, its ragged border moved on a plate that closes it."""
    return _closed(_front(mesh, marks), 0.0)


def walled_back(mesh: Mesh, marks: Landmarks, random: np.random.Generator) -> Mesh:
    """Only the front, its border drawn out to a plate behind it."""
    return _closed(_front(mesh, marks), random.uniform(*WALL))


def poisson_lids(mesh: Mesh, marks: Landmarks, random: np.random.Generator) -> Mesh:
    """A closed surface by Poisson's equation (Kazhdan, Bolitho and Hoppe 2006) on a regular grid."""
    vertices, faces = mesh
    crosses = vertex_normals(vertices, faces)
    low = vertices.min(axis=0) - MARGIN
    size = np.ceil((vertices.max(axis=0) + MARGIN - low) / SOLVED).astype(np.int64)
    places = (vertices - low) / SOLVED
    field = np.zeros((3, *size))
    np.add.at(field, (slice(None), *np.rint(places).astype(np.int64).T), crosses.T)
    field = np.stack([gaussian_filter(each, NARROW) for each in field])
    waves = np.meshgrid(*(np.fft.fftfreq(n) for n in size[:2]), np.fft.rfftfreq(size[2]), indexing="ij")
    square = np.maximum(sum(wave**2 for wave in waves), 1e-12)
    along = sum(1j * wave * np.fft.rfftn(part) for wave, part in zip(waves, field, strict=True))
    solved = np.fft.irfftn(-along / square, tuple(size), (0, 1, 2))
    solved -= map_coordinates(solved, places.T, order=1).mean()
    vertices, faces = surface_nets(solved, np.ones(solved.shape, dtype=np.bool_))
    return compact(vertices * SOLVED + low, faces[large_pieces(vertices, faces)[0]])


def front_only(mesh: Mesh, marks: Landmarks, random: np.random.Generator) -> Mesh:
    """The mesh that one camera in front of the body sees."""
    vertices, faces = mesh
    seen: Booleans = (vertex_normals(vertices, faces)[:, 2] > FACING) & (vertices[:, 2] > DEEPEST)
    return _kept(mesh, seen)


def breasts_only(mesh: Mesh, marks: Landmarks, random: np.random.Generator) -> Mesh:
    """The front between collar bones and folds, as one picture shows it."""
    folds = [at[1] for name, at in marks.items() if name.startswith("inframammary")] or [0.0]
    low, high = min(folds) - BELOW, marks["suprasternal_notch"][1] + ABOVE
    wide = max(abs(at[0]) for name, at in marks.items() if name.startswith(("nipple", "midclavicle"))) + BESIDE
    vertices, faces = front_only(mesh, marks, random)
    inside: Booleans = (np.abs(vertices[:, 1] - 0.5 * (low + high)) < 0.5 * (high - low)) & (
        np.abs(vertices[:, 0]) < wide
    )
    return _kept((vertices, faces), inside)


def _part(capture: str) -> "Condition":
    def part(mesh: Mesh, marks: Landmarks, random: np.random.Generator) -> Mesh:
        return _kept(mesh, shown(mesh[0], dict(marks), capture))

    return part


def _as_it_is(mesh: Mesh, marks: Landmarks, random: np.random.Generator) -> Mesh:
    return mesh


Condition = Callable[[Mesh, Landmarks, np.random.Generator], Mesh]
PARTS = ("left_half", "one_side", "above_nipples", "below_nipples")
CONDITIONS: dict[str, Condition] = {
    "as_it_is": _as_it_is,
    "bra": with_bra,
    "plaster": with_plaster,
    "long_hair": with_long_hair,
    "belly_folds": belly_folds,
    "flat_back": flat_back,
    "walled_back": walled_back,
    "poisson": poisson_lids,
    "portrait": _as_it_is,
    "landscape": _as_it_is,
    "front_only": front_only,
    "breasts_only": breasts_only,
    **{name: _part(name) for name in PARTS},
}
HELD = {"portrait": 0.0, "landscape": 90.0}  # degrees about the view; the scanner's axes, +Y up in its picture


def as_captured(
    condition: str, vertices: Array, faces: Integers, marks: Landmarks, random: np.random.Generator
) -> tuple[Array, Integers, dict[str, Array]]:
    """The scan with (V, 3) m vertices under this condition, and where the true landmarks then are.

    In the scan's own frame, but where it matters how the scanner was held.
    """
    axes, origin = body_frame(marks)
    local = {name: (at - origin) @ axes for name, at in marks.items()}
    changed, triangles = CONDITIONS[condition](((vertices - origin) @ axes, faces), local, random)
    if condition in HELD:
        roll = np.radians(HELD[condition] * random.choice([-1.0, 1.0]))
        axes = exp_so3(np.array([0.0, 0.0, roll])) @ exp_so3(np.radians(random.normal(0.0, TILTED, 3)))
    turned = {name: at @ axes.T + origin for name, at in local.items()}
    return changed @ axes.T + origin, triangles, turned


def body_frame(marks: Landmarks) -> tuple[Array, Array]:
    """((3, 3) the patient's left, up and front as columns, (3,) m xiphoid)."""
    up = marks["suprasternal_notch"] - marks["xiphoid"]
    up = marks["suprasternal_notch"] - marks["umbilicus"] if "umbilicus" in marks else up
    up = up / np.linalg.norm(up)
    left = marks["midclavicle_L"] - marks["midclavicle_R"]
    left = left - (left @ up) * up
    left /= np.linalg.norm(left)
    return np.column_stack([left, up, np.cross(left, up)]), marks["xiphoid"]


def _edge(inside: Array) -> Array:
    """0 outside, 1 where it is SOFT (m) or farther inside."""
    return np.asarray(np.clip(inside / SOFT, 0.0, 1.0))


def _thicker(mesh: Mesh, by: Array) -> Mesh:
    return mesh[0] + by[:, None] * vertex_normals(*mesh), mesh[1]


def _neighbours_mean(vertices: Array, faces: Integers) -> Array:
    total, count = np.zeros_like(vertices), np.zeros(len(vertices))
    for k in range(3):
        for other in (1, 2):
            np.add.at(total, faces[:, k], vertices[faces[:, (k + other) % 3]])
            np.add.at(count, faces[:, k], 1.0)
    return np.where(count[:, None] > 0.0, total / np.maximum(count, 1.0)[:, None], vertices)


def _kept(mesh: Mesh, chosen: Booleans) -> Mesh:
    """The part of the mesh with the chosen (V,) vertices."""
    vertices, faces = compact(mesh[0], mesh[1][chosen[mesh[1]].all(axis=1)])
    return compact(vertices, faces[large_pieces(vertices, faces)[0]])


def _front(mesh: Mesh, marks: Landmarks) -> Mesh:
    depth = min(marks[f"acromion_{side}"][2] for side in "LR") - BACK
    return _kept(mesh, mesh[0][:, 2] > depth)


def _closed(mesh: Mesh, wall: float) -> Mesh:
    """The mesh with its outer border drawn out by `wall` (m; 0: moved) to a plate behind all of it."""
    vertices, faces = mesh[0].copy(), mesh[1]
    outline = _Outline.of(vertices)
    edges = boundary_edges(faces)
    edges = edges[outline.near(vertices)[edges].all(axis=1)]
    rim, ends = np.unique(edges, return_inverse=True)
    on_plate = vertices[rim]
    on_plate[:, 2] = on_plate[:, 2].min() - wall
    if not wall:
        vertices[rim] = on_plate
    first, second = len(vertices) + ends.reshape(-1, 2).T
    walls = np.stack([edges[:, 0], first, edges[:, 1], first, second, edges[:, 1]], axis=1).reshape(-1, 3)
    plate = Delaunay(on_plate[:, :2]).simplices.astype(np.int64)
    plate = plate[outline.holds(on_plate[plate].mean(axis=1))]
    front = face_crosses(on_plate, plate)[:, 2] > 0.0
    plate[front] = plate[front, ::-1]
    return np.concatenate([vertices, on_plate]), np.concatenate([faces, walls, len(vertices) + plate])


@dataclass(frozen=True, eq=False)
class _Outline:
    """The silhouette from the front, in cells."""

    low: Array  # (2,) m
    inside: Booleans

    @staticmethod
    def of(vertices: Array) -> "_Outline":
        low = vertices[:, :2].min(axis=0) - 2.0 * CELL
        cells = np.floor((vertices[:, :2] - low) / CELL).astype(np.int64)
        seen = np.zeros(cells.max(axis=0) + 3, dtype=np.bool_)
        seen[tuple(cells.T)] = True
        return _Outline(low, binary_fill_holes(binary_closing(seen)))

    def holds(self, points: Array, by: int = 0) -> Booleans:
        """(M,) which of (M, 3) m points are inside it, at least `by` cells from its border."""
        inside = binary_erosion(self.inside, iterations=by) if by else self.inside
        return np.asarray(inside[tuple(np.floor((points[:, :2] - self.low) / CELL).astype(np.int64).T)])

    def near(self, points: Array) -> Booleans:
        """(M,) which of (M, 3) m points are at its border or outside."""
        return ~self.holds(points, OUTLINE)

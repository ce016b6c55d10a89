"""One body of the sliding cohort: standing, supine and prone, with chest wall, lattice and tumours."""

from dataclasses import dataclass
from functools import cached_property

import igl
import numpy as np
from scipy.ndimage import label
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.rotations import exp_so3
from breastrig_studies.sliding.lattice import CORNERS, Lattice, Net, Springs, embedded
from breastrig_studies.sliding.wall import RADIUS, Wall
from breastrig_studies.virtual.bodies import VirtualBody, closed

STEP = 0.012  # m, a cell
SAMPLES = 3  # of a cell along each axis, to know how far it is filled
AROUND, RIM = 0.050, 0.040  # m around the breasts: where the lattice ends, and from where on it is held
EMPTY = 0.04  # share of a cell below which it is none
OF_AN_ARM = 0.25
GLAND = 0.035  # m, as far as gland reaches around the line from nipple to wall
STICKY = 0.012  # m around the breasts' rim in which they are held fast on the wall
HARD, FAST = 2e7, 1.5e5  # N/m³, of the wall along its normal, and along it where tissue is fast
DIRECTIONS = {"standing": (0.0, -1.0, 0.0), "supine": (0.0, 0.0, -1.0), "prone": (0.0, 0.0, 1.0)}
G = 9.81  # m/s²
TILT = np.radians(5.0)
TAUT = 1.04  # times longer than at rest is the skin without loads
SHORTEST = 1e-4  # m, of a spring
APART = 0.012  # m between tumours
TUMOURS, NEAR_WALL, UNDER_SKIN = 6, 0.012, 0.010  # a breast; every other one within NEAR_WALL of the wall (m)


@dataclass(frozen=True)
class Draw:
    """What is drawn of one body's tissue."""

    fat: float  # Pa, shear modulus
    gland: float  # times fat's
    bulk: float  # λ/μ
    loose: float  # N/m³: of the layer on the wall along it
    slip: float  # m: where it is twice as stiff
    skin: float  # N/m: of the net's springs
    stiffens: float  # stretch
    lifted: dict[str, float]  # m: how far the pectoral wall goes up with the arm, by stance


def drawn(random: np.random.Generator) -> Draw:
    """The tissue of one body: soft enough that nipples move 30 to 100 mm from prone to supine."""
    return Draw(
        fat=float(np.exp(random.uniform(np.log(50.0), np.log(160.0)))),
        gland=float(random.uniform(1.0, 4.0)),
        bulk=float(random.uniform(60.0, 120.0)),
        loose=float(np.exp(random.uniform(np.log(1.5e4), np.log(1e5)))),
        slip=float(random.uniform(0.008, 0.02)),
        skin=float(np.exp(random.uniform(np.log(3.0), np.log(15.0)))),
        stiffens=float(random.uniform(0.1, 0.3)),
        lifted={"supine": float(random.uniform(0.0, 0.012)), "prone": float(random.uniform(0.0, 0.018))},
    )


@dataclass(frozen=True, eq=False)
class SlidingBody:
    """A body's lattice, by stance its nodes (N, 3), skin (V, 3), wall (W, 3) and tumours (T, 3), all m."""

    cells: Integers  # (C, 8)
    nodes: dict[str, Array]
    skin: dict[str, Array]
    wall: dict[str, Array]
    wall_faces: Integers
    tumours: dict[str, Array]
    over_wall: Array  # (T,) m, standing
    radii: Array  # (T,) m


def lifting(points: Array, body: VirtualBody) -> Array:
    """(M, 3): the way that the wall goes when an arm is raised, 1 at the armpit, 0 at the breastbone and below."""
    at = body.landmarks
    middle, low = at["xiphoid"][0], min(at[f"inframammary_fold_{s}"][1] for s in "LR")
    found = np.zeros_like(points)
    for side, sign in (("L", 1.0), ("R", -1.0)):
        tip = at[f"acromion_{side}"]
        out = np.clip((sign * (points[:, 0] - middle) - 0.03) / (0.75 * abs(tip[0] - middle) - 0.03), 0.0, 1.0)
        up = np.clip((points[:, 1] - low) / (tip[1] - 0.08 - low), 0.0, 1.0)
        found += (out * out * (3.0 - 2.0 * out) * up * up * (3.0 - 2.0 * up))[:, None] * [0.35 * sign, 0.9, -0.15]
    return found


@dataclass(frozen=True, eq=False)
class Drawn:
    """A body before gravity."""

    body: VirtualBody
    faces: Integers  # (F, 3)
    arms: Array  # (V,) share of the arms
    breasts: Booleans  # (V,)
    wall: Wall

    @cached_property
    def skin(self) -> ClosestPointSearch:
        return ClosestPointSearch(self.body.vertices, self.faces)

    @cached_property
    def _base(self) -> "cKDTree[None]":
        return cKDTree(self.wall.flat(self.body.vertices[self.breasts])[0] * [RADIUS, 1.0])

    def from_breasts(self, points: Array) -> Array:
        """(M,) m along the unrolled trunk from the breasts' skin to (M, 3) m points."""
        return np.asarray(self._base.query(self.wall.flat(points)[0] * [RADIUS, 1.0])[0])

    def of_arm(self, points: Array) -> Array:
        """(M,) share of the arms at the skin next to (M, 3) m points."""
        return self.skin.query(points).on_mesh.positions(np.repeat(self.arms[:, None], 3, axis=1), self.faces)[:, 0]


@dataclass(frozen=True, eq=False)
class Cubes:
    """C cubes of STEP that hold tissue, counted from `low`."""

    low: Array  # (3,) m
    boxes: Integers  # (C, 3)
    fill: Array  # (C,)

    @cached_property
    def _corners(self) -> tuple[Array, Integers]:
        corners = self.boxes[:, None] + CORNERS.astype(np.int64)
        keys, numbers = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
        return self.low + STEP * keys, numbers.reshape(-1, 8)

    @property
    def nodes(self) -> Array:
        """(N, 3) m."""
        return self._corners[0]

    @property
    def cells(self) -> Integers:
        """(C, 8) nodes."""
        return self._corners[1]

    @property
    def middles(self) -> Array:
        """(C, 3) m."""
        return np.asarray(self.low + STEP * (self.boxes + 0.5))

    def gaps(self, points: Array) -> Array:
        """(M,) from (M, 3) m points to the nearest cube's middle, along the farthest axis, in cubes."""
        return np.asarray(cKDTree(self.boxes + 0.5).query((points - self.low) / STEP, p=np.inf)[0])

    def at(self, points: Array) -> csr_array:
        """(M, N) weights of the nodes at (M, 3) m points."""
        return embedded(points, self.low, STEP, self.boxes, self.cells)


def solved(drawn: Drawn, tissue: Draw, random: np.random.Generator) -> SlidingBody:
    """The body standing, supine and prone; NotAtRest."""
    cubes = cubes_of(drawn)
    lattice = lattice_of(drawn, cubes, tissue)
    body, wall = drawn.body, drawn.wall
    down = {n: exp_so3(TILT * random.normal(size=3)) @ (G * np.array(way)) for n, way in DIRECTIONS.items()}
    nodes, skin, walls = {}, {}, {}
    moving = _moving(drawn, cubes)[:, None]
    for name, way in down.items():
        amount = tissue.lifted.get(name, 0.0)
        posed = amount * lifting(lattice.wall.at @ lattice.nodes, body)
        start = np.where(lattice.held[:, None], amount * lifting(lattice.nodes, body), 0.0)
        move = lattice.at_rest(way, posed, start)
        nodes[name] = lattice.nodes + move
        skin[name] = body.vertices + lattice.skin.at @ move * moving
        walls[name] = wall.vertices + amount * lifting(wall.vertices, body)
    rows, over, radii = _tumours(drawn, cubes, random)
    tumours = {name: np.asarray(rows @ at) for name, at in nodes.items()}
    return SlidingBody(lattice.cells, nodes, skin, walls, wall.faces, tumours, over, radii)


def cubes_of(drawn: Drawn) -> Cubes:
    """The cubes between skin and wall, under and around the breasts, in one piece."""
    front = drawn.body.vertices[drawn.breasts]
    low = front.min(axis=0) - AROUND - 0.01
    low[2] = drawn.wall.axis[1] - 0.02
    count = np.ceil((front.max(axis=0) + np.array([AROUND, AROUND, 0.01]) - low) / STEP).astype(np.int64)
    boxes = np.stack(np.meshgrid(*(np.arange(n) for n in count), indexing="ij"), axis=-1).reshape(-1, 3)
    middles = low + STEP * (boxes + 0.5)
    boxes = boxes[(drawn.wall.over(middles) > -STEP) & (drawn.from_breasts(middles) < AROUND)]
    part = (np.arange(SAMPLES) + 0.5) / SAMPLES
    inner = np.stack(np.meshgrid(part, part, part, indexing="ij"), axis=-1).reshape(-1, 3)
    points = (low + STEP * (boxes[:, None] + inner)).reshape(-1, 3)
    vertices, triangles = (np.ascontiguousarray(each) for each in closed(drawn.body.vertices, drawn.faces))
    inside = igl.fast_winding_number(vertices, triangles, points) > 0.5
    fill = (inside & (drawn.wall.over(points) > 0.0)).reshape(len(boxes), -1).mean(axis=1)
    kept = (fill > EMPTY) & (drawn.of_arm(low + STEP * (boxes + 0.5)) < OF_AN_ARM)
    boxes, fill = boxes[kept], fill[kept]
    grid = np.zeros(count, dtype=np.bool_)
    grid[tuple(boxes.T)] = True
    piece = label(grid)[0][tuple(boxes.T)]
    largest = piece == np.bincount(piece).argmax()
    return Cubes(low, boxes[largest], fill[largest])


def lattice_of(drawn: Drawn, cubes: Cubes, tissue: Draw) -> Lattice:
    """The tissue in the cubes."""
    held = (drawn.from_breasts(cubes.nodes) > RIM) | (drawn.of_arm(cubes.nodes) > 0.8 * OF_AN_ARM)
    shear = tissue.fat * (1.0 + (tissue.gland - 1.0) * _gland(drawn, cubes.middles))
    vertices, faces = drawn.body.vertices, drawn.faces
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    edges = edges[(_moving(drawn, cubes) > 0.0)[edges].all(axis=1)]
    edges = edges[np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1) > SHORTEST]
    net = Net(cubes.at(vertices), edges, tissue.skin, TAUT, tissue.stiffens)
    wall = _on_wall(drawn, cubes, tissue)
    return Lattice(cubes.nodes, cubes.cells, cubes.fill, shear, tissue.bulk, held, wall, net)


def _gland(drawn: Drawn, points: Array) -> Array:
    """(M,) share of gland: around the line from the nipple to the trunk's axis."""
    found = np.zeros(len(points))
    for side in "LR":
        tip = drawn.body.landmarks[f"nipple_{side}"]
        root = np.array([drawn.wall.axis[0], tip[1] + 0.02, drawn.wall.axis[1]])
        way = (root - tip) / np.linalg.norm(root - tip)
        along = np.clip((points - tip) @ way, 0.0, 2.0 * GLAND)
        away = np.linalg.norm(points - tip - along[:, None] * way, axis=1)
        found = np.maximum(found, np.exp(-0.5 * (away / GLAND) ** 2))
    return found


def _moving(drawn: Drawn, cubes: Cubes) -> Array:
    """(V,) 1 where the lattice moves the skin, else 0."""
    skin = drawn.body.vertices
    near = (cubes.gaps(skin) < 1.1) & (drawn.from_breasts(skin) < RIM) & (drawn.arms < OF_AN_ARM)
    return np.asarray(near & (drawn.wall.over(skin) > 0.0), dtype=np.float64)


def _on_wall(drawn: Drawn, cubes: Cubes, tissue: Draw) -> Springs:
    wall, points = drawn.wall, drawn.wall.vertices
    away = drawn.from_breasts(points)
    kept = (cubes.gaps(points) < 0.7) & (away < AROUND)
    area = (wall.heights[1] - wall.heights[0]) * (wall.angles[1] - wall.angles[0]) * wall.radii.ravel()[kept]
    flat = wall.flat(points[kept])[0] * [RADIUS, 1.0]
    from_rim = cKDTree(flat[away[kept] > 0.004]).query(flat)[0]
    share = np.clip((from_rim - STICKY) / 0.015, 0.0, 1.0)
    share = share * share * (3.0 - 2.0 * share) * np.clip((np.abs(flat[:, 0]) - 0.015) / 0.01, 0.0, 1.0)
    along = FAST ** (1.0 - share) * tissue.loose**share
    return Springs(cubes.at(points[kept]), wall.normals[kept], HARD * area, along * area, tissue.slip)


def _tumours(drawn: Drawn, cubes: Cubes, random: np.random.Generator) -> tuple[csr_array, Array, Array]:
    """(T, N) weights of the nodes, (T,) m over the wall, (T,) m radius."""
    full = np.flatnonzero(cubes.fill > 0.99)
    middles = cubes.middles[full]
    depth, over = drawn.skin.query(middles).distances, drawn.wall.over(middles)
    inside = (drawn.from_breasts(middles) < 0.004) & (over > 0.004)
    chosen: list[int] = []
    for sign in (1.0, -1.0):
        here = inside & (sign * (middles[:, 0] - drawn.wall.axis[0]) > 0.02)
        for k in range(TUMOURS):
            able = here & ((over < NEAR_WALL) if k % 2 else (depth > UNDER_SKIN) & (over > NEAR_WALL))
            if chosen:
                able &= np.linalg.norm(middles[:, None] - middles[chosen], axis=2).min(axis=1) > APART
            chosen.append(int(random.choice(np.flatnonzero(able))))
    cells = cubes.cells[full[chosen]]
    at = (np.full(cells.size, 0.125), (np.repeat(np.arange(len(chosen)), 8), cells.ravel()))
    rows = csr_array(at, shape=(len(chosen), len(cubes.nodes)))
    return rows, over[chosen], random.uniform(0.003, 0.011, len(chosen))

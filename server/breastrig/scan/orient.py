"""Proposes a scan's orientation and the patient's position: proposals with a reason, never decisions.

A depth camera that goes round the front sees mostly surfaces that face it, so the mean normal of the scan points to the
front. A lying patient is scanned from above with the table: one large plane behind everything else, facing the camera.
Up is the scanner's +Y where that is across the front, else the longer extent.
"""

from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.stances import Stance
from breastrig.geometry.normals import face_areas, face_normals

SAMPLE = 8000  # triangles looked at: enough for a mean and a plane
PLANE_BIN = 0.01  # m, thickness of a table with the scanner's noise
TABLE_SHARE = 0.06  # of the scanned area in one plane 2 cm thick; what tells a table from a chest is what lies behind
ONE_SIDED = 0.25  # length of the mean normal; closed torsos have up to 0.13, scans of a front from 0.47
FACING = 0.94  # cosine, 20 degrees: triangles that may belong to a plane with that normal
BEHIND_SHARE = 0.06  # of the area may lie behind a table (noise, its edge)


@dataclass(frozen=True, eq=False)
class Frame:
    """A proposed body frame in the scan's own axes, and a proposed stance."""

    up: Array  # (3,) unit, to the head
    front: Array  # (3,) unit, perpendicular to up
    confidence: float  # 0..1; 1 where the file says it
    reason: str
    stance: str  # standing | supine | prone
    stance_reason: str
    fronts: Array  # (N, 3) unit, where the front may be: one direction, or six when the scan shows all sides
    table: tuple[Array, float] | None = None  # (3,) unit normal of a table behind the body, and its height along it (m)
    background: tuple[tuple[Array, float], ...] = ()  # planes of floors and walls that were cut away, as `table`

    @property
    def rotation(self) -> Array:
        """(3, 3): columns are the patient's left, up and front in the scan's axes."""
        return np.column_stack([np.cross(self.up, self.front), self.up, self.front])

    @property
    def known(self) -> Array | None:
        """`rotation` where the file states it, without looking at the scan; else None."""
        return self.rotation if self.confidence == 1.0 else None


LABEL_MAP_FRAME = Frame(
    up=np.array([0.0, 0.0, 1.0]),
    front=np.array([0.0, -1.0, 0.0]),
    confidence=1.0,
    reason="A label map says where the patient's front and head are.",
    stance="prone",
    stance_reason="The scan is a label map, and a breast MRI is taken prone. If it is not, state the position.",
    fronts=np.array([[0.0, -1.0, 0.0]]),
)  # LPS
IMAGE_FRAME = replace(
    LABEL_MAP_FRAME,
    reason="An image says where the patient's front and head are.",
    stance_reason="The scan is an image, and a breast MRI is taken prone. If it is not, state the position.",
)

STATED = "The image's header says that the patient lies {}. If that is wrong, state the position."
NOT_AS_STATED = "The image's header says that the patient lies {}; this fit is {}. Check which is true."


def frame_of_image(stated: Stance | None) -> Frame:
    """The frame of an image whose header states this position, or none."""
    return IMAGE_FRAME if stated is None else replace(IMAGE_FRAME, stance=stated, stance_reason=STATED.format(stated))


def _directions(count: int) -> Array:
    """(count, 3) evenly spread unit vectors (Fibonacci lattice)."""
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)


@dataclass(frozen=True, eq=False)
class _Members:
    """Members of G groups among M triangles: (group, triangle) pairs, sorted by group; no group is empty."""

    groups: Integers  # (N,)
    triangles: Integers  # (N,)
    starts: Integers  # (G,) first pair of each group

    @staticmethod
    def of(belongs: Booleans) -> "_Members":
        """belongs: (G, M)"""
        count, size = belongs.shape
        pairs = np.flatnonzero(belongs)  # three times as fast as in two dimensions
        starts = np.searchsorted(pairs, size * np.arange(count))
        groups = np.repeat(np.arange(count), np.diff(starts, append=len(pairs)))
        return _Members(groups, pairs - size * groups, starts)

    def only(self, kept: Booleans) -> "_Members":
        """The members of the (G,) groups that are kept."""
        chosen, sizes = kept[self.groups], np.diff(self.starts, append=len(self.groups))[kept]
        return _Members((np.cumsum(kept) - 1)[self.groups[chosen]], self.triangles[chosen], np.cumsum(sizes) - sizes)

    def heights(self, points: Array, normals: Array) -> Array:
        """(N,) of (M, 3) points along (G, 3) normals of their groups."""
        return np.asarray(np.einsum("ni,ni->n", points.take(self.triangles, axis=0), normals.take(self.groups, axis=0)))

    def peaks(self, heights: Array, weights: Array) -> tuple[Array, Array]:
        """(G,) the level (m) per group at which two neighbouring bins hold the most weight, and (G,) that weight."""
        low = np.minimum.reduceat(heights, self.starts)
        bins = np.floor((heights - low[self.groups]) / PLANE_BIN).astype(np.int64)
        count = int(bins.max()) + 2  # the last stays empty
        share = np.bincount(self.groups * count + bins, weights, len(self.starts) * count).reshape(-1, count)
        share[:, :-1] += share[:, 1:]
        peak = share.argmax(axis=1)
        return low + (peak + 1) * PLANE_BIN, share[np.arange(len(peak)), peak]


def table_plane(centres: Array, normals: Array, areas: Array) -> tuple[Array, float, float] | None:
    """(normal, offset in m, share of the area) of a table behind the body, or None.

    centres, normals (M, 3) and areas (M,) of triangles. All candidates are refined together.
    """
    total = areas.sum()
    guesses = _directions(300)
    facing = guesses @ normals.T > FACING  # (G, M)
    members = _Members.of(facing)
    enough = np.bincount(members.groups, areas[members.triangles], len(guesses)) >= TABLE_SHARE * total
    planes, members = guesses[enough], members.only(enough)
    for _ in range(3):  # the body's front tilts the first guess; the plane itself corrects it
        if not len(planes):
            return None
        heights = members.heights(centres, planes)
        level, _ = members.peaks(heights, areas[members.triangles])
        near = np.abs(heights - level[members.groups]) < 2 * PLANE_BIN
        planes = _laid_through(planes, centres, areas, members.groups[near], members.triangles[near])
        facing = planes @ normals.T > FACING
        some = facing.any(axis=1)  # no plane after all: curved parts turned the guess away from themselves
        planes, members = planes[some], _Members.of(facing[some])
    if not len(planes):
        return None
    level, share = members.peaks(members.heights(centres, planes), areas[members.triangles])
    large = share >= TABLE_SHARE * total
    planes, level, share = planes[large], level[large], share[large]
    behind = (planes @ centres.T < (level - 2 * PLANE_BIN)[:, None]) @ areas
    in_front = behind < BEHIND_SHARE * total
    planes, level, share = planes[in_front], level[in_front], share[in_front]
    if not len(share):
        return None
    best = int(share.argmax())
    return planes[best], float(level[best]), float(share[best] / total)


def _laid_through(planes: Array, centres: Array, areas: Array, groups: Integers, triangles: Integers) -> Array:
    """(G, 3) the normals of the planes through each group's triangles, on the side of the (G, 3) given ones."""
    weights, places, count = areas[triangles], centres.take(triangles, axis=0), len(planes)
    total = np.bincount(groups, weights, count)
    middle = np.stack([np.bincount(groups, weights * places[:, k], count) for k in range(3)], axis=1) / total[:, None]
    places -= middle.take(groups, axis=0)
    spread = np.zeros((count, 3, 3))
    for i in range(3):
        for j in range(i + 1):
            spread[:, i, j] = spread[:, j, i] = np.bincount(groups, weights * places[:, i] * places[:, j], count)
    flat = np.linalg.eigh(spread)[1][:, :, 0]
    return np.asarray(np.where(np.einsum("gi,gi->g", flat, planes)[:, None] > 0.0, flat, -flat))


def propose_frame(vertices: Array, faces: Integers) -> Frame:
    """The proposed frame of (V, 3) m vertices and (F, 3) triangles."""
    stride = max(1, len(faces) // SAMPLE)
    chosen = faces[::stride]
    normals, areas = face_normals(vertices, chosen), face_areas(vertices, chosen)
    centres = vertices[chosen].mean(axis=1)
    table = table_plane(centres, normals, areas)
    seen_around = False
    if table is not None:
        front, stance = table[0], "supine"
        share = f"{100 * table[2]:.0f} % of the scan"
        stance_reason = (
            f"{share} lies in one plane behind the body: a table. If it is a wall, say that the patient stands."
        )
        reason = "The front is where the table faces"
        confidence = 0.7
    else:
        mean = (normals * areas[:, None]).sum(axis=0) / areas.sum()
        strength = float(np.linalg.norm(mean))
        seen_around = strength < ONE_SIDED
        front, stance = np.array([0.0, 0.0, 1.0]) if seen_around else mean / strength, "standing"
        stance_reason = "There is no table in the scan."
        reason = "The scan shows all sides" if seen_around else "The front is where most of the scanned skin faces"
        confidence = min(0.8, 2.0 * strength)
    across = np.array([0.0, 1.0, 0.0]) - front[1] * front
    if np.linalg.norm(across) > 0.35:
        up = across / np.linalg.norm(across)
        reason += ", up is the scanner's own."
    else:
        flat = centres - centres.mean(axis=0)
        flat = flat - np.outer(flat @ front, front)
        _, _, axes = np.linalg.svd(flat * np.sqrt(areas)[:, None], full_matrices=False)
        up = axes[0] - (axes[0] @ front) * front
        up = up / np.linalg.norm(up) * (1.0 if up[2] <= 0.0 else -1.0)
        reason += ", up is the longer extent; check it."
        confidence *= 0.5
    front = front - (front @ up) * up
    front = front / np.linalg.norm(front)
    fronts = front[None]
    if seen_around:  # a torso is wide, high and flat: its front lies along one of its axes
        _, _, axes = np.linalg.svd((centres - centres.mean(axis=0)) * np.sqrt(areas)[:, None], full_matrices=False)
        fronts = np.concatenate([axes, -axes])
    plane = None if table is None else table[:2]
    return Frame(up, front, round(confidence, 2), reason, stance, stance_reason, fronts, plane)

"""The skin in an MR image, without a network: where air that the front reaches meets tissue.

Every place of the body's surface in cells is moved along its normal to where the image itself crosses the threshold.
What the image does not show stays open: its ends, missing slices, a back faded into noise, arms that touch the trunk,
and what the field of view folds over.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array, eye_array
from scipy.sparse.csgraph import connected_components

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadScan
from breastrig.geometry.half_edges import neighbours
from breastrig.geometry.normals import face_areas, vertex_normals
from breastrig.scan.clean import compact
from breastrig.scan.images.image import ImageVolume
from breastrig.scan.images.skin.cells import CELL, ISO, NO_AIR, Cells, Grey, body_in, cells_of
from breastrig.scan.images.skin.nipples import SeenNipple, nipples_on

DEPTHS = np.arange(-3.0, 8.01, 0.5)  # mm inwards, along which the image is looked at
SHALLOW, DEEP = (0.0, 3.0), (4.0, 8.0)  # mm, of the skin, and of the fat under it
DARK_FAT, ISO_OF_DARK = 0.9, 0.5  # of the skin's signal: fat that is suppressed, and the skin's edge there
NO_NIPPLES = "Fat is dark in this image: nipples are not looked for; place them."
FARTHEST = 2.5  # mm that a place is moved
ROUNDS = 2
EVENED = 8  # times profiles are averaged with their neighbours', for noise makes steps
STEP = 0.5  # of the signal inside: air has less
WITHOUT_STEP = 600.0  # mm² of skin without a step from air to tissue that is none
REBOUND, ARM = 15.0, 1000.0  # mm by which skin comes forward again beside the trunk, and mm² of it that are an arm
MIDDLE_WITHIN = 120.0  # mm from the body's middle: where the origin is between the breasts
NO_STEP = "Over {:.0f} cm² the signal fades into noise; the skin is open there."
BESIDE = (
    "Beside the trunk, {:.0f} cm² of skin come forward again: arms that touch it, or what the field of view "
    "folds over; the skin is open there."
)
FADED = "Farther back the signal fades into noise, and nothing is seen; the skin is open there."
EDGE = "The body reaches the {} edge of the image; the skin is open there."


@dataclass(frozen=True, eq=False)
class ImageSkin:
    """The skin of an image, open where the image does not show it."""

    vertices: Array  # (V, 3) mm, LPS
    faces: Integers  # (F, 3), outwards
    notes: tuple[str, ...]  # one sentence each
    nipples: tuple[SeenNipple, ...] = ()


def skin_of_image(image: ImageVolume) -> ImageSkin:
    """The skin, its triangles some 2 mm long.  Raises BadScan where no air is in front of a body."""
    cells = cells_of(image)
    body = body_in(cells)
    arms = _beside(cells, body)
    vertices, faces = _surface(cells, body)
    iso, profiles = None, np.zeros((0, len(DEPTHS)))
    for _ in range(ROUNDS):
        normals, profiles = _profiles(image, cells, vertices, faces)
        iso = iso or _iso(profiles)
        levels = cells.sampled(cells.level, vertices) * (iso / ISO)
        vertices = vertices - _crossings(profiles, levels)[:, None] * normals
    middles = vertices[faces].mean(axis=1)
    at = cells.indices(middles)
    is_arm = arms[tuple(np.clip(np.round(at).astype(np.int64), 0, np.array(arms.shape) - 1).T)]
    is_flat = _without_step(vertices, faces, profiles) & ~is_arm
    is_faded = _near(cells.faded, at)
    voxels = np.linalg.solve(image.affine[:3, :3], (middles - image.affine[:3, 3]).T).T
    known = np.ones(len(faces), np.bool_)
    for gap in image.gaps:
        known &= (voxels[:, gap.axis] < gap.first - 1) | (voxels[:, gap.axis] > gap.last + 1)
    known &= ~is_faded
    areas = face_areas(vertices, faces)
    notes = [
        sentence.format(0.01 * areas[left_out].sum())
        for left_out, sentence in ((is_arm & known, BESIDE), (is_flat & known, NO_STEP))
        if left_out.any()
    ]
    if (body & ndimage.binary_dilation(cells.faded)).sum() * np.prod(cells.sizes) > CELL * WITHOUT_STEP:
        notes.append(FADED)
    vertices, faces = compact(vertices, faces[known & ~is_arm & ~is_flat])
    if not len(faces):
        raise BadScan(NO_AIR)
    if iso == ISO_OF_DARK:  # one in seven that is found there is 4 to 6 cm off, as clear a bump as the others
        notes.append(NO_NIPPLES)
    nipples = nipples_on(vertices, faces, _middle(cells, body)) if iso != ISO_OF_DARK else ()
    return ImageSkin(vertices, faces, (*notes, *_edges(cells, body)), nipples)


def _surface(cells: Cells, body: Booleans) -> tuple[Array, Integers]:
    """(V, 3) mm, (F, 3): of the body, where the cells' values cross their level."""
    from skimage.measure import marching_cubes  # 0.3 s to load, and hardly any scan is an image

    over: Grey = np.clip(cells.values / np.maximum(cells.level, np.float32(1e-6)) - 1.0, -1.0, 3.0)
    over = np.where(body, np.where(over > 0.0, over, 0.5), np.minimum(over, -0.5 * (over > 0.0))).astype(np.float32)
    places, faces, _, _ = marching_cubes(over, 0.0, allow_degenerate=False)
    vertices = places.astype(np.float64) @ cells.affine[:3, :3].T + cells.affine[:3, 3]
    is_mirrored = np.linalg.det(cells.affine[:3, :3]) < 0.0
    return vertices, np.asarray(faces if is_mirrored else faces[:, ::-1], np.int64)


def _profiles(image: ImageVolume, cells: Cells, vertices: Array, faces: Integers) -> tuple[Array, Array]:
    """(V, 3) normals, and (V, D) what the image shows at DEPTHS under each vertex."""
    normals = vertex_normals(vertices, faces)
    inverse = np.linalg.inv(image.affine)
    profiles = np.zeros((len(vertices), len(DEPTHS)))
    for k, depth in enumerate(DEPTHS):
        at = (vertices - depth * normals) @ inverse[:3, :3].T + inverse[:3, 3]
        profiles[:, k] = ndimage.map_coordinates(image.values, at.T, order=1, mode="nearest", output=np.float32)
    return normals, profiles


def _iso(profiles: Array) -> float:
    """The skin's edge as share of the strongest signal nearby."""
    shallow = profiles[:, (SHALLOW[0] <= DEPTHS) & (SHALLOW[1] >= DEPTHS)].max(axis=1)
    deep = profiles[:, (DEEP[0] <= DEPTHS) & (DEEP[1] >= DEPTHS)].mean(axis=1)
    return ISO_OF_DARK if np.median(deep / np.maximum(shallow, 1e-6)) < DARK_FAT else ISO


def _crossings(profiles: Array, levels: Array) -> Array:
    """(V,) mm inwards to the nearest place where the profile rises over the level; 0 where there is none."""
    over = profiles - levels[:, None]
    rises = (over[:, :-1] <= 0.0) & (over[:, 1:] > 0.0)
    share = over[:, :-1] / np.where(rises, over[:, :-1] - over[:, 1:], 1.0)
    places = np.where(rises, DEPTHS[:-1] + share * np.diff(DEPTHS), np.inf)
    nearest = places[np.arange(len(places)), np.abs(places).argmin(axis=1)]
    return np.where(np.abs(nearest) <= FARTHEST, nearest, 0.0)


def _near(faded: Booleans, at: Array) -> Booleans:
    """(F,) whether indices of cells (F, 3) lie where nothing is known, or border on it."""
    wider = ndimage.binary_dilation(faded, np.ones((3, 3, 3), np.bool_), iterations=2)
    limits = np.array(faded.shape) - 1
    return np.asarray(wider[tuple(np.clip(np.round(at).astype(np.int64), 0, limits).T)])


def _without_step(vertices: Array, faces: Integers, profiles: Array) -> Booleans:
    """(F,) in large patches where outside is no less signal than inside."""
    mean = 0.5 * (neighbours(faces, len(vertices)) + eye_array(len(vertices)))
    for _ in range(EVENED):
        profiles = mean @ profiles
    inside = profiles[:, (DEPTHS > 0.0) & (SHALLOW[1] >= DEPTHS)].max(axis=1)
    outside = profiles[:, DEPTHS <= -1.0].min(axis=1)
    flat: Booleans = (outside >= STEP * inside)[faces].all(axis=1)
    corners = faces[flat]
    first, second = corners[:, [0, 1]].ravel(), corners[:, [1, 2]].ravel()
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(len(vertices), len(vertices)))
    patch = connected_components(graph, directed=False)[1]
    area = np.bincount(patch[corners[:, 0]], face_areas(vertices, corners), minlength=len(vertices))
    flat[flat] = area[patch[corners[:, 0]]] > WITHOUT_STEP
    return flat


def _beside(cells: Cells, body: Booleans) -> Booleans:
    """(I, J, K) the columns from front to back in which skin beside the trunk comes forward again."""
    order = [int(np.abs(cells.affine[row, :3]).argmax()) for row in range(3)]
    if sorted(order) != [0, 1, 2]:
        return np.zeros_like(body)
    signs = [float(np.sign(cells.affine[row, axis])) for row, axis in enumerate(order)]
    turned = np.flip(body.transpose(order), tuple(row for row in range(3) if signs[row] < 0.0))  # left, back, up
    sizes = cells.sizes[order]
    found = np.zeros_like(turned)
    depth = sizes[1] * np.where(turned.any(axis=1), turned.argmax(axis=1), turned.shape[1])  # (left, up) mm
    volume_middle = cells.affine[:3, :3] @ (0.5 * (np.array(body.shape) - 1)) + cells.affine[:3, 3]
    x = volume_middle[0] + sizes[0] * (np.arange(turned.shape[0]) - 0.5 * (turned.shape[0] - 1))
    centre = _middle(cells, body)
    for half in (np.flatnonzero(x >= centre), np.flatnonzero(x < centre)[::-1]):
        if not len(half):
            continue
        outwards = depth[half]
        apex = outwards.argmin(axis=0)
        beyond = np.arange(len(half))[:, None] >= apex
        farthest = np.maximum.accumulate(np.where(beyond, outwards, -np.inf), axis=0)
        forward = ndimage.binary_opening((farthest - outwards > REBOUND) & beyond, np.ones((3, 3), np.bool_))
        if forward.sum() * sizes[0] * sizes[2] < ARM:
            continue
        first = np.array([_last_valley(outwards[:, k], forward[:, k]) for k in range(outwards.shape[1])])
        found[half] = (np.arange(len(half))[:, None] >= first)[:, None, :]
    back = np.flip(found, tuple(row for row in range(3) if signs[row] < 0.0))
    return np.asarray(back.transpose(np.argsort(order)))


def _middle(cells: Cells, body: Booleans) -> float:
    """mm, x between the sides: the origin, between the breasts, unless the body lies elsewhere."""
    step = 4 if body[::4, ::4, ::4].any() else 1
    mean = np.argwhere(body[::step, ::step, ::step]).mean(axis=0) * step
    across = float((cells.affine[:3, :3] @ mean + cells.affine[:3, 3])[0])
    return 0.0 if abs(across) < MIDDLE_WITHIN else across


def _last_valley(outwards: Array, forward: Booleans) -> int:
    """Index of the deepest column before the first that comes forward."""
    if not forward.any():
        return len(outwards)
    before = int(forward.argmax())
    return int(outwards[:before].argmax())


def _edges(cells: Cells, body: Booleans) -> list[str]:
    """Notes on the sides of the image that the body reaches."""
    axis = int(np.abs(cells.affine[0, :3]).argmax())
    left = -1 if cells.affine[0, axis] > 0.0 else 0
    ends = {"left": left, "right": -1 - left}
    return [EDGE.format(side) for side, end in ends.items() if body.take(end, axis=axis).mean() > 0.2]

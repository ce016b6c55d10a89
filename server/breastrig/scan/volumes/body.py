"""The body of a label map, all that the air in front of it does not reach, and its skin."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import TOO_MANY_TRIANGLES, TRIANGLES
from breastrig.scan.volumes.volume import Gap, Volume

CELL = 1.5  # mm; finer voxels are averaged, for no skin of an MRI is known better
SLIVER = 1e-6  # mm^2 of twice the area; marching cubes leaves some
SMOOTHING = 1.2  # mm, of the Gaussian over the steps between voxels
LARGEST_BODY = 4000.0  # mm across
NO_SKIN = "This label map shows no skin with air in front of it; export the whole volume, 0 for air."
NO_BODY = (
    "This label map shows no body: all that is in it is {:.0f} mm across, as a lesion alone; give it with the image "
    "that it was drawn on, or export the body with it, from the skin to the chest wall."
)
LESION_ALONE = 40.0  # mm radius of a ball of the volume of what is no body, wherever it lies
LESION_IN_AIR = 80.0  # mm, where air is all around it


class Bodies:
    """The body for each possible direction of the front."""

    def __init__(self, filled: Booleans) -> None:
        """`filled` (I, J, K): where any segment is."""
        self._filled = filled
        self._air: NDArray[Any] = ndimage.label(~filled)[0]
        self._found: dict[tuple[int, int], Booleans] = {}  # by the axis and the end of it that is in front

    def air_in_front(self, affine: Array) -> float:
        """Share of the volume's front face, where the affine (to LPS) has it."""
        axis, end = front_of(affine)
        return float((self._air.take(end, axis=axis) > 0).mean())

    def body(self, affine: Array) -> Booleans:
        """(I, J, K).  BadScan where no air is in front, or nothing behind it."""
        front = front_of(affine)
        if front not in self._found:
            in_front = self._air.take(front[1], axis=front[0])
            counts = np.bincount(in_front[in_front > 0])
            if not counts.size or not self._filled.any():
                raise BadScan(NO_SKIN)
            self._found[front] = np.asarray(self._air != counts.argmax())
        return self._found[front]


def front_of(affine: Array) -> tuple[int, int]:
    """The voxels' axis that lies from front to back, and its index in front."""
    axis = int(np.abs(affine[1, :3]).argmax())
    return axis, 0 if affine[1, axis] > 0.0 else -1  # LPS: y grows to the back


def filled(volume: Volume, left_out: frozenset[int] = frozenset()) -> Booleans:
    """(I, J, K) where any segment is, without those of these numbers."""
    found = np.zeros(volume.shape, np.bool_, order="F")
    for each in volume.segments:
        if each.number not in left_out:
            found[each.box] |= each.inside()
    return found


def check_shows_body(there: Booleans, affine: Array) -> None:
    """Raises BadScan where the labels (I, J, K) fill no more than a lesion, or more than a body."""
    pieces, count = ndimage.label(there)
    if not count:
        raise BadScan(NO_SKIN)
    sizes = np.bincount(pieces.ravel())
    sizes[0] = 0
    largest = int(sizes.argmax())
    box = ndimage.find_objects(pieces, max_label=count)[largest - 1]
    steps = np.linalg.norm(affine[:3, :3], axis=0)
    across = steps * [side.stop - side.start for side in box]
    radius = float(np.cbrt(sizes[largest] * abs(np.linalg.det(affine[:3, :3])) * 3.0 / (4.0 * np.pi)))
    is_in_air = all(side.start > 0 and side.stop < size for side, size in zip(box, there.shape, strict=True))
    if radius <= (LESION_IN_AIR if is_in_air else LESION_ALONE):
        raise BadScan(NO_BODY.format(across.max()))
    if np.linalg.norm(across) > LARGEST_BODY:
        raise BadScan(
            f"What this label map shows is {1e-3 * across.max():.3g} m across, which is no body; check its unit."
        )


def skin(body: Booleans, affine: Array, gaps: tuple[Gap, ...] = ()) -> tuple[Array, Integers]:
    """(V, 3) mm and (F, 3), open where the volume ends, and at slices of which nothing is known."""
    from skimage.measure import marching_cubes  # 0.3 s to load, and hardly any scan is a volume

    sizes = np.linalg.norm(affine[:3, :3], axis=0)
    steps = np.clip(np.round(CELL / sizes), 1, body.shape).astype(np.int64)
    padded = np.pad(body, [(0, int(-size % step)) for size, step in zip(body.shape, steps, strict=True)], "edge")
    blocks = padded.reshape([n for size, step in zip(padded.shape, steps, strict=True) for n in (size // step, step)])
    share = np.asarray(blocks.mean(axis=(1, 3, 5), dtype=np.float32))
    smooth = ndimage.gaussian_filter(share, SMOOTHING / (steps * sizes), mode="nearest")
    if not smooth.min() < 0.5 < smooth.max():
        raise BadScan("This label map shows no skin; export body and lesions with 0 for air.")
    is_inside = smooth > 0.5
    if sum(np.count_nonzero(np.diff(is_inside, axis=axis)) for axis in range(3)) > TRIANGLES:  # two for each, at least
        raise TooLarge(TOO_MANY_TRIANGLES)
    places, faces, _, _ = marching_cubes(smooth, 0.5, allow_degenerate=False)
    indices = places.astype(np.float64) * steps + 0.5 * (steps - 1)
    vertices = indices @ affine[:3, :3].T + affine[:3, 3]
    corners = vertices[faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    faces = faces[areas > SLIVER]
    middles = indices[faces].mean(axis=1)
    for gap in gaps:
        along = middles[:, gap.axis]
        faces, middles = (each[(along < gap.first - 1) | (along > gap.last + 1)] for each in (faces, middles))
    is_mirrored = np.linalg.det(affine[:3, :3]) < 0.0
    return vertices, np.asarray(faces if is_mirrored else faces[:, ::-1], np.int64)

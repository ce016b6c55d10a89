"""An MR-like image of a woman: tissues, coil, noise, and what spoils images.

No physics of a scanner: fat bright or suppressed, a coil that fades with the distance, Rician noise, ghosts of motion
along the phase encoding, what the field of view folds over.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.normals import vertex_normals
from breastrig.scan.images.image import ImageVolume
from breastrig.scan.volumes.volume import Gap
from breastrig_studies.virtual.magnetic.coverage import coverage
from breastrig_studies.virtual.magnetic.woman import Woman

FULL = 600.0  # of the signal of fat beside the coil
SKIN, NIPPLE, REACH = 1.6, 2.6, 9.0  # mm, thickness, more of it at a nipple, and how far around
MARGIN = 14.0  # mm of air around her
ABOVE, BELOW = 15.0, 55.0  # mm, field of view above the notch and below the folds
BEHIND = 95.0  # mm, its end behind the middle of the breastbone
WIDE = 205.0  # mm from the middle, its sides at most
BLUR = 0.4  # of a voxel, Gaussian
UNDER_SKIN, THICK = 5.0, 11.0  # mm of fat over muscle, and of muscle over the lungs, at least
COARSE = 3.0  # mm


@dataclass(frozen=True)
class Tissues:
    """Signals as shares of bright fat's."""

    fat: float = 1.0
    gland: float = 0.45
    muscle: float = 0.33
    lung: float = 0.03
    skin: float = 0.5
    nipple: float = 0.65
    lesion: float = 0.75


SUPPRESSED = Tissues(fat=0.14, gland=0.50, muscle=0.40, skin=0.45, nipple=0.7, lesion=1.0)


@dataclass(frozen=True)
class Protocol:
    """How the image is taken."""

    steps: tuple[float, float, float] = (1.0, 1.0, 1.0)  # mm, to the left, to the back, up
    tissues: Tissues = Tissues()
    noise: float = 0.012  # of bright fat
    coil: tuple[float, float] = (1.0, 1.0)  # strength on the left and right
    fades: float = 75.0  # mm behind the nipples, by which it is down to 1 / e
    back: bool = False  # the field of view holds all of the back
    ghosts: float = 0.0  # share of the signal in the nearer two of four ghosts
    board: float = 0.0  # signal of a board under the breastbone
    air_zero: bool = False  # the scanner sets to 0 what it takes for air
    narrow: float = 0.0  # mm by which the field of view is too narrow on each side: the body folds over
    only: str = ""  # "L" or "R": one breast alone
    gap: tuple[int, int] = (0, 0)  # first slice and number of slices that are missing


PLAIN = Protocol()


@dataclass(frozen=True, eq=False)
class MrImage:
    """An image and the truth about it; mm, LPS."""

    image: ImageVolume
    vertices: Array  # (V, 3) the true skin, beyond the field of view too
    faces: Integers  # (F, 3)
    nipples: dict[str, Array]  # (3,) by side
    lesion: Booleans  # (I, J, K)
    lesion_at: Array  # (3,)


def fat_suppressed(protocol: Protocol = PLAIN) -> Protocol:
    return replace(protocol, tissues=SUPPRESSED)


def mr_image(woman: Woman, protocol: Protocol = PLAIN, seed: int = 0) -> MrImage:
    """The image; the same seed gives the same."""
    random = np.random.default_rng([17, seed])
    low, shape = _field(woman, protocol)
    steps = np.array(protocol.steps)
    fold = round(protocol.narrow / steps[0])
    axes = [low[k] + steps[k] * np.arange(shape[k]) for k in range(3)]
    body = coverage(woman.vertices, woman.faces, low, steps, shape)
    signal: NDArray[Any]
    signal, lesion, at = _tissues(woman, protocol, axes, body, random)
    signal *= _coil(woman, protocol, axes)
    signal = ndimage.gaussian_filter(signal, BLUR)
    if protocol.ghosts:
        signal = _ghosted(signal, protocol.ghosts, random)
    if fold:
        folded = signal[fold:-fold].copy()
        folded[-fold:] += signal[:fold]
        folded[:fold] += signal[-fold:]
        signal, lesion = folded, lesion[fold:-fold]
        low = low + np.array([fold * steps[0], 0.0, 0.0])
    for part in np.array_split(signal, 32):  # views
        noise = protocol.noise * random.standard_normal((2, *part.shape), dtype=np.float32)
        part[:] = np.hypot(part + noise[0], noise[1])
    if protocol.air_zero:
        signal = _without_air(signal, protocol.noise)
    affine = np.diag([*steps, 1.0])
    affine[:3, 3] = low
    values: NDArray[Any] = np.round(FULL * signal).astype(np.int16)
    gaps: tuple[Gap, ...] = ()
    if protocol.gap[1]:
        first, last = protocol.gap[0], protocol.gap[0] + protocol.gap[1] - 1
        values[:, :, first : last + 1] = 0
        gaps = (Gap(2, first, last),)
    return MrImage(
        ImageVolume(values, affine, gaps=gaps), woman.vertices, woman.faces, woman.nipples, lesion, np.asarray(at)
    )


def _field(woman: Woman, protocol: Protocol) -> tuple[Array, tuple[int, int, int]]:
    """First voxel's middle, and how many."""
    marks, skin = woman.landmarks, woman.vertices
    low, high = np.zeros(3), np.zeros(3)
    low[2] = min(marks[f"inframammary_fold_{side}"][2] for side in "LR") - BELOW
    high[2] = marks["suprasternal_notch"][2] + ABOVE
    there = skin[(skin[:, 2] > low[2]) & (skin[:, 2] < high[2])]
    low[0], low[1] = max(there[:, 0].min() - MARGIN, -WIDE), there[:, 1].min() - MARGIN
    high[0] = min(there[:, 0].max() + MARGIN, WIDE)
    high[1] = there[:, 1].max() + MARGIN if protocol.back else marks["mid_sternum"][1] + BEHIND
    if protocol.only == "L":
        low[0] = 8.0
    elif protocol.only == "R":
        high[0] = -8.0
    shape = np.ceil((high - low) / protocol.steps).astype(int) + 1
    return low, (int(shape[0]), int(shape[1]), int(shape[2]))


def _tissues(
    woman: Woman, protocol: Protocol, axes: list[Array], body: Array, random: np.random.Generator
) -> tuple[Array, Booleans, Array]:
    """Signal without coil (float32), where the lesion is, and its middle."""
    tissues, marks = protocol.tissues, woman.landmarks
    low, steps = np.array([axis[0] for axis in axes]), np.array(protocol.steps)
    away = np.min([np.linalg.norm(woman.vertices - place, axis=1) for place in woman.nipples.values()], axis=0)
    thick = SKIN + NIPPLE * np.exp(-((away / REACH) ** 2))
    inner = woman.vertices - thick[:, None] * vertex_normals(woman.vertices, woman.faces)
    inside = np.minimum(coverage(inner, woman.faces, low, steps, body.shape), body)
    x, y, z = axes[0][:, None, None], axes[1][None, :, None], axes[2][None, None, :]

    def near(place: Array, sizes: Any) -> Array:
        sizes = np.broadcast_to(sizes, 3)
        parts = [((axis - place[k]) / sizes[k]) ** 2 for k, axis in enumerate((x, y, z))]
        return np.asarray(parts[0] + parts[1] + parts[2], np.float32)

    shell = np.full(body.shape, tissues.skin, np.float32)
    for place in woman.nipples.values():
        shell[near(place, REACH) < 1.0] = tissues.nipple
    signal = (body - inside) * shell
    kind = np.full(body.shape, tissues.fat, np.float32)
    rough = ndimage.zoom(random.standard_normal([max(2, int(np.ptp(axis) / 7.0)) for axis in axes]), 4, order=1)
    cells = [
        np.linspace(0, n - 1, len(axis)).round().astype(np.int64) for n, axis in zip(rough.shape, axes, strict=True)
    ]
    texture = np.asarray(rough[np.ix_(*cells)], np.float32)
    for place in woman.nipples.values():
        gland = near(place + np.array([0.0, 34.0, 4.0]), (30.0, 36.0, 30.0))
        kind[gland + 0.5 * texture < 1.0] = tissues.gland
    sternum = marks["mid_sternum"]
    at_height = np.abs(woman.vertices[:, 2] - sternum[2]) < 40.0
    back = woman.vertices[at_height & (np.abs(woman.vertices[:, 0]) < 40.0), 1].max()
    front, behind = sternum[1] + 9.0, back - 18.0
    deep = 0.5 * (behind - front)
    wall = np.sqrt(((x / (1.28 * deep)) ** 2) + ((y - front - deep) / deep) ** 2).astype(np.float32)
    wall = np.broadcast_to(wall, body.shape)
    depth = _depth(woman, axes)
    kind[(wall < 1.0) & (depth > UNDER_SKIN)] = tissues.muscle
    kind[(wall < 0.84) & (np.abs(x) > 24.0) & (depth > UNDER_SKIN + THICK)] = tissues.lung
    side = "R" if protocol.only == "R" else "L"
    outwards = 1.0 if side == "L" else -1.0
    lesion_at = woman.nipples[side] + [10.0 * outwards, 34.0, 9.0]
    lesion = (near(lesion_at, 7.0) < 1.0) & (body > 0.5)
    kind[lesion] = tissues.lesion
    signal += inside * kind
    if protocol.board:
        top = sternum[1] - 2.0
        under = (y < top) & (y > top - 14.0) & (np.abs(x) < 26.0) & (z > sternum[2] - 95.0)
        signal += np.where(under, protocol.board * (1.0 - body), 0.0).astype(np.float32)
    return np.asarray(signal), lesion, lesion_at


def _depth(woman: Woman, axes: list[Array]) -> NDArray[np.float32]:
    """(I, J, K) mm to the skin, in steps of COARSE."""
    low = np.array([axis[0] for axis in axes]) - 3.0 * COARSE
    counts = [int((np.ptp(axis)) / COARSE) + 7 for axis in axes]
    body = coverage(woman.vertices, woman.faces, low, np.full(3, COARSE), (counts[0], counts[1], counts[2]), 1) > 0.5
    found = np.asarray(COARSE * ndimage.distance_transform_edt(body), np.float32)
    return found[
        np.ix_(*[np.round((axis - start) / COARSE).astype(np.int64) for axis, start in zip(axes, low, strict=True)])
    ]


def _coil(woman: Woman, protocol: Protocol, axes: list[Array]) -> NDArray[np.float32]:
    """(I, J, K) float32 sensitivity: 1 about the breasts, less with the distance."""
    found = np.zeros([len(axis) for axis in axes], np.float32)
    for side, strength in zip("LR", protocol.coil, strict=True):
        middle = woman.nipples[side] + [0.0, 25.0, 5.0]
        parts = [
            (axis - middle[k]) / size for k, (axis, size) in enumerate(zip(axes, (85.0, 130.0, 150.0), strict=True))
        ]
        squares = parts[0][:, None, None] ** 2 + parts[1][None, :, None] ** 2 + parts[2][None, None, :] ** 2
        found += (strength / (1.0 + squares)).astype(np.float32)
    nearest = min(place[1] for place in woman.nipples.values()) + 40.0
    found *= np.exp(-np.maximum(axes[1] - nearest, 0.0) / (2.0 * protocol.fades)).astype(np.float32)[None, :, None]
    return found


def _ghosted(signal: NDArray[Any], share: float, random: np.random.Generator) -> NDArray[Any]:
    """With copies moved along the first axis, by phases of their own."""
    step, made = max(3, len(signal) // 9), signal.copy()
    for order, amount in ((1, share), (2, 0.5 * share)):
        for way in (1, -1):
            made += np.float32(amount * random.uniform(0.7, 1.0)) * np.roll(signal, way * order * step, axis=0)
    return made


def _without_air(signal: NDArray[Any], noise: float) -> NDArray[Any]:
    """0 where a smoothed image is below a threshold, as scanners cut the air; a rim of it and specks stay."""
    smooth = ndimage.uniform_filter(signal, 5)
    return np.where(smooth < 1.8 * noise, np.float32(0.0), signal)


Change = Callable[[Protocol], Protocol]
OPTIONS: dict[str, Change] = {
    "plain": lambda p: p,
    "fat suppressed": fat_suppressed,
    "fat suppressed, 3 mm slices": lambda p: fat_suppressed(replace(p, steps=(p.steps[0], p.steps[1], 3.0))),
    "motion ghosts": lambda p: replace(p, ghosts=0.05),
    "strong motion ghosts": lambda p: replace(p, ghosts=0.08),
    "visible board": lambda p: replace(p, board=0.12),
    "one coil half at 30 %": lambda p: replace(p, coil=(0.3, 1.0)),
    "three times the noise": lambda p: replace(p, noise=3.0 * p.noise),
    "3 mm slices": lambda p: replace(p, steps=(p.steps[0], p.steps[1], 3.0)),
    "air set to 0": lambda p: replace(p, air_zero=True),
    "one side": lambda p: replace(p, only="L"),
    "folded over": lambda p: replace(p, narrow=40.0),
    "all of the back": lambda p: replace(p, back=True),
    "faded back": lambda p: replace(p, back=True, fades=40.0),
    "slices missing": lambda p: replace(p, gap=(round(60 / p.steps[2]), round(12 / p.steps[2]))),
}

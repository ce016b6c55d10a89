"""The areola: a round patch of darker or redder skin near the expected nipple.

It is found by the difference of a disc and the ring around it, at several sizes, towards every side.  Its border is
then measured along the axis in Lab that best separates it from the skin around (Fisher's discriminant): change points
on rays, smoothed by a low Fourier series.  a* and b* are scaled to the local lightness; a median removes thin things.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.fft import irfft2, next_fast_len, rfft2
from scipy.ndimage import distance_transform_edt, gaussian_filter, map_coordinates

from breastrig.colour.features.limits import AreolaLimits
from breastrig.colour.features.patch import ColouredSkin, Patch
from breastrig.core.arrays import Array, Booleans

RAYS = 72
PIXEL = 0.001  # m, of the picture that is measured in; 72 rays find a border to a fraction of it
STEP = 0.0005  # m along a ray
HARMONICS = 3  # of the border's Fourier series: shift, ellipse, three lobes
NORMAL_90 = 1.645  # standard deviations to each side
ROUNDS = 3  # of measuring, each from the middle that the last one found
SECTORS = 6  # of the ring, each of which must differ


@dataclass(frozen=True, eq=False)
class Areola:
    """A found areola."""

    centre: Array  # (3,) m, on the skin, in the scan's frame
    normal: Array  # (3,) unit
    rim: Array  # (RAYS, 3) m, its border on the skin
    radius: float  # m, of the circle of the same area, along the skin
    covariance: Array  # (3, 3) m², of the centre, from the scatter of its border
    radius_error: float  # m, standard deviation, likewise and of what no scatter shows
    contrast: Array  # (3,) Lab, from the skin around to it
    clearness: float  # how many standard deviations of the texture its colour lies from that of the skin around
    roundness: float  # relative scatter of the border around its own smooth form; small is round
    border: float  # share of the rays on which a border was found

    @property
    def diameter_half(self) -> float:
        """m, half the band that holds the true diameter with 90 %."""
        return 2.0 * NORMAL_90 * self.radius_error


@dataclass(frozen=True)
class Candidate:
    """A possible place, to be measured."""

    right: float  # m from the picture's middle
    up: float
    radius: float
    score: float


def level_colour(patch: Patch) -> tuple[Array, Booleans]:
    """((N, N, 3) Lab with chroma scaled to the patch's own lightness and without thin things, (N, N) known)."""
    known = patch.skin
    if not known.any():
        return np.zeros_like(patch.lab), known
    nearest = distance_transform_edt(~known, return_distances=False, return_indices=True)
    filled = patch.lab[tuple(nearest)]
    reference = float(np.median(patch.lab[known][:, 0])) + 16.0
    lightness = np.maximum(gaussian_filter(filled[..., 0], 2.0), 1.0) + 16.0
    level = filled * np.stack([np.ones_like(lightness), reference / lightness, reference / lightness], axis=-1)
    size = max(2 * round(0.5 * THIN / patch.pixel) + 1, 3)
    return _median(level, size), known


THIN = 0.005  # m; a median of this side removes lines up to half of it


def _median(pictures: Array, size: int) -> Array:
    """The median of `size` x `size` pixels around each of an (N, M, K) picture, `size` odd; mirrored at the edges.

    SciPy's `median_filter` sets up a window for each pixel and takes twice as long for the same.
    """
    edge = (size // 2, size // 2)
    mirrored = np.pad(pictures, (edge, edge, (0, 0)), mode="symmetric")
    around = sliding_window_view(mirrored, (size, size), axis=(0, 1)).reshape(*pictures.shape, size * size)
    half = size * size // 2
    return np.partition(around, half, axis=-1)[..., half]


def candidates(patch: Patch, limits: AreolaLimits, spread: float) -> list[Candidate]:
    """Possible places of the areola, best first; `spread` (m) is the expected distance from the picture's middle."""
    level, known = level_colour(patch)
    value = limits.lightness * -level[..., 0] + limits.redness * level[..., 1]
    value = np.where(known, value - np.median(value[known]) if known.any() else 0.0, 0.0)
    right, up = patch.offsets()
    expected = np.exp(-0.5 * (right**2 + up**2) / spread**2)
    found: list[Candidate] = []
    kernels = {radius: _kernels(radius, patch.pixel) for radius in limits.radii}
    sums = _Sums(value, known, [kernel for inner, sectors in kernels.values() for kernel in (inner, *sectors)])
    for radius, (inner, sectors) in kernels.items():
        disc, share = sums.mean(inner)
        step = np.full(value.shape, np.inf)
        mean_step, seen = np.zeros(value.shape), np.zeros(value.shape)
        for sector in sectors:
            around, enough = sums.mean(sector)
            there = enough > 0.4
            step = np.where(there, np.minimum(step, disc - around), step)
            mean_step += np.where(there, disc - around, 0.0)
            seen += there
        mean_step /= np.maximum(seen, 1.0)
        score = np.where((share > 0.6) & (seen >= SECTORS - 2), np.minimum(2.0 * step, mean_step), 0.0) * expected
        for _ in range(2):
            row, column = np.unravel_index(int(score.argmax()), score.shape)
            if score[row, column] <= 0.0:
                break
            found.append(
                Candidate(float(right[row, column]), float(up[row, column]), radius, float(score[row, column]))
            )
            score[np.hypot(right - right[row, column], up - up[row, column]) < radius] = 0.0
    found.sort(key=lambda each: -each.score)
    kept: list[Candidate] = []
    for each in found:
        if all(np.hypot(each.right - o.right, each.up - o.up) > 0.5 * o.radius for o in kept):
            kept.append(each)
    return kept[: limits.looked_at]


def measured(
    skin: ColouredSkin, place: Array, outwards: Array, up: Array, radius: float, floor: float
) -> Areola | None:
    """The areola whose middle is near `place` (3,) m and whose radius is about `radius` (m), or None.

    `floor` (m) is the error of a measured radius that its scatter does not show.
    """
    found: _Border | None = None
    for _ in range(ROUNDS):
        normal = skin.normal(place, outwards, max(radius, 0.008))
        patch = skin.patch(place, normal, up, 2.0 * radius + 0.008, PIXEL)
        found = _border(patch, radius)
        if found is None:
            return None
        moved = patch.place(*found.shift)
        if moved is None:
            return None
        place, radius = moved, found.radius
    assert found is not None
    rim = [patch.place(*point) for point in found.points]
    kept = np.array([point for point in rim if point is not None])
    if len(kept) < RAYS // 2:
        return None
    scatter = found.scatter
    count = max(RAYS * found.share / 4.0, 1.0)  # neighbouring rays are alike
    flat = scatter**2 * 2.0 / count
    axes = patch.axes
    covariance = flat * (axes[0][:, None] * axes[0] + axes[1][:, None] * axes[1]) + (0.25 * flat) * np.eye(3)
    return Areola(
        centre=place,
        normal=normal,
        rim=kept,
        radius=_area_radius(kept, place),
        covariance=covariance,
        radius_error=float(np.hypot(scatter / np.sqrt(count), floor)),
        contrast=found.contrast,
        clearness=found.clearness,
        roundness=scatter / radius,
        border=found.share,
    )


@dataclass(frozen=True, eq=False)
class _Border:
    shift: tuple[float, float]  # m, right and up, of the middle
    radius: float  # m
    points: Array  # (RAYS, 2) m, right and up of the picture's middle
    scatter: float  # m
    share: float
    contrast: Array
    clearness: float


def _border(patch: Patch, radius: float) -> _Border | None:
    level, known = level_colour(patch)
    right, up = patch.offsets()
    away = np.hypot(right, up)
    reach = np.full(patch.skin.shape, radius)
    angles = np.arctan2(up, right)
    turn = np.linspace(0.0, 2.0 * np.pi, RAYS, endpoint=False)
    shape = np.zeros(2 * HARMONICS + 1)
    shape[0] = radius
    for _ in range(2):
        reach = _series(shape, angles)
        inside = known & (away < 0.8 * reach)
        outside = known & (away > 1.2 * reach) & (away < 1.8 * reach + 0.002)
        if inside.sum() < 40 or outside.sum() < 40:
            return None
        contrast, axis, noise = _discriminant(level[inside], level[outside])
        low, high = (float(level[part].mean(axis=0) @ axis) for part in (outside, inside))
        if high - low <= 1e-6:
            return None
        value = np.clip((level @ axis - low) / (high - low), -0.5, 1.5)
        radii, good = _change_points(value, known, patch, turn, max(float(shape[0]), 0.004))
        if good.sum() < 0.4 * RAYS:
            return None
        shape, rest = _fitted_series(radii, good, turn)
    spread = 1.4826 * float(np.median(np.abs(rest)))
    clear = float(np.linalg.norm(contrast) / max(noise, 1e-6))
    smooth = _series(shape, turn)
    points = np.stack([smooth * np.cos(turn), smooth * np.sin(turn)], axis=1)
    shift = _centroid(points)
    return _Border(shift, float(shape[0]), points, spread + 0.0002, float(good.mean()), contrast, clear)


def _discriminant(inside: Array, outside: Array) -> tuple[Array, Array, float]:
    """((3,) difference of the means, (3,) unit axis that parts them best, noise along the difference)."""
    contrast = np.asarray(inside.mean(axis=0) - outside.mean(axis=0))
    spread = 0.5 * (np.cov(inside.T) + np.cov(outside.T)) + 0.5 * np.eye(3)
    axis = np.linalg.solve(spread, contrast)
    axis /= max(float(np.linalg.norm(axis)), 1e-12)
    along = contrast / max(float(np.linalg.norm(contrast)), 1e-12)
    return contrast, axis, float(np.sqrt(along @ spread @ along))


def _change_points(value: Array, known: Booleans, patch: Patch, turn: Array, radius: float) -> tuple[Array, Booleans]:
    """((RAYS,) m where each ray leaves the areola, (RAYS,) whether it does so at all on seen skin)."""
    steps = np.arange(STEP, 1.8 * radius, STEP)
    rows = patch.middle - steps * np.sin(turn)[:, None] / patch.pixel
    columns = patch.middle + steps * np.cos(turn)[:, None] / patch.pixel
    along = map_coordinates(value, [rows, columns], order=1, mode="nearest")
    shown = map_coordinates(known.astype(np.float64), [rows, columns], order=0, mode="constant") > 0.5
    gain = np.where(shown, 2.0 * along - 1.0, 0.0)  # (p - 0)² - (p - 1)²
    total = np.cumsum(gain, axis=1)
    best = total.argmax(axis=1)
    rows_of = np.arange(RAYS)
    inner, outer = total[rows_of, best], total[rows_of, best] - total[:, -1]
    enough = 0.15 * len(steps)
    near = np.clip(best[:, None] + np.arange(-4, 5), 0, len(steps) - 1)
    good = (inner > enough) & (outer > 0.5 * enough) & shown[rows_of[:, None], near].all(axis=1)
    return steps[best] + 0.5 * STEP, good


def _fitted_series(radii: Array, good: Booleans, turn: Array) -> tuple[Array, Array]:
    """((2 H + 1,) coefficients through the borders, (G,) m what they leave), robust against a third of wrong ones."""
    rows = _rows(turn)[good]
    weight: Array = np.ones(len(rows))
    rest: Array = np.zeros(len(rows))
    ridge = np.diag([0.0, *np.repeat([0.5, 0.5, 2.0], 2)])  # prefers a circle where a part of the border is unseen
    shape: Array = np.zeros(rows.shape[1])
    for _ in range(6):
        weighted = rows * weight[:, None]
        shape = np.asarray(np.linalg.solve(weighted.T @ rows + ridge, weighted.T @ radii[good]), dtype=np.float64)
        rest = np.asarray(radii[good] - rows @ shape, dtype=np.float64)
        scale = max(1.4826 * float(np.median(np.abs(rest))), 0.0003)
        weight = np.asarray(1.0 / (1.0 + (rest / (2.0 * scale)) ** 2) ** 2, dtype=np.float64)
    return shape, rest


def _rows(turn: Array) -> Array:
    waves = [np.ones_like(turn)]
    for k in range(1, HARMONICS + 1):
        waves += [np.cos(k * turn), np.sin(k * turn)]
    return np.stack(waves, axis=-1)


def _series(shape: Array, turn: Array) -> Array:
    return np.maximum(_rows(turn) @ shape, 0.002)


def _centroid(points: Array) -> tuple[float, float]:
    """Centroid of the polygon (P, 2)."""
    after = np.roll(points, -1, axis=0)
    cross = points[:, 0] * after[:, 1] - points[:, 1] * after[:, 0]
    middle = ((points + after) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum())
    return float(middle[0]), float(middle[1])


def _area_radius(rim: Array, centre: Array) -> float:
    """m, of the circle of the same area as the fan from the centre to the border (both on the skin)."""
    around = rim - centre
    areas = 0.5 * np.linalg.norm(np.cross(around, np.roll(around, -1, axis=0)), axis=1)
    return float(np.sqrt(areas.sum() / np.pi))


def _kernels(radius: float, pixel: float) -> tuple[Array, list[Array]]:
    """A disc, and the sectors of the ring around it."""
    count = int(np.ceil(1.7 * radius / pixel))
    steps = pixel * np.arange(-count, count + 1)
    across, down = np.meshgrid(steps, steps)
    away, angle = np.hypot(across, down), np.arctan2(down, across)
    ring = (away > 1.2 * radius) & (away < 1.65 * radius)
    part = np.floor((angle + np.pi) / (2.0 * np.pi) * SECTORS).astype(np.int64) % SECTORS
    return (away < 0.8 * radius).astype(np.float64), [(ring & (part == k)).astype(np.float64) for k in range(SECTORS)]


class _Sums:
    """Sums of a picture under many kernels, all smaller than it, by transforms; nothing lies beside the picture."""

    def __init__(self, value: Array, known: Booleans, kernels: Iterable[Array]) -> None:
        """(N, M) values and which of them are known; the largest of the kernels says how much room they need."""
        self.size = value.shape
        needed = np.max([kernel.shape for kernel in kernels], axis=0) + self.size - 1
        self.room = tuple(next_fast_len(int(n), real=True) for n in needed)
        self.known = rfft2(known.astype(np.float64), self.room)
        self.total = rfft2(np.where(known, value, 0.0), self.room)

    def mean(self, kernel: Array) -> tuple[Array, Array]:
        """((N, M) mean of the known values under the kernel, (N, M) share of it that is known)."""
        turned = rfft2(kernel[::-1, ::-1], self.room)
        first = [(k - 1) // 2 for k in kernel.shape]
        place = tuple(slice(f, f + n) for f, n in zip(first, self.size, strict=True))
        weight = np.maximum(irfft2(self.known * turned, self.room)[place], 0.0)
        total = irfft2(self.total * turned, self.room)[place]
        return np.asarray(total / np.maximum(weight, 0.5)), np.asarray(weight / kernel.sum())

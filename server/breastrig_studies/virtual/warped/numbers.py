"""Random parameters of one warped body: its proportions, its asymmetry, its bumps, and its kind of scan.

The ranges are wide but those of people: the issue's own (segments 15 %, navel 40 mm, folds 20 mm), the rest so that no
body looks monstrous.
"""

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

SEGMENT = 0.15  # share, of each of the three segments of the trunk
NAVEL = 0.040  # m along the midline
FOLD = 0.020  # m, both inframammary folds; one of them up to FOLD_APART more, within FOLD
FOLD_APART = 0.006  # m
SHOULDER = 0.022  # m, acromion up or down: some ten degrees of slope
SPACING = 0.012  # m, each breast sideways
BASE = 0.15  # share, width of the breasts' base
SIZE = 0.15  # share, breasts' size
HIPS = 0.10  # share, width and depth
ONE_SIDED = 0.35  # share of the bodies with one breast of another size and height
ONE_SIZE = 0.18  # share
ONE_HEIGHT = 0.018  # m
MASTECTOMY = 0.10  # share of the bodies
BUMPS = (5, 10)  # how many
BUMP_LENGTH = (0.080, 0.250)  # m
BUMP_SIZE = 0.010  # m, all bumps together about so at most
HANGING = 0.25  # share of the bodies
HANGING_NIPPLE = (-0.045, 0.020)  # m above the fold: from Regnault's III to none
HANGING_APART = 0.008  # m between the sides
SAG = 0.030  # m, of the lower pole of every other one of them
CAPTURES = {  # share of the bodies
    "ordinary": 0.64,
    "poor_sensor": 0.08,
    "large_holes": 0.08,
    "left_half": 0.05,
    "one_side": 0.05,
    "above_nipples": 0.05,
    "below_nipples": 0.05,
}


@dataclass(frozen=True)
class Numbers:
    """One body's numbers; lengths in m, shares of one; the left value comes first in pairs."""

    notch_xiphoid: float = 0.0  # share longer
    xiphoid_navel: float = 0.0
    navel_hips: float = 0.0
    navel_up: float = 0.0  # m, after the segments
    folds_up: tuple[float, float] = (0.0, 0.0)  # m
    shoulders_up: float = 0.0  # m at the acromion
    apart: float = 0.0  # m, each breast away from the midline
    base: float = 0.0  # share wider
    sizes: tuple[float, float] = (0.0, 0.0)  # share larger
    heights: tuple[float, float] = (0.0, 0.0)  # m, breasts up
    hips: float = 0.0  # share wider
    mastectomy: str = ""  # L | R | ""
    bumps: tuple[tuple[float, ...], ...] = ()  # skin share, length m, x y z m
    nipples_over_folds: tuple[float, float] | None = None  # m, where the breasts hang; they do not: as they are
    sag: float = 0.0  # m, of their lower poles

    def written(self) -> dict[str, Any]:
        """The numbers as a JSON document."""
        return asdict(self)


def draw_numbers(random: np.random.Generator) -> Numbers:
    """All numbers of one body from its generator."""

    def within(limit: float) -> float:
        return float(random.uniform(-limit, limit))

    upper, middle, lower = (within(SEGMENT) for _ in range(3))
    navel, shoulders, apart, base, hips = (within(each) for each in (NAVEL, SHOULDER, SPACING, BASE, HIPS))
    fold, between = within(FOLD), within(FOLD_APART)
    size = within(SIZE)
    sizes, heights = [size, size], [0.0, 0.0]
    if random.random() < ONE_SIDED:
        side = int(random.integers(2))
        sizes[side] += within(ONE_SIZE)
        heights[side] += within(ONE_HEIGHT)
    mastectomy = ("L", "R")[int(random.integers(2))] if random.random() < MASTECTOMY else ""
    folds = np.clip([fold + between, fold - between], -FOLD, FOLD)
    count = int(random.integers(BUMPS[0], BUMPS[1] + 1))
    bumps = tuple(
        (
            float(random.random()),
            float(random.uniform(*BUMP_LENGTH)),
            *(float(x) for x in random.uniform(-1.0, 1.0, 3) * BUMP_SIZE / np.sqrt(count / 2.0)),
        )
        for _ in range(count)
    )
    return Numbers(
        upper,
        middle,
        lower,
        navel,
        (float(folds[0]), float(folds[1])),
        shoulders,
        apart,
        base,
        (sizes[0], sizes[1]),
        (heights[0], heights[1]),
        hips,
        mastectomy,
        bumps,
    )


def with_hanging(numbers: Numbers, random: np.random.Generator) -> Numbers:
    """The numbers of the same body with breasts that hang, from a generator of their own."""
    both, apart = float(random.uniform(*HANGING_NIPPLE)), float(random.uniform(-HANGING_APART, HANGING_APART))
    sag = float(random.uniform(0.0, SAG)) * float(random.random() < 0.5)
    return replace(numbers, nipples_over_folds=(both + apart, both - apart), sag=sag)


def draw_capture(random: np.random.Generator) -> str:
    """A random kind of scan."""
    return str(random.choice(list(CAPTURES), p=list(CAPTURES.values())))

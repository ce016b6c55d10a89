"""Women drawn at random from MakeHuman's adult dials, far broader than the seven: for what gravity does to breasts."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from virtual_patient.woman import AVERAGE, OLDEST, YOUNGEST, Sides, Woman

DETAILS = (  # local targets, pairs of opposites
    ("breast/breast-dist-incr", "breast/breast-dist-decr"),
    ("breast/breast-point-incr", "breast/breast-point-decr"),
    ("breast/breast-trans-up", "breast/breast-trans-down"),
    ("breast/breast-volume-vert-up", "breast/breast-volume-vert-down"),
    ("torso/torso-scale-depth-incr", "torso/torso-scale-depth-decr"),
    ("torso/torso-scale-horiz-incr", "torso/torso-scale-horiz-decr"),
    ("torso/torso-scale-vert-incr", "torso/torso-scale-vert-decr"),
    ("torso/torso-vshape-incr", "torso/torso-vshape-decr"),
    ("torso/torso-muscle-pectoral-incr", "torso/torso-muscle-pectoral-decr"),
    ("stomach/stomach-tone-incr", "stomach/stomach-tone-decr"),
)
DETAIL = 0.35  # standard deviation of each


def sampled(number: int) -> Woman:
    """The woman of that number; the same number is the same woman."""
    rng = np.random.default_rng(number)

    def dial(middle: float, spread: float) -> float:
        return float(np.clip(rng.normal(middle, spread), -1.0, 1.0))

    def sides(value: float, apart: float) -> Sides:
        left, right = np.clip(value + apart * rng.normal(size=2), -1.0, 1.0)
        return float(left), float(right)

    details = []
    for more, less in DETAILS:
        amount = dial(0.0, DETAIL)
        details.append((more if amount > 0.0 else less, (abs(amount), abs(amount))))
    origin = rng.dirichlet([1.0, 1.0, 1.0])
    weight = float(rng.uniform(-1.0, 1.0))
    return Woman(
        name=f"woman_{number:04d}",
        size=AVERAGE.size,  # not measured
        years=float(rng.uniform(YOUNGEST, OLDEST)),
        origin=(float(origin[0]), float(origin[1]), float(origin[2])),
        muscle=dial(0.0, 0.35),
        weight=weight,
        height=dial(0.1, 0.3),
        proportions=dial(0.0, 0.4),
        cup=sides(float(rng.uniform(-0.9, 1.0)), 0.12),
        firmness=sides(float(rng.uniform(-0.9, 0.7)), 0.1),
        girth=float(rng.uniform(0.0, 0.9)) + 0.3 * max(weight, 0.0),
        details=tuple(details),
        softness=1.0,
        belly=1.0,
        standing_arms=(0.0, 0.0),
        lying_arms=(0.0, 0.0),
        lean=0.0,
        asymmetric=True,
    )


def heavy(number: int) -> Woman:
    """The woman of that number with MakeHuman's most weight, a large belly and heavy breasts."""
    woman, rng = sampled(number), np.random.default_rng((number, 1))
    cup, soft = rng.uniform(0.4, 1.0, 2), rng.uniform(-1.0, -0.2, 2)
    belly = float(rng.uniform(0.2, 0.8))
    return replace(
        woman,
        weight=1.0,
        girth=float(rng.uniform(0.8, 1.6)),
        cup=(float(cup[0]), float(0.8 * cup[0] + 0.2 * cup[1])),
        firmness=(float(soft[0]), float(0.8 * soft[0] + 0.2 * soft[1])),
        details=(*woman.details, ("stomach/stomach-pregnant-incr", (belly, belly))),
    )


def man(number: int) -> Woman:
    """The man of that number; every other one has breasts (gynaecomastia), of which some hang."""
    drawn, rng = sampled(number), np.random.default_rng((number, 2))
    cup = float(rng.uniform(0.08, 0.4)) if number % 2 else 0.0
    firm = float(rng.uniform(-0.6, 0.4))
    return replace(
        drawn,
        name=f"man_{number:04d}",
        sex="male",
        cup=(cup, cup * float(rng.uniform(0.7, 1.0))),
        firmness=(firm, firm),
        girth=0.5 * drawn.girth,
        details=tuple(detail for detail in drawn.details if not detail[0].startswith("breast/")),
        softness=0.4 + float(np.sqrt(cup)),  # muscle hardly moves
    )


def uneven(number: int) -> Woman:
    """The woman of that number with breasts of different sizes that hang."""
    woman, rng = sampled(number), np.random.default_rng((number, 2))
    large, soft = rng.uniform(0.2, 1.0), float(rng.uniform(-1.0, -0.4))
    small = large - rng.uniform(0.4, 1.0)
    cup = (float(large), float(small)) if rng.random() < 0.5 else (float(small), float(large))
    return replace(
        woman, cup=cup, firmness=(soft, soft), details=(*woman.details, ("breast/breast-trans-down", (0.3, 0.3)))
    )


def implants(number: int) -> Woman:
    """The woman of that number with firm breasts, full above, which gravity changes little."""
    woman, rng = sampled(number), np.random.default_rng((number, 3))
    cup, firm, full = rng.uniform((0.3, 0.7, 0.3), (1.0, 1.0, 0.9)).tolist()
    details = (*woman.details, ("breast/breast-volume-vert-up", (full, full)))
    return replace(woman, cup=(cup, cup), firmness=(firm, firm), details=details, softness=0.25)


def one_breast(number: int) -> Woman:
    """The woman of that number with next to nothing on one side; the rest is taken away where she is posed."""
    woman, left = sampled(number), np.random.default_rng((number, 4)).random() < 0.5
    none, other = (-1.0, 1.0), (woman.cup[1], woman.firmness[1])
    cup, firmness = zip(none, other, strict=True) if left else zip(other, none, strict=True)
    return replace(woman, cup=cup, firmness=firmness)


KINDS: dict[str, Callable[[int], Woman]] = {
    "usual": sampled,
    "heavy": heavy,
    "uneven": uneven,
    "implants": implants,
    "one_breast": one_breast,
}

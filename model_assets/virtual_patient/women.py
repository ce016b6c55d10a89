"""The seven women of the virtual cohort: MakeHuman's adult dials, mixed as MakeHuman mixes them.

Her sizes are French, as the paper's are: the band is the girth under the breasts plus 15 cm, a cup of A, B or C is
a bust 13, 15 or 17 cm larger than that girth (the middles of EN 13402-3's classes).  `weight`, `girth` and `cup`
were found by trial so that girths measured on the skin meet the size; make_cohort.py measures them again.

Not combinations of our own shapes: weight, muscle, height and proportions move all at once and multiply with the
breast's size and firmness (each a sculpt of its own for its age, muscle and weight), and the local targets are
among those that the model's recipe does not use.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from steps.source import Array, Source
from virtual_patient.body import side_mask

YOUNGEST, OLDEST = 25.0, 90.0  # years that MakeHuman's "young" and "old" stand for; nobody here is younger
ORIGINS = ("african", "asian", "caucasian")
GIRTH = (  # MakeHuman's women are slight: 68 cm under the breasts; a larger trunk is larger from neck to hips
    ("torso/torso-scale-horiz-incr", 1.0),
    ("torso/torso-scale-depth-incr", 1.0),
    ("torso/measure-underbust-circ-incr", 0.3),
    ("hip/hip-scale-horiz-incr", 0.5),
    ("hip/hip-scale-depth-incr", 0.5),
    ("stomach/stomach-pregnant-incr", 0.15),
    ("neck/neck-scale-horiz-incr", 0.5),
    ("neck/neck-scale-depth-incr", 0.5),
)
Sides = tuple[float, float]  # left, right


@dataclass(frozen=True)
class Woman:
    """Dials from -1 (MakeHuman's least) over 0 (average) to 1 (most)."""

    name: str
    size: str  # French
    years: float
    origin: tuple[float, float, float]  # shares of ORIGINS, sum 1
    muscle: float
    weight: float
    height: float
    proportions: float  # from uncommon to ideal
    cup: Sides
    firmness: Sides
    girth: float  # how much of GIRTH, from 0
    details: tuple[tuple[str, Sides], ...]  # local targets and how much on each side
    softness: float  # of her breasts' tissue lying down, 1 is the example's
    belly: float  # the same for the belly
    standing_arms: Sides  # degrees of abduction against MakeHuman's pose
    lying_arms: Sides
    lean: float  # degrees of the chest to her left, standing
    asymmetric: bool = False

    @property
    def band(self) -> int:
        return int(self.size[:-1])

    @property
    def cup_letter(self) -> str:
        return self.size[-1]


def both(name: str, amount: float) -> tuple[str, Sides]:
    return name, (amount, amount)


AVERAGE = Woman(  # where the shared mesh is cut
    name="average",
    size="95B",
    years=45,
    origin=(1 / 3, 1 / 3, 1 / 3),
    muscle=0.0,
    weight=0.0,
    height=0.0,
    proportions=0.0,
    cup=(0.0, 0.0),
    firmness=(0.0, 0.0),
    girth=0.0,
    details=(),
    softness=1.0,
    belly=1.0,
    standing_arms=(0, 0),
    lying_arms=(0, 0),
    lean=0.0,
)

WOMEN = (
    Woman(
        name="patient_1",
        size="95A",
        years=31,
        origin=(0.1, 0.2, 0.7),
        muscle=0.35,
        weight=-0.1,
        height=0.13,
        proportions=0.3,
        cup=(-0.6, -0.6),
        firmness=(0.35, 0.30),
        girth=0.35,
        details=(
            both("torso/torso-scale-depth-decr", 0.25),
            both("torso/torso-vshape-incr", 0.3),
            both("breast/breast-dist-incr", 0.3),
            both("stomach/stomach-tone-incr", 0.4),
            ("breast/breast-trans-up", (0.15, 0.0)),
        ),
        softness=0.8,
        belly=0.7,
        standing_arms=(-9, -7),
        lying_arms=(6, 9),
        lean=-0.8,
    ),
    Woman(
        name="patient_2",
        size="95B",
        years=43,
        origin=(0.0, 0.9, 0.1),
        muscle=-0.2,
        weight=0.1,
        height=0.03,
        proportions=-0.2,
        cup=(0.43, 0.43),
        firmness=(0.05, -0.05),
        girth=0.77,
        details=(
            both("torso/torso-scale-horiz-decr", 0.2),
            both("hip/hip-scale-horiz-incr", 0.2),
            both("breast/breast-point-decr", 0.4),
            ("breast/breast-dist-decr", (0.2, 0.0)),
            both("stomach/stomach-navel-in", 0.6),
        ),
        softness=1.0,
        belly=0.9,
        standing_arms=(-6, -8),
        lying_arms=(5, 3),
        lean=1.0,
    ),
    Woman(
        name="patient_3",
        size="95C",
        years=38,
        origin=(0.6, 0.0, 0.4),
        muscle=0.1,
        weight=0.2,
        height=0.1,
        proportions=0.2,
        cup=(0.13, 0.13),
        firmness=(-0.1, -0.15),
        girth=0.31,
        details=(
            both("torso/torso-scale-vert-incr", 0.15),
            both("breast/breast-volume-vert-up", 0.3),
            both("hip/hip-waist-up", 0.3),
            ("breast/breast-trans-down", (0.0, 0.2)),
            both("stomach/stomach-navel-in", 0.7),
        ),
        softness=1.05,
        belly=1.0,
        standing_arms=(-6, -9),
        lying_arms=(8, 4),
        lean=0.5,
    ),
    Woman(
        name="patient_4",
        size="100B",
        years=52,
        origin=(0.3, 0.3, 0.4),
        muscle=-0.1,
        weight=0.4,
        height=0.07,
        proportions=-0.1,
        cup=(0.02, 0.02),
        firmness=(-0.2, -0.2),
        girth=0.56,
        details=(
            both("torso/torso-scale-depth-incr", 0.25),
            both("stomach/stomach-pregnant-incr", 0.06),
            both("breast/breast-dist-incr", 0.35),
            both("neck/neck-scale-depth-incr", 0.2),
            ("asym/asymm-trunk-1-l", (0.2, 0.2)),
            both("stomach/stomach-navel-in", 0.8),
        ),
        softness=1.05,
        belly=1.05,
        standing_arms=(-8, -6),
        lying_arms=(10, 7),
        lean=-1.2,
    ),
    Woman(
        name="patient_5",
        size="100C",
        years=47,
        origin=(0.0, 0.1, 0.9),
        muscle=0.0,
        weight=0.35,
        height=0.16,
        proportions=0.0,
        cup=(0.38, -0.12),
        firmness=(-0.3, 0.0),
        girth=0.7,
        details=(
            both("torso/torso-vshape-decr", 0.2),
            both("breast/breast-point-decr", 0.2),
            ("breast/breast-trans-down", (0.2, 0.0)),
            both("stomach/stomach-navel-in", 0.8),
        ),
        softness=1.0,
        belly=1.0,
        standing_arms=(-7, -9),
        lying_arms=(6, 6),
        lean=1.3,
        asymmetric=True,
    ),
    Woman(
        name="patient_6",
        size="105B",
        years=68,
        origin=(0.2, 0.1, 0.7),
        muscle=-0.35,
        weight=0.6,
        height=0.05,
        proportions=-0.3,
        cup=(0.14, 0.14),
        firmness=(-0.35, -0.3),
        girth=0.66,
        details=(
            both("stomach/stomach-tone-decr", 0.4),
            both("torso/torso-scale-depth-incr", 0.15),
            both("hip/hip-trans-forward", 0.1),
            ("breast/breast-dist-incr", (0.3, 0.15)),
            both("pelvis/pelvis-tone-decr", 0.3),
            both("stomach/stomach-navel-in", 0.9),
        ),
        softness=1.15,
        belly=1.15,
        standing_arms=(-7, -9),
        lying_arms=(12, 8),
        lean=0.6,
    ),
    Woman(
        name="patient_7",
        size="110C",
        years=58,
        origin=(0.4, 0.0, 0.6),
        muscle=0.0,
        weight=0.85,
        height=0.12,
        proportions=-0.2,
        cup=(0.29, 0.29),
        firmness=(-0.25, -0.35),
        girth=0.98,
        details=(
            both("torso/torso-scale-horiz-incr", 0.2),
            both("stomach/stomach-tone-decr", 0.3),
            both("breast/breast-volume-vert-down", 0.25),
            ("breast/breast-trans-up", (0.0, 0.2)),
            both("neck/neck-scale-horiz-incr", 0.3),
            both("stomach/stomach-navel-in", 0.9),
        ),
        softness=1.1,
        belly=1.2,
        standing_arms=(-8, -6),
        lying_arms=(14, 12),
        lean=-0.6,
    ),
)


def figure(source: Source, woman: Woman) -> Array:
    """(S, 3) m: what makes this woman of MakeHuman's androgynous base."""
    old = (woman.years - YOUNGEST) / (OLDEST - YOUNGEST)
    if not 0.0 <= old <= 1.0:
        raise ValueError(f"{woman.name} is {woman.years} years old; only adults from {YOUNGEST} to {OLDEST} are made.")
    ages = {"young": 1.0 - old, "old": old}
    muscle, weight = _levels(woman.muscle, "muscle"), _levels(woman.weight, "weight")
    height = _levels(woman.height, "height")
    proportions = {"uncommonproportions": max(-woman.proportions, 0.0), "idealproportions": max(woman.proportions, 0.0)}
    result = np.zeros_like(source.vertices)
    for (age, a), (origin, b) in product(ages.items(), zip(ORIGINS, woman.origin, strict=True)):
        result += a * b * _target(source, f"macrodetails/{origin}-female-{age}")
    sides = [side_mask(source.vertices[:, 0], side)[:, None] for side in ("L", "R")]
    for (age, a), (m, b), (w, c) in product(ages.items(), muscle.items(), weight.items()):
        share, kind = a * b * c, f"female-{age}-{m}-{w}"
        if share == 0.0:
            continue
        result += share * _target(source, f"macrodetails/universal-{kind}")
        for tall, part in height.items():
            if tall != "averageheight" and part:
                result += share * part * _target(source, f"macrodetails/height/{kind}-{tall}")
        for ideal, part in proportions.items():
            if part:
                result += share * part * _target(source, f"macrodetails/proportions/{kind}-{ideal}")
        for mask, cup, firm in zip(sides, woman.cup, woman.firmness, strict=True):
            for (size, d), (soft, e) in product(_levels(cup, "cup").items(), _levels(firm, "firmness").items()):
                if d * e and (size, soft) != ("averagecup", "averagefirmness"):
                    result += share * d * e * mask * _target(source, f"breast/{kind}-{size}-{soft}")
    for name, part in GIRTH:
        result += woman.girth * part * _target(source, name)
    for name, amounts in woman.details:
        for mask, amount in zip(sides, amounts, strict=True):
            if amount:
                result += amount * mask * _target(source, name)
    return result


def vertices_of(source: Source, woman: Woman) -> Array:
    """(S, 3) m: her skin in MakeHuman's pose; her pelvis is where the average woman has it, whatever her height."""
    result = source.vertices + figure(source, woman)
    average = source.vertices + figure(source, AVERAGE)
    shift = source.joint("pelvis", average) - source.joint("pelvis", result)
    return result + shift * [0.0, 1.0, 1.0]


def _levels(dial: float, what: str) -> dict[str, float]:
    """Shares of MakeHuman's least, average and most; a dial from -1 to 1."""
    if not -1.0 <= dial <= 1.0:
        raise ValueError(f"{what} is {dial}; MakeHuman's sculpts hold from -1 to 1.")
    return {f"min{what}": max(-dial, 0.0), f"average{what}": 1.0 - abs(dial), f"max{what}": max(dial, 0.0)}


_TARGETS: dict[str, Array] = {}


def _target(source: Source, name: str) -> Array:
    """Read once: unpacking the text is most of the work."""
    if name not in _TARGETS:
        _TARGETS[name] = source.target(name)
    return _TARGETS[name]

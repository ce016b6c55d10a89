"""One woman, or man, of MakeHuman's adult dials, mixed as MakeHuman mixes them."""

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
    sex: str = "female"  # or "male", whose cup is a woman's breast of the same age, muscle and weight, from 0

    @property
    def band(self) -> int:
        return int(self.size[:-1])

    @property
    def cup_letter(self) -> str:
        return self.size[-1]


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
        result += a * b * _target(source, f"macrodetails/{origin}-{woman.sex}-{age}")
    sides = [side_mask(source.vertices[:, 0], side)[:, None] for side in ("L", "R")]
    for (age, a), (m, b), (w, c) in product(ages.items(), muscle.items(), weight.items()):
        share, kind = a * b * c, f"{woman.sex}-{age}-{m}-{w}"
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
                flat = size == "averagecup" and (woman.sex == "male" or soft == "averagefirmness")
                if d * e and not flat:
                    result += share * d * e * mask * _target(source, f"breast/female-{age}-{m}-{w}-{size}-{soft}")
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

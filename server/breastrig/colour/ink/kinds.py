"""Classifies strokes: lines of the plan, marks beside it (crosses, arrows, writing), or not part of a plan.

Lines are closed, dashed or plain. Letters, numbers and arrow heads turn within millimetres, lines of a plan do not. A
tattoo is writing too, only more of it than a surgeon writes in one place, and black; where nothing but marks is found,
they are none of a plan.
"""

from enum import Enum

import numpy as np
from scipy.spatial import cKDTree

from breastrig.colour.ink import limits
from breastrig.colour.ink.strokes import Stroke
from breastrig.core.arrays import Array, Booleans
from breastrig.geometry.boundary import components


class Kind(Enum):
    """The kind of a stroke, as written in drawings and answers."""

    LINE = "line"
    CLOSED = "closed"
    DASHED = "dashed"
    CROSS = "cross"
    ARROW = "arrow"
    WRITING = "writing"

    @property
    def is_mark(self) -> bool:
        """Whether it is a mark beside the plan, not a line of it."""
        return self in (Kind.CROSS, Kind.ARROW, Kind.WRITING)


def sorted_out(strokes: list[Stroke]) -> list[tuple[Stroke, Kind]]:
    """The strokes that belong to a plan, longest first, each with its kind."""
    near = _distances(strokes)
    large = np.array([stroke.length >= limits.LENGTH for stroke in strokes], dtype=np.bool_)
    kept = np.flatnonzero(large | (near[:, large] < limits.DETAIL_REACH).any(axis=1))
    strokes, near = [strokes[number] for number in kept], near[np.ix_(kept, kept)]
    turns = np.array([turn(stroke) for stroke in strokes])
    kinds = [_line(stroke) for stroke in strokes]
    for kind, numbers in (
        (Kind.WRITING, set(np.flatnonzero(_writing(strokes, near, turns)).tolist())),
        (Kind.ARROW, _arrows(strokes, near, turns)),
        (Kind.CROSS, _crosses(strokes, near, turns)),
    ):
        for number in numbers:
            kinds[number] = kind
    tattooed = _tattoos(strokes, near, turns)
    found = [(stroke, kind) for stroke, kind, no in zip(strokes, kinds, tattooed, strict=True) if not no]
    if max((stroke.length for stroke, kind in found if not kind.is_mark), default=0.0) < limits.PLAN:
        return []
    return sorted(found, key=lambda each: -each[0].length)


def turn(stroke: Stroke) -> float:
    """rad for each m by which the stroke turns, on average."""
    places = stroke.places[::2]
    way = np.diff(places, axis=0)
    lengths = np.linalg.norm(way, axis=1)
    way = way[lengths > 1e-6] / lengths[lengths > 1e-6, None]
    if len(way) < 2:
        return 0.0
    angles = np.arccos(np.clip(np.einsum("mi,mi->m", way[1:], way[:-1]), -1.0, 1.0))
    return float(angles.sum() / lengths.sum())


def _distances(strokes: list[Stroke]) -> Array:
    """(N, N) m between the nearest places of two strokes; inf beyond what counts as near, and to themselves."""
    near = np.full((len(strokes), len(strokes)), np.inf)
    if not strokes:
        return near
    places = np.concatenate([stroke.places for stroke in strokes])
    owner = np.repeat(np.arange(len(strokes)), [len(stroke.places) for stroke in strokes])
    pairs = cKDTree(places).query_pairs(limits.WORD, output_type="ndarray").astype(np.int64)
    one, other = pairs.T
    apart = owner[one] != owner[other]
    one, other = one[apart], other[apart]
    distance = np.linalg.norm(places[one] - places[other], axis=1)
    np.minimum.at(near, (owner[one], owner[other]), distance)
    return np.asarray(np.minimum(near, near.T))


def _line(stroke: Stroke) -> Kind:
    if stroke.closed:
        return Kind.CLOSED
    runs = np.flatnonzero(np.diff(np.concatenate([[False], stroke.drawn, [False]]).astype(np.int8)))
    starts, ends = runs[::2], runs[1::2]
    gaps = (starts[1:] - ends[:-1]) * limits.SPACING
    dashes = 1 + int((gaps >= limits.DASH_GAP).sum())
    return Kind.DASHED if dashes >= limits.DASHES and stroke.length / dashes <= limits.DASH else Kind.LINE


def _writing(strokes: list[Stroke], near: Array, turns: Array) -> Booleans:
    """(N,) curly strokes, and short ones beside them."""
    curly = np.asarray(turns > limits.CURLY)
    short = np.array([stroke.length <= limits.WORD_STROKE for stroke in strokes], dtype=np.bool_)
    return np.asarray(curly | (short & (near[:, curly] < limits.WORD).any(axis=1)))


def _tattoos(strokes: list[Stroke], near: Array, turns: Array) -> Booleans:
    """(N,) strokes of black words that are too long."""
    found = np.zeros(len(strokes), dtype=np.bool_)
    spread = np.array([np.ptp(stroke.added) / max(float(stroke.added.max()), 1e-6) for stroke in strokes])
    numbers = np.flatnonzero(_writing(strokes, near, turns) & (spread < limits.GREY))
    if len(numbers):
        first, second = np.nonzero(near[np.ix_(numbers, numbers)] < limits.WORD)
        count, word = components(len(numbers), first, second)
        lengths = np.bincount(word, [strokes[number].length for number in numbers], count)
        found[numbers] = lengths[word] > limits.TATTOO
    return found


def _arrows(strokes: list[Stroke], near: Array, turns: Array) -> set[int]:
    """Shafts, and heads at one of their ends."""
    found: set[int] = set()
    heads = [
        number
        for number, stroke in enumerate(strokes)
        if stroke.length <= limits.ARROW_HEAD and turns[number] > limits.CURLY
    ]
    for shaft, stroke in enumerate(strokes):
        if stroke.closed or stroke.length > limits.ARROW or turns[shaft] > limits.STRAIGHT_STROKE:
            continue
        for head in heads:
            if head == shaft or near[shaft, head] > limits.ARROW_TIP or strokes[head].length > stroke.length:
                continue
            others = strokes[head].places
            tips = np.linalg.norm(stroke.places[[0, -1], None] - others[None], axis=2).min(axis=1)
            # the head is at one end, and alone there: a letter has more strokes
            if tips.min() <= limits.ARROW_TIP and (near[head] < limits.ARROW_TIP).sum() == 1:
                found |= {shaft, head}
    return found


def _crosses(strokes: list[Stroke], near: Array, turns: Array) -> set[int]:
    """Short straight strokes whose middle another one passes; two short ones are both arms."""
    found: set[int] = set()
    for arm, stroke in enumerate(strokes):
        if stroke.closed or stroke.length > limits.CROSS or turns[arm] > limits.CURLY:
            continue
        middle = stroke.places[len(stroke.places) // 2]
        along = stroke.places[-1] - stroke.places[0]
        for other in np.flatnonzero(near[arm] < limits.CROSS_MIDDLE):
            places = strokes[other].places
            at = int(np.argmin(np.linalg.norm(places - middle, axis=1)))
            if np.linalg.norm(places[at] - middle) > limits.CROSS_MIDDLE or not 2 <= at < len(places) - 2:
                continue
            way = places[min(at + 4, len(places) - 1)] - places[max(at - 4, 0)]
            if abs(along @ way) < limits.CROSS_ANGLE * np.linalg.norm(along) * np.linalg.norm(way):
                found.add(arm)
    return found

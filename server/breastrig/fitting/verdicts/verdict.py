"""Is this a torso, and does the model lie on it rightly?  A level and its reasons, from a fit's signals.

Each signal has a limit, kept as data with its reason beside the rig, beyond which no right fit of a torso was found;
what is less the line error says (docs/decisions/0035).  Each signal has its errors, so one alone never refuses a scan:
what several of them say together is certain, what one says makes the fit unusable at most.  Of a rig without limits a
fit is uncalibrated: neither good nor bad, unless something speaks against it without them.

Whether the body has the size of an adult woman, which scans of photogrammetry do not have by themselves: lengths on the
trunk say how much larger it is than most, by generalised least squares over their logarithms, whose covariance is that
of women plus the fit's errors.  Kept beside the rig; docs/decisions/0022.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from breastrig.core.arrays import Array
from breastrig.core.settings_file import Positive, SettingsPart
from breastrig.core.stances import STANCES, STANDING
from breastrig.correspondence.distances import Comparison
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.task import PickIssue
from breastrig.fitting.uncertainty.radii import HOLDS_90, Radii, radii, seen_vertices
from breastrig.fitting.verdicts.fit_signals import FitSignals, fit_signals
from breastrig.fitting.verdicts.reasons import GivenLandmarks, Reason, of_agreed, of_doubts, of_lesions, sentences
from breastrig.least_squares.newton import Status
from breastrig.rig.known import NOT_CALIBRATED, known_part
from breastrig.rig.model import Rig
from breastrig.rig.near_breasts import near_breasts
from breastrig.rig.similarity import body_axes
from breastrig.rig.stance_priors import in_stance
from breastrig.scan.piece import BallInside
from breastrig.scan.unscaled import unscaled

SEEN = 0.015  # m from the scan to a landmark that is seen
AXES = {"left": 0, "up": 1}


class Length(SettingsPart):
    """Between two landmarks along an axis of the body."""

    ends: tuple[str, str]
    along: Literal["left", "up"]
    mean: Positive  # m, of women
    spread: Positive  # standard deviation of its logarithm
    error: Positive  # likewise, what fit and definitions add
    stances: tuple[str, ...] = STANCES  # in which it is as long


class SizeLimits(SettingsPart):
    asked: Positive  # standard deviations from the mean size, from which on it is asked about
    unlikely: Positive  # likewise, from which on the fit is to be checked before anything is measured in it
    correlation: float  # of the lengths among women
    lengths: tuple[Length, ...]


def times_larger(
    rig: Rig, vertices: Array, target: ScanTarget, stance: str, limits: SizeLimits
) -> tuple[float, float] | None:
    """(size of (V, 3) m fitted vertices relative to most women, deviations from it); None without a seen length."""
    if not {end for length in limits.lengths for end in length.ends} <= {*rig.landmark_names}:
        return None
    axes, seen, gaps = body_axes(rig, vertices), [], []
    for length in (each for each in limits.lengths if stance in each.stances):
        ends = rig.landmark_points(length.ends).positions(vertices, rig.faces)
        apart = abs(float((ends[0] - ends[1]) @ axes[:, AXES[length.along]]))
        if np.isfinite(target.vertex_tree.query(ends, distance_upper_bound=SEEN)[0]).all() and apart > 0.0:
            seen.append(length)
            gaps.append(np.log(apart / length.mean))
    if not seen:
        return None
    spreads = np.array([length.spread for length in seen])
    among = np.where(np.eye(len(seen)) > 0.0, 1.0, limits.correlation) * np.outer(spreads, spreads)
    precision = np.linalg.inv(among + np.diag([length.error**2 for length in seen]))
    size = float(precision.sum(axis=0) @ np.array(gaps) / precision.sum())
    return float(np.exp(size)), size * float(np.sqrt(precision.sum()))


Level = Literal["good", "uncalibrated", "check", "unusable"]
About = Literal["", "lines", "size"]  # the width of lines; the size of the scan, which a measured length would answer
UNKNOWN_MODEL = Reason(
    f"{NOT_CALIBRATED}: nobody has measured what its right fits look like", ("judge this one by eye",)
)
NO_SKIN = Reason("The model found no skin that faces as it does", ("check the scan",))
NOT_CONVERGED = "The fit did not converge"
FAR_LINES, WITH_MARGIN = "Lines may be far off", "plan with their margin"  # whose number stands beside it
UNKNOWN_LINES = "Where lines on the breasts lie is not known"
OTHER_STANCE = "How far off a fit of a {} body may be has not been measured"
LOOK_CLOSELY = "look at it closely"
FAR = "With what is far from the breasts: "
SIZE = "The trunk is {:.0f} % {} than most women's: the patient may be {}, or the scan without a true scale"
UNKNOWN = "The size of this scan is not known, and all errors allow for {:.0f} % of it"
SIZES = (SIZE.partition("{")[0], UNKNOWN.partition(",")[0])  # how they begin
MEASURE_ANY = "measure a straight length on the patient, and give it as the true size"
MEASURE = (
    "measure on the patient the straight way from {} to {}, {:.0f} cm in this scan, "
    "and scale the scan where that is wrong"
)
ADVICE = {
    "compare": "compare model and scan",
    "scan": "check what the scan shows",
}
PER_UNIT = {"percent": 100.0, "mm": 1e3, "degrees": 180.0 / np.pi}
SHOWN = 2  # reasons in the sentence of a refusal: the strongest


class SignalLimit(SettingsPart):
    """The limit of one signal; `above` states on which side of it it counts against the fit."""

    above: bool
    limit: float
    unit: Literal["percent", "mm", "degrees"]  # of the sentence; the value is a share, m or rad
    fact: str  # a sentence without its end; {value} is the signal
    advice: Literal["compare", "scan", "landmarks"]  # what to do about it
    distance: str = ""  # what it is a distance of; of signals of one distance only the strongest is a reason
    scan_alone: bool = False  # of a part of a torso: says nothing where landmarks placed the fit


class LineLimits(SettingsPart):
    """Limits (m) of line errors on the breasts."""

    check: float  # farther off landmarks would help
    placed: float  # likewise where they have placed the fit
    unknown: float  # and beyond no place is known


class VerdictLimits(SettingsPart):
    """The limits of one model."""

    stances: tuple[str, ...]  # of the bodies that they were chosen on
    lines: LineLimits
    size: SizeLimits | None = None  # absent: nobody knows how large bodies are
    unusable_at: Annotated[int, Field(ge=1)]
    refused_at: Annotated[int, Field(ge=2)]
    signals: dict[str, SignalLimit]
    of_stance: dict[str, dict[str, float]] = Field(default={})  # by stance and signal, where they differ

    def in_stance(self, stance: str) -> "VerdictLimits":
        """The limits in this stance."""
        others = self.of_stance.get(stance, {})
        changed = {name: self.signals[name].model_copy(update={"limit": limit}) for name, limit in others.items()}
        return self.model_copy(update={"signals": self.signals | changed})


@dataclass(frozen=True)
class Verdict:
    """The judgement of a fit, with its reasons."""

    level: Level
    reasons: tuple[str, ...]  # sentences, the strongest first; of a good one notes alone
    is_torso: bool = True  # False: certainly none

    @property
    def about(self) -> tuple[About, ...]:
        """What each reason is about, for programs that do more than show it."""
        return tuple(
            "lines" if reason.startswith(FAR_LINES) else "size" if reason.startswith(SIZES) else ""
            for reason in self.reasons
        )

    def refusal(self, name: str, given: GivenLandmarks, *, unusual_size: bool = False) -> str:
        """One sentence, for what is certainly not what the rig of this name shows; its unit may be wrong."""
        facts = [reason.partition(";")[0].rstrip(".") for reason in self.reasons[:SHOWN]]
        inner = ", and ".join(fact[:1].lower() + fact[1:] for fact in facts)
        checked = ["scan", *(["unit"] if unusual_size else []), *(["landmarks"] if given.picked else [])]
        words = " and ".join(filter(None, (", ".join(checked[:-1]), checked[-1])))
        landmarks = ", or place landmarks if it is one" if given.left and not given.picked else ""
        return f"This does not look like a {name.replace('_', ' ')}: {inner}; check {words}{landmarks}."


@lru_cache(maxsize=8)
def verdict_limits(rig: Rig) -> VerdictLimits | None:
    """This rig's limits; None when it has none."""
    return known_part(rig, "verdict.toml", VerdictLimits)


def verdict(
    signals: FitSignals,
    status: Status,
    limits: VerdictLimits | None,
    given: GivenLandmarks,
    asked: Sequence[Reason] = (),
    line_error: float | None = None,
    stance: str = STANDING,
    near: FitSignals | None = None,
) -> Verdict:
    """`status` is why the fit stopped; `line_error` (m) says what the fit is good for.

    `near`: the signals of what plans are made on; without these no fit is unusable, and what speaks against it
    elsewhere is said to be far from there.

    Whoever places landmarks has seen a torso: what would refuse a fit makes it unusable, or is to be checked where
    enough landmarks vouch for it; less is a note, for it tells wrong lines no better than `line_error` does.
    """
    placed, agreed = given.on_their_own, of_agreed(given)
    converged = status is Status.CONVERGED
    stopped = () if converged else (Reason(NOT_CONVERGED, (LOOK_CLOSELY, given.advice)),)
    broken = () if converged else (Reason(NOT_CONVERGED),)
    nothing = not np.isfinite(signals.distance_p95) or not np.isfinite(signals.explained)
    if limits is None and nothing:
        return Verdict("unusable", sentences((NO_SKIN, *broken, *asked)))
    if limits is None:
        level: Level = "check" if stopped or not all(each.note for each in asked) else "uncalibrated"
        return Verdict(level, sentences((*stopped, *asked, UNKNOWN_MODEL, *agreed)))
    limits = limits.in_stance(stance)
    everywhere = _against(signals, limits, given)
    strengths = everywhere if near is None else _against(near, limits, given)
    impossible, in_all = (sum(not limits.signals[name].scan_alone for name in each) for each in (strengths, everywhere))
    far_off = {name: strength for name, strength in everywhere.items() if name not in strengths}
    elsewhere = [replace(each, fact=FAR + each.fact) for each in _reasons(signals, far_off, limits, given)[:1]]
    found = (*_reasons(near or signals, strengths, limits, given), *elsewhere)
    unknown = line_error is not None and line_error > limits.lines.unknown
    refused = impossible >= limits.unusable_at and in_all >= limits.refused_at and not given.placed
    if nothing or refused:
        return Verdict("unusable", sentences((*((NO_SKIN,) if nothing else ()), *found)), False)
    if unknown or (impossible >= (limits.refused_at if placed else limits.unusable_at) and not given.vouch):
        nowhere = (Reason(UNKNOWN_LINES, (given.advice,)),) if unknown else ()
        return Verdict("unusable", sentences((*nowhere, *agreed, *found, *broken, *asked)))
    far = line_error is not None and line_error > (limits.lines.placed if placed else limits.lines.check)
    lines = (Reason(FAR_LINES, (given.advice, WITH_MARGIN)),) if far else ()
    unlike = () if stance in limits.stances else (Reason(OTHER_STANCE.format(stance), (LOOK_CLOSELY,)),)
    notes = tuple(replace(each, note=placed and impossible < limits.refused_at) for each in found)
    reasons = sorted((*lines, *agreed, *notes, *stopped, *asked, *unlike), key=lambda each: each.note)
    return Verdict("good" if all(each.note for each in reasons) else "check", sentences(reasons))


def unusual_size(
    limits: VerdictLimits | None, rig: Rig, vertices: Array, target: ScanTarget, stance: str
) -> tuple[Reason, ...]:
    """A reason where the (V, 3) m fitted body is larger or smaller than nearly all women; else empty."""
    if limits is None or limits.size is None:
        return ()
    found = times_larger(rig, vertices, target, stance, limits.size)
    if found is None or abs(found[1]) < limits.size.asked:
        return ()
    size, words = found[0] - 1.0, ("larger", "tall") if found[0] > 1.0 else ("smaller", "small")
    measure = _to_measure(limits.size, rig, vertices)
    return (Reason(SIZE.format(100.0 * abs(size), *words), (measure,), note=abs(found[1]) < limits.size.unlikely),)


def unknown_size(limits: VerdictLimits | None, rig: Rig, vertices: Array, deviation: float) -> Reason:
    """A note for a size of this standard deviation, a share, with the length to measure."""
    known = None if limits is None else limits.size
    is_there = known is not None and {*known.lengths[0].ends} <= {*rig.landmark_names}
    advice = _to_measure(known, rig, vertices) if known is not None and is_there else MEASURE_ANY
    return Reason(UNKNOWN.format(100.0 * HOLDS_90 * deviation), (advice,), note=True)


def _to_measure(limits: SizeLimits, rig: Rig, vertices: Array) -> str:
    ends = limits.lengths[0].ends
    first, last = rig.landmark_points(ends).positions(vertices, rig.faces)
    labels = [next(each.label for each in rig.landmarks if each.name == end) for end in ends]
    return MEASURE.format(*labels, 100.0 * float(np.linalg.norm(last - first)))


def _against(signals: FitSignals, limits: VerdictLimits, given: GivenLandmarks) -> dict[str, float]:
    """The signals that speak against this fit, and how many times beyond their limits they are."""
    values = vars(signals)
    found = {
        name: _times_beyond(values[name], limit)
        for name, limit in limits.signals.items()
        if np.isfinite(values[name]) and not (given.on_their_own and limit.scan_alone)
    }
    return {name: times for name, times in found.items() if times > 1.0}


def _reasons(
    signals: FitSignals, against: dict[str, float], limits: VerdictLimits, given: GivenLandmarks
) -> tuple[Reason, ...]:
    """The reasons of the signals against the fit, the strongest first."""
    values, distances, found = vars(signals), set[str](), []
    for name in sorted(against, key=against.__getitem__, reverse=True):
        limit = limits.signals[name]
        if limit.distance not in distances:
            advice = given.advice if limit.advice == "landmarks" else ADVICE[limit.advice]
            found.append(Reason(limit.fact.format(value=PER_UNIT[limit.unit] * values[name]), (advice,)))
        distances |= {limit.distance} - {""}
    return tuple(found)


def _times_beyond(value: float, limit: SignalLimit) -> float:
    """More than 1 where it speaks against the fit."""
    return value / limit.limit if limit.above else limit.limit / max(value, np.finfo(float).tiny)


def shows_a_part(signals: FitSignals, limits: VerdictLimits | None) -> bool:
    """Whether the scan shows so little that it matters who placed the fit."""
    return limits is not None and any(
        limit.scan_alone and _times_beyond(vars(signals)[name], limit) > 1.0 for name, limit in limits.signals.items()
    )


UNCLEAR_STANCE = Reason("The scan does not show clearly whether the patient stands or lies", ("say which it is",))
CONTRADICTED = Reason(
    "The body looks turned another way round than the file says", ("check left, head and front in the file",)
)


@dataclass(frozen=True, eq=False)
class Judged:
    """The judgement of a fit."""

    verdict: Verdict
    refusal: str  # one sentence, where it is no torso
    compared: Comparison
    radii: Radii | None


def judge(
    posterior: Posterior,
    status: Status,
    given: GivenLandmarks,
    doubts: Sequence[PickIssue] = (),
    clearness: float | None = None,
    *,
    lesions: Sequence[BallInside] = (),
    unclear_stance: bool = False,
    contradicted: bool = False,
    size_known: bool | None = None,
    repeats: Callable[[], bool] = lambda: False,
) -> Judged:
    """`clearness`: Start.margin; `repeats`: whether the landmarks are proposals that a person has only agreed to.

    `lesions`: that the scan shows inside; `contradicted`: whether scan or landmarks show the body another way round
    than its file says.  Where that is so, or a lesion lies outside, no place of the fit is known.
    `size_known`: True where a length of the patient has given the scan its size, which is no question then; False where
    nobody knows it, which widens all radii; None where it is that of the file.
    The stance is a question only where no landmarks place the fit: they are what moves the breasts.
    """
    rig, task, vertices = posterior.task.rig, posterior.task, posterior.state.vertices
    compared = Comparison(task.target, vertices, rig.faces)
    posed, near = (in_stance(rig, task.stance), posterior.state.x, compared, clearness), near_breasts(rig)
    signals, signals_near = fit_signals(*posed), fit_signals(*posed, near)
    found = verdict_limits(rig)
    limits = None if found is None else found.in_stance(task.stance)
    given = replace(given, left=_to_be_placed(posterior))
    if given.placed and shows_a_part(signals, limits):
        given = replace(given, repeated=repeats())
    inside, outside = of_lesions(rig, vertices, lesions)
    deviation = unscaled().deviation if size_known is False else 0.0
    known = radii(posterior, -np.inf if contradicted or outside else clearness, size_deviation=deviation)
    corners = rig.faces[rig.landmark_points().faces]
    far = {name for name, at in zip(rig.landmark_names, corners, strict=True) if not near[at].any()}
    stance = (UNCLEAR_STANCE,) if unclear_stance and not given.on_their_own else ()
    unusual = () if size_known else unusual_size(limits, rig, vertices, task.target, task.stance)
    size = (unknown_size(limits, rig, vertices, deviation),) if size_known is False and not unusual else unusual
    turned = (CONTRADICTED,) if contradicted else ()
    asked = (*turned, *inside, *of_doubts(doubts, far), *stance, *size)
    lines = None if known is None else known.lines
    said = verdict(signals, status, limits, given, asked, lines, task.stance, signals_near)
    refusal = "" if said.is_torso else said.refusal(rig.name, given, unusual_size=bool(unusual))
    return Judged(said, refusal, compared, known)


def _to_be_placed(posterior: Posterior) -> int:
    """The number of landmarks that the scan shows and nobody has picked."""
    rig, picked = posterior.task.rig, posterior.task.picked
    left = tuple(name for name in rig.landmark_names if name not in picked)
    if not left:
        return 0
    return int(seen_vertices(posterior)[rig.faces[rig.landmark_points(left).faces]].any(axis=1).sum())

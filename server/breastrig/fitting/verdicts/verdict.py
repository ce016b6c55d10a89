"""Is this a torso, and does the model lie on it rightly?  A level and its reasons, from a fit's signals.

Each signal has two limits, kept as data with their reasons: beyond the first a fit is to be looked at, beyond the
second no right fit was ever found.  Each signal has its errors, so one alone never refuses a scan: what several of them
say together is certain, what one says makes the fit unusable at most.
"""

import tomllib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from importlib import resources
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from breastrig.fitting.doubt import Doubt
from breastrig.fitting.verdicts.fit_signals import HANGS, FitSignals
from breastrig.least_squares.newton import Status

Level = Literal["good", "check", "unusable"]
UNKNOWN_MODEL = "Nothing is known of what right fits of this model look like; judge it by eye."
NOT_CONVERGED = "The fit did not come to rest; look at it closely, or place more landmarks."
IN_DOUBT = "One landmark is in doubt; look at what is asked about it."
LOOK_AT_IT = "; look at what is asked about them."
SEVERAL_IN_DOUBT = " are in doubt; look at what is asked about them."
FAR_LINES = "Lines on the breasts may be {:.0f} mm off; place landmarks by hand, or plan with that margin."
UNKNOWN_LINES = "Where lines on the breasts lie is not known; place at least three landmarks by hand."
ONE_AGREED = "One landmark was only agreed to where it was proposed; it keeps the proposal's error."
SEVERAL_AGREED = " were only agreed to where they were proposed; they keep the proposals' errors."
PER_UNIT = {"percent": 100.0, "mm": 1e3, "degrees": 180.0 / np.pi}
SHOWN = 2  # reasons in the sentence of a refusal: the strongest


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class SignalLimits(_Part):
    """Of one signal; `above` says on which side of the limits it speaks against the fit."""

    above: bool
    check: float
    no_torso: float
    unit: Literal["percent", "mm", "degrees"]  # of the sentence; the value is a share, m or rad
    reason: str  # a sentence; {value} is the signal
    hanging: float | None = None  # the first limit where breasts hang; absent: the same
    scan_alone: bool = False  # says nothing where landmarks placed the fit


class LineLimits(_Part):
    """m, of how far off nine of ten places of a line on the breasts may be."""

    check: float  # farther off a plan needs a look
    unknown: float  # and beyond no place is known


class VerdictLimits(_Part):
    """Of one model."""

    lines: LineLimits
    unusable_at: Annotated[int, Field(ge=1)]
    refused_at: Annotated[int, Field(ge=2)]
    signals: dict[str, SignalLimits]


@dataclass(frozen=True)
class Verdict:
    """What is to be thought of a fit."""

    level: Level
    reasons: tuple[str, ...]  # sentences, the strongest first; none when it is good
    is_torso: bool = True  # False: certainly none

    @property
    def refusal(self) -> str:
        """One sentence, for what is no torso."""
        reasons = [reason.split(";")[0].rstrip(".") for reason in self.reasons[:SHOWN]]
        inner = ", and ".join(reason[:1].lower() + reason[1:] for reason in reasons)
        return f"This does not look like a torso: {inner}; check scan and unit, or place landmarks if it is one."


@lru_cache(maxsize=8)
def verdict_limits(model: str) -> VerdictLimits | None:
    """For a model of this name; None when nobody has found any."""
    file = resources.files("breastrig.fitting") / "verdicts" / "torso.toml"
    if model != "torso":
        return None
    return VerdictLimits.model_validate(tomllib.loads(file.read_text("utf-8")))


def verdict(
    signals: FitSignals,
    status: Status,
    limits: VerdictLimits | None,
    placed: bool = False,
    doubts: Sequence[Doubt] = (),
    repeated: bool = False,
    line_error: float | None = None,
    agreed: int = 0,
) -> Verdict:
    """`status` is why the fit stopped, `placed` whether a person's landmarks placed it, `doubts` what is asked about.

    Who names landmarks has seen a torso: such a fit is unusable at most.  `repeated` says that these landmarks only
    repeat what was proposed (repeated.py), so that the scan alone has placed it.  `line_error` (m) decides what the fit
    is good for (uncertainty/radii.py); `agreed` landmarks were proposed and only agreed to.
    """
    stopped = (*(() if status is Status.CONVERGED else (NOT_CONVERGED,)), *_doubt_reasons(doubts))
    if limits is None:
        return Verdict("check", (*stopped, UNKNOWN_MODEL))
    found = {
        name: _strength(asdict(signals)[name], limit, signals.hanging > HANGS)
        for name, limit in limits.signals.items()
        if np.isfinite(asdict(signals)[name]) and not (placed and not repeated and limit.scan_alone)
    }
    order = sorted((name for name, strength in found.items() if strength > 0.0), key=found.__getitem__, reverse=True)
    reasons = tuple(_reason(asdict(signals)[name], limits.signals[name]) for name in order)
    impossible = sum(strength >= 1.0 for strength in found.values())
    nothing = not np.isfinite(signals.distance_p95) or not np.isfinite(signals.scan_p95)
    if nothing:
        reasons = ("The model found no skin that faces as it does; check the scan.", *reasons)
    refused = nothing or (impossible >= limits.refused_at and not placed)
    lines = _line_reasons(line_error, agreed, limits.lines)
    if refused or impossible >= limits.unusable_at:
        return Verdict("unusable", (*reasons, *lines, *stopped), is_torso=not refused)
    if line_error is not None and line_error > limits.lines.unknown:
        return Verdict("unusable", (*lines, *reasons, *stopped))
    if not (lines or reasons or stopped):
        return Verdict("good", ())
    return Verdict("check", (*(lines or _agreed_reason(agreed)), *reasons, *stopped))


def _line_reasons(error: float | None, agreed: int, limits: LineLimits) -> tuple[str, ...]:
    """How far off a line may be, where that is too far for a plan, and why."""
    if error is None or error <= limits.check:
        return ()
    return ((UNKNOWN_LINES if error > limits.unknown else FAR_LINES.format(1e3 * error)), *_agreed_reason(agreed))


def _agreed_reason(agreed: int) -> tuple[str, ...]:
    if not agreed:
        return ()
    return (ONE_AGREED if agreed == 1 else f"{agreed} landmarks{SEVERAL_AGREED}",)


def _doubt_reasons(doubts: Sequence[Doubt]) -> tuple[str, ...]:
    """Exchanged sides first, by their name: what is drawn would be meant for the other breast."""
    exchanged = [doubt for doubt in doubts if doubt.exchanged]
    reasons = [doubt.reason.partition(";")[0] + LOOK_AT_IT for doubt in exchanged]
    others = sum(len(doubt.names) for doubt in doubts if not doubt.exchanged)
    if others:
        reasons.append(IN_DOUBT if others == 1 else f"{others} landmarks{SEVERAL_IN_DOUBT}")
    return tuple(reasons)


def _strength(value: float, limit: SignalLimits, hangs: bool) -> float:
    """0 up to the first limit, 1 at the second, more beyond."""
    check = limit.hanging if hangs and limit.hanging is not None else limit.check
    return float(max((value - check) / (limit.no_torso - check), 0.0))


def _reason(value: float, limit: SignalLimits) -> str:
    return limit.reason.format(value=PER_UNIT[limit.unit] * value)


def shows_a_part(signals: FitSignals, limits: VerdictLimits | None) -> bool:
    """Whether the scan shows so little that it matters who placed the fit."""
    return limits is not None and any(
        limit.scan_alone and _strength(asdict(signals)[name], limit, hangs=False) > 0.0
        for name, limit in limits.signals.items()
    )

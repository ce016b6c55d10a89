"""Is this a torso, and does the model lie on it rightly?  A level and its reasons, from a fit's signals.

Each signal has two limits, kept as data with their reasons beside the rig: beyond the first a fit is to be looked at,
beyond the second no right fit was ever found.  Each signal has its errors, so one alone never refuses a scan: what
several of them say together is certain, what one says makes the fit unusable at most.  Of a rig without limits a fit is
uncalibrated: neither good nor bad, unless something speaks against it without them.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from breastrig.fitting.doubt import Doubt
from breastrig.fitting.verdicts.fit_signals import HANGS, FitSignals
from breastrig.least_squares.newton import Status
from breastrig.rig.known import NOT_CALIBRATED, known_part
from breastrig.rig.model import Rig

Level = Literal["good", "uncalibrated", "check", "unusable"]
UNKNOWN_MODEL = f"{NOT_CALIBRATED}: nobody has measured what its right fits look like; judge this one by eye."
NOTHING = "The model found no skin that faces as it does; check the scan."
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

    def refusal(self, name: str) -> str:
        """One sentence, for what is certainly not what the rig of this name shows."""
        reasons = [reason.split(";")[0].rstrip(".") for reason in self.reasons[:SHOWN]]
        inner = ", and ".join(reason[:1].lower() + reason[1:] for reason in reasons)
        body = name.replace("_", " ")
        return f"This does not look like a {body}: {inner}; check scan and unit, or place landmarks if it is one."


@lru_cache(maxsize=8)
def verdict_limits(rig: Rig) -> VerdictLimits | None:
    """Of this rig; None when nobody has found any."""
    return known_part(rig, "verdict.toml", VerdictLimits)


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
    nothing = not np.isfinite(signals.distance_p95) or not np.isfinite(signals.scan_p95)
    if limits is None and nothing:
        return Verdict("unusable", (NOTHING, *stopped))
    if limits is None:
        return Verdict("check" if stopped else "uncalibrated", (*stopped, UNKNOWN_MODEL))
    found = {
        name: _strength(asdict(signals)[name], limit, signals.hanging > HANGS)
        for name, limit in limits.signals.items()
        if np.isfinite(asdict(signals)[name]) and not (placed and not repeated and limit.scan_alone)
    }
    order = sorted((name for name, strength in found.items() if strength > 0.0), key=found.__getitem__, reverse=True)
    reasons = tuple(_reason(asdict(signals)[name], limits.signals[name]) for name in order)
    impossible = sum(strength >= 1.0 for strength in found.values())
    if nothing:
        reasons = (NOTHING, *reasons)
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

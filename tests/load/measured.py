"""What a run found: how long each kind of call took, and what went wrong."""

from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter

from load.slow import Kept


@dataclass
class Measured:
    seconds: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))  # by kind of call
    late_s: list[float] = field(default_factory=list)  # from the stored event to the viewer who has it
    errors: list[str] = field(default_factory=list)
    fits: int = 0
    streams_read: int = 0  # followed by viewers from the first event to the last
    open_streams: list[int] = field(default_factory=list)  # looked at now and then

    @contextmanager
    def call(self, kind: str) -> Iterator[None]:
        began = perf_counter()
        yield
        self.seconds[kind].append(perf_counter() - began)


def percentile(values: list[float], percent: float) -> float:
    """The nearest rank; nan for no value."""
    if not values:
        return float("nan")
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, round(percent / 100 * (len(ordered) - 1)))]


def table(measured: Measured, seconds: float) -> list[str]:
    """Lines for people; milliseconds."""
    lines = [f"{'call':<28}{'count':>8}{'median ms':>12}{'95 % ms':>12}{'longest ms':>12}"]
    rows = {**measured.seconds, "event: stored to received": measured.late_s}
    for kind, values in rows.items():
        numbers = "".join(f"{1000 * percentile(values, p):>12.0f}" for p in (50, 95, 100))
        lines.append(f"{kind:<28}{len(values):>8}{numbers}")
    streams = sum(measured.open_streams) / max(1, len(measured.open_streams))
    lines += [
        "",
        f"fits        {measured.fits} in {seconds:.0f} s: {measured.fits / seconds:.2f} fits/s",
        f"viewers     {measured.streams_read} whole streams, on average {streams:.0f} streams open",
        f"errors      {len(measured.errors)}",
        *(f"            {error}" for error in measured.errors[:10]),
    ]
    return lines


def slow_table(kinds: dict[str, Kept]) -> list[str]:
    """What became of those who were idle or slow."""
    lines = [f"{'beside them':<28}{'wanted':>8}{'held':>12}{'sent away':>12}{'not let in':>12}"]
    for kind, kept in kinds.items():
        lines.append(f"{kind:<28}{kept.wanted:>8}{kept.held:>12}{kept.sent_away:>12}{kept.not_let_in:>12}")
    return lines

"""Viewers: each follows one fit after the other to its end, over a plain socket, so that fifty cost little here.

Nobody watches the same fit twice: a fit that has ended is replayed as fast as one asks, and fifty who ask again and
again measure how many replays fit into what time is left, not how the service bears viewers.
"""

import asyncio
import random
import re
from dataclasses import dataclass, field
from time import perf_counter

from load.measured import Measured


@dataclass(eq=False)
class OpenFit:
    """A fit that may be watched; whoever made it waits with its deletion until nobody does."""

    id: str
    ended: bool = False
    viewers: int = 0


@dataclass
class Stage:
    """What clients and viewers share."""

    port: int
    measured: Measured
    over: asyncio.Event
    fits: list[OpenFit] = field(default_factory=list)
    received: list[tuple[str, int, float, float]] = field(default_factory=list)  # fit, number, when, when it was opened
    streams: int = 0

    def choose(self, chance: random.Random, seen: set[str]) -> OpenFit | None:
        """One that is under way and none of the seen."""
        running = [fit for fit in self.fits if not fit.ended and fit.id not in seen]
        return chance.choice(running) if running else None


async def view(stage: Stage, seed: int) -> None:
    """Follows fits until the run is over."""
    chance, seen = random.Random(seed), set[str]()
    while not stage.over.is_set():
        fit = stage.choose(chance, seen)
        if fit is None:
            await asyncio.sleep(0.02)
            continue
        fit.viewers += 1
        try:
            await _follow(stage, fit)
            seen.add(fit.id)
        except (OSError, AssertionError, asyncio.IncompleteReadError) as error:
            stage.measured.errors.append(f"viewer: {error!r}"[:300])
            await asyncio.sleep(0.1)
        finally:
            fit.viewers -= 1


async def _follow(stage: Stage, fit: OpenFit) -> None:
    began = perf_counter()
    reader, writer = await asyncio.open_connection("127.0.0.1", stage.port)
    stage.streams += 1
    try:
        writer.write(f"GET /api/fits/{fit.id}/events HTTP/1.0\r\nHost: localhost\r\n\r\n".encode())
        head = (await reader.readuntil(b"\r\n\r\n")).decode()
        status = int(head.split(" ", 2)[1])
        assert status == 200, f"status {status} for a stream"
        opened = perf_counter()
        stage.measured.seconds["GET events (until it opens)"].append(opened - began)
        numbers, kind = [], ""
        async for line in reader:
            if found := re.match(rb"id: (\d+)", line):
                numbers.append(int(found[1]))
                stage.received.append((fit.id, numbers[-1], perf_counter(), opened))
            elif line.startswith(b"event: "):
                kind = line[7:].strip().decode()
        assert kind == "done", f"a stream ended with {kind or 'nothing'}"
        assert numbers == list(range(1, len(numbers) + 1)), f"a stream has gaps: {numbers}"
        stage.measured.streams_read += 1
    finally:
        stage.streams -= 1
        writer.close()

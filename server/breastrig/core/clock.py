"""Seconds of the parts of a task."""

import time


class Clock:
    """Begins with the task; `seconds` has what each part has taken so far, in the order of their beginnings."""

    def __init__(self) -> None:
        self._began = self._last = time.perf_counter()
        self.seconds: dict[str, float] = {}

    def lap(self, part: str | None = None) -> None:
        """Counts the time since the last call for this part; for none where nothing is named."""
        now = time.perf_counter()
        if part is not None:
            self.seconds[part] = self.seconds.get(part, 0.0) + now - self._last
        self._last = now

    def total(self) -> None:
        """Adds `total`: the time since the beginning."""
        self.seconds["total"] = time.perf_counter() - self._began

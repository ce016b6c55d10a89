"""The time of day, and a monotonic time: deletion by age requires both."""

import time
from datetime import UTC, datetime


def now() -> datetime:
    """The machine's time in UTC. It may be wrong, and it may jump."""
    return datetime.now(UTC)


def uptime_s() -> float:
    """Seconds since any moment in the past; goes on while the machine sleeps, where the system counts that."""
    return time.clock_gettime(getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC))

"""Rate limits for one address on calls that can be abused: guessing a token, opening a share, filling the disk.

Counted in this process's memory, because one process serves a data folder; a restart begins the minute anew. A house
may have one address for all; the numbers leave room for that.
"""

import math
import time

from flask import request
from limits import RateLimitItem, RateLimitItemPerMinute
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

from breastrig.api.errors import refuse
from breastrig.api.trusted_proxy import client_of

PER_MINUTE: dict[str, RateLimitItem] = {
    "sign-in": RateLimitItemPerMinute(20),  # wrong tokens: a person mistypes a few times
    "sign-in tried": RateLimitItemPerMinute(600),  # all tries: a hospital at the start of a shift needs fewer
    "share": RateLimitItemPerMinute(60),  # a ward round opens some
    "bearer": RateLimitItemPerMinute(30),  # wrong ones: a script with an old token should notice soon
    "bearer of anybody": RateLimitItemPerMinute(600),  # the same from all addresses together
    "upload": RateLimitItemPerMinute(600),  # a script with small scans; a person needs one
}


class RateLimits:
    """Counts of requests in a sliding minute for each purpose and address."""

    def __init__(self) -> None:
        self._limiter = MovingWindowRateLimiter(MemoryStorage())

    def wait_s(self, purpose: str, whose: str | None = None) -> int:
        """Counts this request; 0 when it may go on, else the seconds until the next may.

        Counted by address, or by `whose`: what is being opened, whoever tries.
        """
        limit, who = PER_MINUTE[purpose], whose or client_of(request.remote_addr)
        if self._limiter.hit(limit, purpose, who):
            return 0
        reset = self._limiter.get_window_stats(limit, purpose, who).reset_time
        return max(1, math.ceil(reset - time.time()))

    def check(self, purpose: str, whose: str | None = None) -> None:
        """Counts this request; raises the 429 when it is one too many."""
        seconds = self.wait_s(purpose, whose)
        if seconds:
            raise refuse(
                429, f"Too many requests of this kind; try again in {seconds} s.", {"Retry-After": str(seconds)}
            )

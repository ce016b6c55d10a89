"""Delays of an address between wrong passcodes of one link: none at first, then twice as long each time.

Others are not kept waiting: the delay belongs to the pair of link and address. It is kept in this process's memory
only, because an address says something about a person; the number of wrong passcodes in all is in the link's row.
"""

import math
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

from breastrig.api.share_limits import ADDRESSES, FREE_GUESSES, LONGEST_DELAY_S

FORGET_S = 3600.0  # after the last guess


@dataclass
class _Guesses:
    wrong: int = 0
    next_at: float = 0.0  # of the clock
    last_at: float = 0.0


class PasscodeDelays:
    """The addresses that guess.  May be called from any thread; `clock` gives seconds."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._known: OrderedDict[tuple[str, str], _Guesses] = OrderedDict()  # the one that guessed last comes last

    def begin(self, share_id: str, address: str) -> int:
        """0 when the passcode may be checked now, else the whole seconds until then.

        Counts the guess as wrong until `was_right` is called, so that guesses sent at once are counted too.
        """
        with self._lock:
            now = self._clock()
            guesses = self._known.pop((share_id, address), None)
            if guesses is None or now - guesses.last_at > FORGET_S:
                guesses = _Guesses()
            self._known[share_id, address] = guesses
            while len(self._known) > ADDRESSES:
                self._known.popitem(last=False)
            if now < guesses.next_at:
                return math.ceil(guesses.next_at - now)
            guesses.wrong += 1
            guesses.last_at = now
            over = guesses.wrong - FREE_GUESSES  # from the last free one on the wait is 1 s, 2, 4, ...
            guesses.next_at = now + (0.0 if over < 0 else min(LONGEST_DELAY_S, 2.0 ** min(30, over)))
            return 0

    def was_right(self, share_id: str, address: str) -> None:
        """Resets the address's delay: its last passcode was right."""
        with self._lock:
            self._known.pop((share_id, address), None)

"""A pick that is asked about."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Doubt:
    """Picks that belong together in one question, and why they are asked about, as a sentence."""

    names: tuple[str, ...]
    reason: str
    followed: bool = False  # True: unusual, but followed all the same
    exchanged: bool = False  # left and right of these look exchanged

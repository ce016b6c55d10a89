"""The bar of a fit's steps, where somebody sees it; tqdm takes 0.1 s to load and is left alone elsewhere."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol


class Bar(Protocol):
    """What is done of so many steps."""

    n: int

    def reset(self, total: int) -> None: ...

    def update(self, n: int) -> object: ...

    def set_postfix_str(self, s: str) -> None: ...


class _Unseen:
    """A bar that nobody sees."""

    n = 0

    def reset(self, total: int) -> None:
        """Nothing to show."""

    def update(self, n: int) -> object:
        """Nothing to show."""

    def set_postfix_str(self, s: str) -> None:
        """Nothing to show."""


@contextmanager
def progress_bar(*, shown: bool) -> Iterator[Bar]:
    """A bar on the terminal, removed at its end, or one that is not seen."""
    if not shown:
        yield _Unseen()
        return
    from tqdm import tqdm

    with tqdm(unit="step", leave=False) as bar:
        yield bar

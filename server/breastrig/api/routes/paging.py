"""The address of the next page of a list."""

from breastrig.api.wire.common import PageQuery


def next_page(address: str, before: int | None, query: PageQuery) -> str | None:
    """`before` is where that page begins; None on the last."""
    return None if before is None else f"{address}?before={before}&limit={query.limit}"

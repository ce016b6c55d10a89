"""The address of the next page of a list."""

from collections.abc import Mapping
from urllib.parse import urlencode

from breastrig.api.wire.common import Limited


def next_page(address: str, query: Limited, place: Mapping[str, object] | None) -> str | None:
    """The same list from another place on, as fields of the query; None after the last page."""
    if place is None:
        return None
    return f"{address}?{urlencode({**query.model_dump(exclude_defaults=True), **place})}"

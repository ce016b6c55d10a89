"""Rows page by page, the newest first.  A page is found by the number of the last row before it, so rows may come."""

from typing import Any

from sqlalchemy import ColumnElement, Row, Select

from breastrig.storage.storage import Storage


def newest_first(
    storage: Storage, query: Select[Any], number: ColumnElement[int], limit: int, before: int | None
) -> tuple[list[Row[Any]], int | None]:
    """At most `limit` rows below `before`, by falling `number`; and where the next page goes on (None: nowhere)."""
    query = query.add_columns(number.label("page_number")).order_by(number.desc()).limit(limit + 1)
    if before is not None:
        query = query.where(number < before)
    with storage.database.reading() as connection:
        rows = list(connection.execute(query))
    return rows[:limit], rows[limit - 1].page_number if len(rows) > limit else None

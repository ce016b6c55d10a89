"""Rows page by page, the newest first or by a key.

A page is found by the last row before it, its number and its key, so rows may come and go meanwhile.
"""

from typing import Any

from sqlalchemy import ColumnElement, Row, Select, and_, or_

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


def by_key(
    storage: Storage,
    query: Select[Any],
    key: ColumnElement[str],
    number: ColumnElement[int],
    limit: int,
    last: tuple[str, int] | None,
) -> tuple[list[Row[Any]], tuple[str, int] | None]:
    """At most `limit` rows after the `last` one's key and number, by rising key, of equal ones the newest first.

    And the key and number where the next page goes on (None: nowhere).
    """
    query = query.add_columns(number.label("page_number"), key.label("page_key"))
    query = query.order_by(key, number.desc()).limit(limit + 1)
    if last is not None:
        query = query.where(or_(key > last[0], and_(key == last[0], number < last[1])))
    with storage.database.reading() as connection:
        rows = list(connection.execute(query))
    return rows[:limit], (rows[limit - 1].page_key, rows[limit - 1].page_number) if len(rows) > limit else None

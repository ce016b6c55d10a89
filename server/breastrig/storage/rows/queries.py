"""What the modules of rows share: rows as values, and rows page by page, the newest first or by a key.

A page is found by the last row before it, its number and its key, so rows may come and go meanwhile.
"""

from dataclasses import fields
from typing import Any, TypeVar

from sqlalchemy import ColumnElement, Connection, Row, Select, Table, and_, or_, select

from breastrig.core.errors import NotFound
from breastrig.storage import schema
from breastrig.storage.storage import Storage

Value = TypeVar("Value")


def value_of(kind: type[Value], row: Any) -> Value:
    """The row as a dataclass whose fields are among its columns."""
    return kind(**{field.name: row._mapping[field.name] for field in fields(kind)})  # type: ignore[arg-type]


def is_there(connection: Connection, table: Table, row_id: str) -> bool:
    return connection.execute(select(table.c.id).where(table.c.id == row_id)).first() is not None


def check_scan(connection: Connection, scan_id: str) -> None:
    """Raises NotFound when there is none."""
    if not is_there(connection, schema.scans, scan_id):
        raise no_such_scan()


def no_such_scan() -> NotFound:
    return NotFound("There is no such scan; it may have been deleted.")


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

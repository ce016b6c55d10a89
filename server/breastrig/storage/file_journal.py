"""Which places may hold files without a row: those that are being made, and those that are to be removed.

A place is noted before its folder is made, and struck out in the transaction that adds its row; it is noted again in
the one that deletes the row, and struck out once its files are gone.  So what a killed server leaves behind is known
by name, and nothing else ever needs to be removed.
"""

from collections.abc import Iterable

from sqlalchemy import Connection, delete, func, insert, select, update

from breastrig.storage import schema
from breastrig.storage.storage import Storage

TABLE = schema.file_journal


def note_making(storage: Storage, scan_id: str, places: Iterable[str]) -> None:
    """Before files of a scan are put into places that have no row yet."""
    rows = [{"place": place, "scan": scan_id, "removing": False} for place in places]
    with storage.database.writing(durable=True) as connection:
        connection.execute(insert(TABLE), rows)


def note_removing(connection: Connection, scan_id: str, places: Iterable[str]) -> None:
    """With the deletion of their rows, or when they get none."""
    for place in places:
        strike_out(connection, [place])
        connection.execute(insert(TABLE).values(place=place, scan=scan_id, removing=True))


def strike_out(connection: Connection, places: Iterable[str]) -> None:
    """The places have rows now, or hold nothing any more."""
    for place in places:
        connection.execute(delete(TABLE).where(TABLE.c.place == place))


def to_be_removed(storage: Storage, scan_id: str | None = None) -> dict[str, str]:
    """{place: scan} of all scans, or of one."""
    query = select(TABLE.c.place, TABLE.c.scan).where(TABLE.c.removing)
    if scan_id is not None:
        query = query.where(TABLE.c.scan == scan_id)
    with storage.database.reading() as connection:
        return {row.place: row.scan for row in connection.execute(query)}


def count_to_be_removed(storage: Storage) -> int:
    """Places whose files could not be removed yet."""
    with storage.database.reading() as connection:
        return int(connection.execute(select(func.count()).select_from(TABLE).where(TABLE.c.removing)).scalar_one())


def abandon_making(connection: Connection, scan_id: str | None = None) -> None:
    """What is being made is to be removed: all, when a server starts, or that of a scan which is deleted."""
    chosen = update(TABLE).where(~TABLE.c.removing)
    if scan_id is not None:
        chosen = chosen.where(TABLE.c.scan == scan_id)
    connection.execute(chosen.values(removing=True))

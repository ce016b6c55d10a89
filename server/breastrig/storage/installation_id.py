"""Files and rows that belong together: checked at each start.

A server that is started with the files of one installation and the database of another, by a forgotten option, would
show scans without files and keep files that nobody can delete.  So the database has an id of its own, and the data
folder and the files carry it.
"""

from pathlib import Path

from sqlalchemy import insert, select

from breastrig.core.errors import BadSettings
from breastrig.storage import schema
from breastrig.storage.data_folder import installation_id, write_marker
from breastrig.storage.database import Database
from breastrig.storage.files import MARK, ROOT, Files
from breastrig.storage.folders import new_id


def check_belonging(database: Database, root: Path, files: Files, beside: bool) -> None:
    """Raises BadSettings when data folder or files carry another database's id.

    A data folder or store without an id gets the database's.  A database without one takes that of the data folder if
    it lies `beside` the marker there, unless files are kept of which it knows nothing: then it is not theirs.
    """
    marker = installation_id(root)
    known = database.installation_id()
    if known is None:
        if not beside or not (marker is None or files.is_empty() or _has_scans(database)):
            raise _of_another()
        known = named(database, marker)
    try:
        if marker is None:
            write_marker(root, known)
        elif marker != known:
            raise _of_another()
        mark = files.find(ROOT, MARK)
        if mark is None:
            files.write(ROOT, MARK, known.encode())
            return
    except OSError as error:
        raise BadSettings(f"Nothing can be written to the place for files ({error.strerror}).") from error
    with mark.open() as file:
        if file.read().decode("ascii", "replace") != known:
            raise _of_another()


def named(database: Database, name: str | None = None) -> str:
    """The database's id, given to it now if it has none."""
    known = database.installation_id()
    if known is not None:
        return known
    given = name or new_id()
    with database.writing() as connection:
        connection.execute(insert(schema.installation).values(id=given))
    return given


def _of_another() -> BadSettings:
    return BadSettings(
        "The files belong to another database than this one; name both as they were, or choose an empty place for new "
        "files."
    )


def _has_scans(database: Database) -> bool:
    with database.reading() as connection:
        return connection.execute(select(schema.scans.c.id).limit(1)).first() is not None

"""Files and rows that belong together: checked at each start, because files without a row are removed then.

A server that is started with the files of one installation and the database of another, by a forgotten option,
would otherwise remove everything.  So the database has a name of its own, and the files carry it.
"""

from sqlalchemy import insert, select

from breastrig.core.errors import BadSettings
from breastrig.storage import schema
from breastrig.storage.database import Database
from breastrig.storage.files import Files
from breastrig.storage.folders import new_id

ROOT = ""  # the place of the mark
MARK = "installation"  # its name


def check_belonging(database: Database, files: Files, beside: bool) -> None:
    """Raises BadSettings when the files carry another database's name.

    Files that carry none get this one's, but only if there are none yet, or the database is `beside` them in one data
    folder and so can be no other's.
    """
    name = _name_of(database)
    mark = files.find(ROOT, MARK)
    if mark is None:
        if not beside and not files.is_empty():
            raise _strangers()
        try:
            files.write(ROOT, MARK, name.encode())
        except OSError as error:
            raise BadSettings(f"Nothing can be written to the place for files ({error.strerror}).") from error
        return
    with mark.open() as file:
        if file.read().decode("ascii", "replace") != name:
            raise _strangers()


def _strangers() -> BadSettings:
    return BadSettings(
        "The files belong to another database than this one; name both as they were, or choose an empty place for new "
        "files."
    )


def _name_of(database: Database) -> str:
    """Given to it now, if it has none."""
    with database.reading() as connection:
        known = connection.execute(select(schema.installation.c.id)).scalar_one_or_none()
    if known is not None:
        return str(known)
    name = new_id()
    with database.writing() as connection:
        connection.execute(insert(schema.installation).values(id=name))
    return name

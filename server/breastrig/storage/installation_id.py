"""Files and rows that belong together: checked at each start.

A server that is started with the files of one installation and the database of another, by a copy of one file alone,
would show scans without files and keep files that nobody can delete.  So the database holds the id of the marker.
"""

from pathlib import Path

from sqlalchemy import insert, select

from breastrig.core.errors import BadSettings
from breastrig.storage import schema
from breastrig.storage.data_folder import installation_id, write_marker
from breastrig.storage.database import Database
from breastrig.storage.folders import Folders, new_id


def check_belonging(database: Database, root: Path, files: Folders) -> None:
    """Raises BadSettings when the data folder carries another database's id, OSError for a full disk.

    A data folder without an id gets the database's.  A database without one takes that of the data folder, unless files
    are kept of which it knows nothing: then it is not theirs.
    """
    marker, known = installation_id(root), database.installation_id()
    if known is None:
        if not (marker is None or files.is_empty() or _has_scans(database)):
            raise _of_another()
        known = marker or new_id()
        with database.writing() as connection:
            connection.execute(insert(schema.installation).values(id=known))
    if marker is None:
        write_marker(root, known)
    elif marker != known:
        raise _of_another()


def _of_another() -> BadSettings:
    return BadSettings(
        "The files belong to another database than this one; put back a copy of the whole data folder, or choose an "
        "empty one with --data."
    )


def _has_scans(database: Database) -> bool:
    with database.reading() as connection:
        return connection.execute(select(schema.scans.c.id).limit(1)).first() is not None

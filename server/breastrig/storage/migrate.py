"""Brings a database to the tables of this version, whatever version left it, or an empty one."""

import logging
from importlib.resources import files
from typing import Any

from sqlalchemy import Connection

from breastrig.core.errors import BadSettings

log = logging.getLogger(__name__)


def to_this_version(connection: Connection) -> None:
    """Runs the revisions that the database lacks, in the connection's own transaction.

    Raises BadSettings when a newer version has been at the database, whose tables this one does not know.
    """
    from alembic import command  # takes a moment, and no worker process needs it
    from alembic.migration import MigrationContext

    config = alembic_config(connection)
    found = MigrationContext.configure(connection).get_current_revision()
    if found is not None and found not in known_revisions():
        raise BadSettings(
            "A newer version of BreastRig has used this database; start that version, or choose another place "
            "with --data."
        )
    command.upgrade(config, "head")
    now = MigrationContext.configure(connection).get_current_revision()
    if now != found:
        log.info("the tables were brought from revision %s to %s", found or "none", now)


def known_revisions() -> set[str]:
    """The revisions that this version brings, the first and the last and all between."""
    from alembic.script import ScriptDirectory

    return {script.revision for script in ScriptDirectory.from_config(alembic_config(None)).walk_revisions()}


def alembic_config(connection: Connection | None) -> Any:
    """Alembic's settings, which stand in no file."""
    from alembic.config import Config

    config = Config()
    folder = str(files("breastrig.storage") / "migrations")
    config.set_main_option("script_location", folder.replace("%", "%%"))
    config.attributes["connection"] = connection
    return config

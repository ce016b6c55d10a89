"""Brings a database to the tables of this version, all in one transaction: a new one from `schema`, an older one by
Alembic's revisions (alembic.sqlalchemy.org, cookbook: "Building an Up to Date Database from Scratch").

A database that is up to date is recognised without importing Alembic, which takes a third of a second.
"""

import logging
import sys
from importlib.resources import files
from typing import Any

from sqlalchemy import Connection, inspect, text

from breastrig.core.errors import BadSettings
from breastrig.storage.schema import metadata

log = logging.getLogger(__name__)


def to_this_version(connection: Connection) -> None:
    """Makes the tables, or runs the missing revisions; BadSettings for the tables of another version."""
    found, known = _revision(connection), known_revisions()
    if found == known[-1]:
        return
    if found not in known and (found is not None or inspect(connection).has_table("scans")):
        raise BadSettings(
            "Another version of BreastRig has used this database; start that version, or choose another place "
            "with --data."
        )
    from alembic import command

    if found is None:
        metadata.create_all(connection)
        command.stamp(alembic_config(connection), "head")
    else:
        command.upgrade(alembic_config(connection), "head")
    log.info("the tables were brought from revision %s to %s", found or "none", known[-1])


def known_revisions() -> list[str]:
    """The revisions that this version brings, in order: the numbers in their files' names."""
    names = (file.name for file in (files("breastrig.storage") / "migrations" / "versions").iterdir())
    return sorted(name[1:5] for name in names if name.startswith("r") and name.endswith(".py"))


def alembic_config(connection: Connection) -> Any:
    """Alembic's settings, without a file."""
    from alembic.config import Config

    config = Config(stdout=sys.stdout)  # by default it is that of the moment of import
    folder = str(files("breastrig.storage") / "migrations")
    config.set_main_option("script_location", folder.replace("%", "%%"))
    config.attributes["connection"] = connection
    return config


def _revision(connection: Connection) -> str | None:
    """Of the tables that are there; None without any."""
    if not inspect(connection).has_table("alembic_version"):
        return None
    return connection.execute(text("SELECT version_num FROM alembic_version")).scalar_one_or_none()

"""Tables of other versions: an older database is brought up to date by Alembic's revisions.

A new one is made from `schema`, all in one transaction (alembic.sqlalchemy.org, cookbook: "Building an Up to Date
Database from Scratch").  One that is up to date is seen without importing Alembic, which takes a third of a second.
"""

import logging
import sys
from importlib.resources import files
from typing import Any

from sqlalchemy import Connection, inspect, text

from breastrig.core.errors import BadSettings
from breastrig.core.version import __version__
from breastrig.storage.schema import metadata

FIRST_WITH_REVISION = "0.2.0"  # older ones made tables that do not say of which revision they are

log = logging.getLogger(__name__)


def to_this_version(connection: Connection) -> None:
    """Makes the tables, or runs the missing revisions; BadSettings for the tables of another version."""
    found, known = _revision(connection), known_revisions()
    if found == known[-1]:
        return
    if found not in known and (found is not None or inspect(connection).has_table("scans")):
        raise BadSettings(_of_another_version(found, known[-1]))
    from alembic import command

    if found is None:
        metadata.create_all(connection)
        command.stamp(alembic_config(connection), "head")
    else:
        command.upgrade(alembic_config(connection), "head")
    log.info("the tables were brought from revision %s to %s", found or "none", known[-1])


def _of_another_version(found: str | None, newest: str) -> str:
    here = f"this is BreastRig {__version__}"
    if found is None:
        return (
            f"An older BreastRig, of before {FIRST_WITH_REVISION}, has used this database, and {here}, which takes "
            f"over those of {FIRST_WITH_REVISION} and later; start the older one to save what is in it, or choose "
            "another place with --data."
        )
    return (
        f"A newer BreastRig has used this database (its tables have revision {found}), and {here}, which knows "
        f"revision {newest}; install the newer one again, or choose another place with --data."
    )


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

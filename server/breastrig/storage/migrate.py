"""Brings a database to the tables of this version, whatever version left it, or an empty one.

Alembic takes a third of a second to import: a database that is up to date, as most are, is seen without it, and an
empty one gets the tables of `schema` at once, which are those that all revisions together make.
"""

import logging
import sys
from importlib.resources import files
from typing import Any

from sqlalchemy import Column, Connection, MetaData, PrimaryKeyConstraint, String, Table, inspect, text

from breastrig.core.errors import BadSettings
from breastrig.storage import schema

log = logging.getLogger(__name__)

VERSION = Table(  # as Alembic makes it
    "alembic_version",
    MetaData(),
    Column("version_num", String(32), nullable=False),
    PrimaryKeyConstraint("version_num", name="alembic_version_pkc"),
)


def to_this_version(connection: Connection) -> None:
    """Runs the revisions that the database lacks, in the connection's own transaction.

    Raises BadSettings when a newer version has been at the database, whose tables this one does not know.
    """
    found, known = _revision(connection), known_revisions()
    if found == known[-1]:
        return
    if found is not None and found not in known:
        raise BadSettings(
            "A newer version of BreastRig has used this database; start that version, or choose another place "
            "with --data."
        )
    if found is None and not inspect(connection).get_table_names():
        schema.metadata.create_all(connection)
        VERSION.create(connection)
        connection.execute(VERSION.insert(), {"version_num": known[-1]})
        return
    from alembic import command

    command.upgrade(alembic_config(connection), "head")
    log.info("the tables were brought from revision %s to %s", found or "none", known[-1])


def known_revisions() -> list[str]:
    """The revisions that this version brings, in order: the numbers in their files' names."""
    names = (file.name for file in (files("breastrig.storage") / "migrations" / "versions").iterdir())
    return sorted(name[1:5] for name in names if name.startswith("r") and name.endswith(".py"))


def alembic_config(connection: Connection) -> Any:
    """Alembic's settings, which stand in no file."""
    from alembic.config import Config

    config = Config(stdout=sys.stdout)  # by default it is that of the moment of import
    folder = str(files("breastrig.storage") / "migrations")
    config.set_main_option("script_location", folder.replace("%", "%%"))
    config.attributes["connection"] = connection
    return config


def _revision(connection: Connection) -> str | None:
    """Of the tables that are there; None for those of no revision, or no tables."""
    if not inspect(connection).has_table("alembic_version"):
        return None
    return connection.execute(text("SELECT version_num FROM alembic_version")).scalar_one_or_none()

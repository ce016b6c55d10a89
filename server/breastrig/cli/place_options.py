"""The options that say where scans and fits are kept, which serve, config and purge share."""

import argparse
import os
from collections.abc import Callable

from breastrig.api.settings import SETTINGS, effective_settings, location_of, settings_file
from breastrig.storage.location import Location
from breastrig.storage.storage import default_data_folder

PLACES = ("data", "database", "files")


def add_place_options(parser: argparse.ArgumentParser) -> None:
    shown = str(default_data_folder()).replace(os.path.expanduser("~"), "~", 1)  # as a person would write it
    parser.add_argument(
        "--data", type=checked("data"), metavar="DIR", help=f"where scans and fits are kept (default {shown})"
    )
    parser.add_argument(
        "--database",
        type=checked("database"),
        metavar="URL",
        help="keep rows in PostgreSQL: postgresql://USER@HOST/NAME (better in the settings file if it has a password)",
    )
    parser.add_argument(
        "--files", type=checked("files"), metavar="URL", help="keep files in a store: s3://BUCKET/PREFIX"
    )


def chosen_location(options: argparse.Namespace) -> Location:
    """The places that the service would use: environment and settings file count as well."""
    given = {name: getattr(options, name) for name in PLACES}
    return location_of(effective_settings(given, settings_file(None)))


def checked(name: str) -> Callable[[str], str]:
    """Refuses a wrong value of a setting as a mistake of usage; the text itself goes on."""
    setting = SETTINGS[name]

    def check(text: str) -> str:
        try:
            setting.read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"{setting.quote(text) or 'nothing'} {error}") from error
        return text

    return check

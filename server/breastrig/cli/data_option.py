"""The option --data, which serve, config and purge share."""

import argparse
import os
from pathlib import Path

from breastrig.api.settings import effective_settings, settings_file
from breastrig.storage.storage import default_data_folder


def add_data_option(parser: argparse.ArgumentParser) -> None:
    shown = str(default_data_folder()).replace(os.path.expanduser("~"), "~", 1)  # as a person would write it
    parser.add_argument("--data", type=Path, metavar="DIR", help=f"where scans and fits are kept (default {shown})")


def data_folder(options: argparse.Namespace) -> Path:
    """The folder that the service would use: environment and settings file count as well."""
    folder: Path = effective_settings({"data": options.data}, settings_file(None))["data"].value
    return folder

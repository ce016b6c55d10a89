"""The option --data, which serve and purge share."""

import argparse
import os
from pathlib import Path

from breastrig.storage.storage import default_data_folder


def add_data_option(parser: argparse.ArgumentParser) -> None:
    shown = str(default_data_folder()).replace(os.path.expanduser("~"), "~", 1)  # as a person would write it
    parser.add_argument("--data", type=Path, metavar="DIR", help=f"where scans and fits are kept (default {shown})")


def data_folder(options: argparse.Namespace) -> Path:
    folder: Path = options.data or default_data_folder()
    return folder.expanduser().absolute()

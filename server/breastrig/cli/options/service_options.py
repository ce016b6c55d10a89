"""Options that serve, config and purge share, and the effective settings with environment and settings file."""

import argparse
import os
from collections.abc import Callable, Iterable
from pathlib import Path

from breastrig.api.settings import (
    FILE_VARIABLE,
    SETTINGS,
    ResolvedSetting,
    effective_settings,
    read_yes_or_no,
    settings_file,
)


def add_setting_options(parser: argparse.ArgumentParser, names: Iterable[str]) -> None:
    for name in names:
        setting, option = SETTINGS[name], f"--{name.replace('_', '-')}"
        if setting.read is read_yes_or_no:
            parser.add_argument(option, action="store_const", const="yes", help=setting.help)
        else:
            parser.add_argument(option, type=checked(setting.read), metavar=setting.metavar, help=setting.help)


def chosen_data_folder(options: argparse.Namespace) -> Path:
    """The service's data folder; environment and settings file count as well."""
    folder: Path = effective_settings({"data": options.data}, settings_file(None))["data"].value
    return folder


def checked(read: Callable[[str], object]) -> Callable[[str], str]:
    """An option's type that checks a text: a wrong value is a mistake of usage; the text itself is passed on."""

    def check(text: str) -> str:
        try:
            read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"{text or 'nothing'} {error}") from error
        return text

    return check


def add_service_options(parser: argparse.ArgumentParser) -> None:
    add_setting_options(parser, SETTINGS)
    parser.add_argument("--config", type=Path, metavar="FILE", help=f"settings file, TOML (or {FILE_VARIABLE})")
    parser.epilog = (
        "Each option may also be in the settings file (keep_days = 30), or in the environment (BREASTRIG_KEEP_DAYS=30)."
    )


def service_settings(options: argparse.Namespace) -> dict[str, ResolvedSetting]:
    """The effective settings.  Raises BadSettings."""
    given = {name: getattr(options, name) for name in SETTINGS}
    return effective_settings(given, settings_file(options.config, os.environ), os.environ)

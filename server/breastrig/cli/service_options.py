"""The options that serve and config share, and what they come to with environment and settings file."""

import argparse
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from breastrig.api.config import TOKEN_VARIABLE
from breastrig.api.settings import (
    FILE_VARIABLE,
    LOG_FORMS,
    SETTINGS,
    Found,
    effective_settings,
    read_count,
    read_keep_days,
    read_port,
    settings_file,
)
from breastrig.cli.data_option import add_data_option
from breastrig.jobs.sweep import KEEP_DAYS

PORT = SETTINGS["port"].default()


def add_service_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--host",
        help=f"address to listen on (default 127.0.0.1); any but this machine's own needs {TOKEN_VARIABLE} or "
        "--token-file",
    )
    parser.add_argument("--port", type=_checked(read_port), help=f"port to listen on (default {PORT}; 0: a free one)")
    add_data_option(parser)
    parser.add_argument(
        "--keep-days",
        type=_checked(read_keep_days),
        metavar="DAYS",
        help=f"delete scans so many days after their upload (default {KEEP_DAYS}), or: forever",
    )
    parser.add_argument("--model", metavar="GLB", help="another rig than the package's torso")
    parser.add_argument(
        "--workers", type=_checked(read_count), help="fits that run at once (default: one a core, at most 8)"
    )
    parser.add_argument(
        "--waiting-per-client",
        type=_checked(read_count),
        metavar="N",
        help="fits that one client may have waiting (default 50)",
    )
    parser.add_argument(
        "--log", choices=LOG_FORMS, help="log lines for people or as JSON (auto: JSON unless on a terminal)"
    )
    parser.add_argument("--token-file", metavar="FILE", help=f"file that holds the token, instead of {TOKEN_VARIABLE}")
    parser.add_argument("--config", type=Path, metavar="FILE", help=f"settings file, TOML (or {FILE_VARIABLE})")
    parser.epilog = (
        "Each option may also stand in the settings file (keep_days = 30), or in the environment "
        "(BREASTRIG_KEEP_DAYS=30)."
    )


def service_settings(options: argparse.Namespace) -> dict[str, Found]:
    """The effective settings.  Raises BadSettings."""
    given = {name: getattr(options, name) for name in SETTINGS}
    return effective_settings(given, settings_file(options.config, os.environ), os.environ)


def _checked(read: Callable[[str], Any]) -> Callable[[str], str]:
    """Refuses a wrong value as a mistake of usage; the text itself goes on."""

    def check(text: str) -> str:
        try:
            read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"{text} {error}") from error
        return text

    return check

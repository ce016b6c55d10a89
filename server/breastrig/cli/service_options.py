"""Options that serve, config and purge share, and what they come to with environment and settings file."""

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from breastrig.api.config import TOKEN_VARIABLE
from breastrig.api.settings import (
    FILE_VARIABLE,
    LOG_FORMS,
    LOG_REQUESTS,
    SETTINGS,
    Found,
    effective_settings,
    location_of,
    settings_file,
)
from breastrig.service.sweep import KEEP_DAYS
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


PORT = SETTINGS["port"].default()


def add_service_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--host",
        help=f"address to listen on (default 127.0.0.1); any but this machine's own needs {TOKEN_VARIABLE} or "
        "--token-file",
    )
    parser.add_argument("--port", type=checked("port"), help=f"port to listen on (default {PORT}; 0: a free one)")
    add_place_options(parser)
    parser.add_argument(
        "--scheduler",
        type=checked("scheduler"),
        metavar="ADDRESS",
        help="a Dask scheduler, whose workers run the fits (default: processes of this machine)",
    )
    parser.add_argument(
        "--keep-days",
        type=checked("keep_days"),
        metavar="DAYS",
        help=f"delete scans so many days after their upload (default {KEEP_DAYS}), or: forever",
    )
    parser.add_argument("--model", metavar="GLB", help="another rig than the package's torso")
    parser.add_argument(
        "--workers", type=checked("workers"), help="fits that run at once (default: one a core, at most 8)"
    )
    parser.add_argument(
        "--waiting-per-client",
        type=checked("waiting_per_client"),
        metavar="N",
        help="fits that one client may have waiting (default 50)",
    )
    parser.add_argument(
        "--log", choices=LOG_FORMS, help="log lines for people or as JSON (auto: JSON unless on a terminal)"
    )
    parser.add_argument(
        "--log-requests",
        choices=LOG_REQUESTS,
        help="a log line for each request, without addresses and ids (auto: yes unless on a terminal)",
    )
    parser.add_argument(
        "--trusted-proxy",
        type=checked("trusted_proxy"),
        metavar="ADDRESS[,HOPS]",
        help="the reverse proxy whose X-Forwarded-For, -Proto and -Host are believed, and how many stand in a row",
    )
    parser.add_argument(
        "--public-host",
        type=checked("public_host"),
        metavar="NAME[,NAME]",
        help="the only names that outsiders may call this service by (default: any, as the token protects it)",
    )
    parser.add_argument("--token-file", metavar="FILE", help=f"file that holds the token, instead of {TOKEN_VARIABLE}")
    parser.add_argument(
        "--no-token",
        action="store_const",
        const="yes",
        help="for scripts: any user and program of this machine may read and change all patients (default: a token is "
        "made at each start, and is in the printed address)",
    )
    parser.add_argument(
        "--no-browser", action="store_const", const="yes", help="open no browser when started on a terminal"
    )
    parser.add_argument("--config", type=Path, metavar="FILE", help=f"settings file, TOML (or {FILE_VARIABLE})")
    parser.epilog = (
        "Each option may also be in the settings file (keep_days = 30), or in the environment (BREASTRIG_KEEP_DAYS=30)."
    )


def service_settings(options: argparse.Namespace) -> dict[str, Found]:
    """The effective settings.  Raises BadSettings."""
    given = {name: getattr(options, name) for name in SETTINGS}
    return effective_settings(given, settings_file(options.config, os.environ), os.environ)

"""Every setting of the service, and where its value came from.

An option of the command line wins over the environment, that over the settings file, that over the default.  The
token is no setting of the file: it comes from the environment or from a file of its own, and is never shown.
"""

import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from breastrig.api.config import TOKEN_VARIABLE
from breastrig.api.trusted_proxy import read_trusted_proxy
from breastrig.core.assets import packaged_models
from breastrig.core.errors import BadSettings, unknown_name
from breastrig.core.settings_file import read_toml
from breastrig.execution.limits import FitLimits
from breastrig.service.sweep import KEEP_DAYS
from breastrig.storage.storage import default_data_folder

PREFIX = "BREASTRIG_"
FILE_VARIABLE = "BREASTRIG_CONFIG"
LOG_FORMS = ("auto", "text", "json")
LOG_REQUESTS = ("auto", "yes", "no")
YES_OR_NO = {"yes": True, "true": True, "no": False, "false": False}


@dataclass(frozen=True)
class Setting:
    """One name with its default; `read` turns text into the value or raises ValueError with what it should be."""

    read: Callable[[str], Any]
    help: str  # of the option
    default: Callable[[], Any] = lambda: None
    metavar: str | None = None
    none: str = "none"  # how None is shown
    show: Callable[[Any], str] = str  # other values

    def shown(self, value: Any) -> str:
        return self.none if value is None else self.show(value)


@dataclass(frozen=True)
class ResolvedSetting:
    """A setting's value with its source, and its text for people."""

    value: Any
    source: str  # for people: "default", "option --port", "environment BREASTRIG_PORT", "file NAME"
    shown: str


def whole_number(what: str, low: int, high: int) -> Callable[[str], int]:
    def read(text: str) -> int:
        if not (text.isascii() and text.isdigit() and low <= int(text) <= high):
            raise ValueError(f"is not a {what}; use a number from {low} to {high}")
        return int(text)

    return read


read_count = whole_number("count", 1, 10_000)


def read_days(text: str) -> float:
    """A number of days."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value <= 36500.0:
        raise ValueError("is not a number of days; use 0 to 36500")
    return value


def read_keep_days(text: str) -> float | None:
    if text == "forever":
        return None
    value = read_days(text)
    if value == 0.0:
        raise ValueError("days would delete each scan at once; use a longer time, or forever")
    return value


def read_public_hosts(text: str) -> tuple[str, ...]:
    """Names without port, lower case."""
    names = tuple(name.strip().lower() for name in text.split(","))
    for name in names:
        if not re.fullmatch(r"[a-z0-9_-]+(\.[a-z0-9_-]+)*|[0-9a-f:]*:[0-9a-f:.]*", name):
            raise ValueError("is no name of a host; use a name such as scans.hospital.example, without https and port")
    return names


def one_of(words: Sequence[str], wrong: str) -> Callable[[str], str]:
    def read(text: str) -> str:
        if text not in words:
            raise ValueError(f"{wrong}; use one of {', '.join(words)}")
        return text

    return read


def read_yes_or_no(text: str) -> bool:
    if text.lower() not in YES_OR_NO:
        raise ValueError("is no answer; use yes or no")
    return YES_OR_NO[text.lower()]


def show_yes_or_no(value: bool) -> str:
    return "yes" if value else "no"


def read_model(text: str) -> Path:
    """The name of a packaged model, or a path."""
    return packaged_models().get(text) or read_folder(text)


def read_folder(text: str) -> Path:
    if not text.strip() or "\0" in text:
        raise ValueError("is no place; give a path")
    return Path(text).expanduser().absolute()


def read_scheduler(text: str) -> str:
    if not re.fullmatch(r"[a-z]+://\S+|[^\s:/]+:[0-9]+", text):
        raise ValueError("is no address of a scheduler; use tcp://HOST:8786")
    return text


SHOWN_DATA = str(default_data_folder()).replace(os.path.expanduser("~"), "~", 1)  # as a person would write it
SETTINGS: dict[str, Setting] = {
    "host": Setting(
        str,
        f"address to listen on (default 127.0.0.1); any but this machine's own needs {TOKEN_VARIABLE} or --token-file",
        lambda: "127.0.0.1",
    ),
    "port": Setting(whole_number("port", 0, 65535), "port to listen on (default 8321; 0: a free one)", lambda: 8321),
    "data": Setting(read_folder, f"where scans and fits are kept (default {SHOWN_DATA})", default_data_folder, "DIR"),
    "scheduler": Setting(
        read_scheduler,
        "a Dask scheduler, whose workers run the fits (default: processes of this machine)",
        metavar="ADDRESS",
        none="none: local processes",
    ),
    "keep_days": Setting(
        read_keep_days,
        f"delete scans so many days after their upload (default {KEEP_DAYS}), or: forever",
        lambda: float(KEEP_DAYS),
        "DAYS",
        none="forever",
        show="{:g}".format,
    ),
    "model": Setting(read_model, "another rig than the package's torso", metavar="MODEL", none="the packaged torso"),
    "workers": Setting(
        read_count, "fits that run at once (default: one a core, at most 8)", lambda: FitLimits().workers
    ),
    "waiting_per_client": Setting(
        read_count,
        "fits that one client may have waiting (default 50)",
        lambda: FitLimits().waiting_per_client,
        "N",
    ),
    "log": Setting(
        one_of(LOG_FORMS, "is not a form of log"),
        "log lines for people or as JSON (auto: JSON unless on a terminal)",
        lambda: "auto",
        f"{{{','.join(LOG_FORMS)}}}",
    ),
    "log_requests": Setting(
        one_of(LOG_REQUESTS, "is no answer"),
        "a log line for each request, without addresses and ids (auto: yes unless on a terminal)",
        lambda: "auto",
        f"{{{','.join(LOG_REQUESTS)}}}",
    ),
    "trusted_proxy": Setting(
        read_trusted_proxy,
        "the reverse proxy whose X-Forwarded-For, -Proto and -Host are believed, and how many stand in a row",
        metavar="ADDRESS[,HOPS]",
    ),
    "public_host": Setting(
        read_public_hosts,
        "the only names that outsiders may call this service by (default: any, as the token protects it)",
        lambda: (),
        "NAME[,NAME]",
        show=lambda names: ",".join(names) or "any, where there is a token",
    ),
    "users": Setting(
        read_folder,
        "file that says who may sign in, where, and in which groups (TOML); without it whoever has the token may all",
        metavar="FILE",
    ),
    "archives": Setting(
        read_folder,
        "TOML file of the archives (PACS) that results may be sent to",
        metavar="FILE",
    ),
    "token_file": Setting(read_folder, f"file that holds the token, instead of {TOKEN_VARIABLE}", metavar="FILE"),
    "no_token": Setting(
        read_yes_or_no,
        "for scripts: any user and program of this machine may read and change all patients (default: a token is made "
        "at each start, and is in the printed address)",
        lambda: False,
        show=show_yes_or_no,
    ),
    "no_browser": Setting(
        read_yes_or_no, "open no browser when started on a terminal", lambda: False, show=show_yes_or_no
    ),
}


def settings_file(option: Path | None, environment: Mapping[str, str] = os.environ) -> Path | None:
    """The file that is named, else the user's own when there is one (by the XDG rules)."""
    named = option or (Path(environment[FILE_VARIABLE]) if environment.get(FILE_VARIABLE) else None)
    if named is not None:
        return named.expanduser()
    base = environment.get("XDG_CONFIG_HOME", "")
    usual = (Path(base) if base.startswith("/") else Path.home() / ".config") / "breastrig" / "config.toml"
    return usual if usual.is_file() else None


def effective_settings(
    options: Mapping[str, Any], file: Path | None, environment: Mapping[str, str] = os.environ
) -> dict[str, ResolvedSetting]:
    """Each setting's value.  `options` holds what the command line gave, None for what it did not.

    Raises BadSettings for a file that cannot be read, an unknown name in it, and a value that cannot be used.
    """
    in_file = {} if file is None else _read_file(file)
    found = {}
    for name, setting in SETTINGS.items():
        variable = PREFIX + name.upper()
        if options.get(name) is not None:
            text, source = options[name], f"option --{name.replace('_', '-')}"
        elif environment.get(variable, "").strip():
            text, source = environment[variable].strip(), f"environment {variable}"
        elif name in in_file:
            text, source = str(in_file[name]), f"file {file}"
        else:
            value = setting.default()
            found[name] = ResolvedSetting(value, "default", setting.shown(value))
            continue
        try:
            value = setting.read(str(text))
        except ValueError as error:
            raise BadSettings(f"{name} ({source}): {text or 'nothing'} {error}.") from error
        found[name] = ResolvedSetting(value, source, setting.shown(value))
    return found


def _read_file(file: Path) -> dict[str, Any]:
    document = read_toml(file, "settings", "write lines such as: port = 8321")
    for name in document:
        if name == "token":
            raise BadSettings(f"The token does not belong into {file}; name its own file there with token_file.")
        if name not in SETTINGS:
            raise BadSettings(f"{file}: {unknown_name('setting', name, tuple(SETTINGS))}")
    return document


def token_source(
    found: Mapping[str, ResolvedSetting], environment: Mapping[str, str] = os.environ
) -> tuple[str | None, str]:
    """(the token as it was given, where it came from).  Raises BadSettings when its file cannot be read."""
    file = found["token_file"]
    in_environment = environment.get(TOKEN_VARIABLE, "").strip()
    if in_environment and not file.source.startswith("option"):
        return in_environment, f"environment {TOKEN_VARIABLE}"
    if file.value is None:
        return None, "default"
    try:
        text = file.value.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise BadSettings(f"The token file {file.value} cannot be read; check its name and permissions.") from error
    if not text:
        raise BadSettings(f"The token file {file.value} is empty; write the token into it.")
    return text, f"file {file.value}"

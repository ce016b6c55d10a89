"""`breastrig` without what only Unix has and without the server's packages: python -m helpers.windows_like.

The process also cannot rename or remove a file that it has open, as on Windows.
"""

import importlib.abc
import os
import select
import selectors
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

UNIX = {"fcntl", "pwd", "grp", "resource", "termios", "posix_ipc", "pty", "tty", "crypt", "syslog"}
SERVER = {"flask", "apiflask", "werkzeug", "uvicorn", "h11", "limits", "prometheus_client"}
SERVER |= {"webargs", "apispec", "fastapi", "starlette", "a2wsgi"}
FUNCTIONS = (
    "fork",
    "forkpty",
    "getuid",
    "geteuid",
    "getgid",
    "getegid",
    "setsid",
    "killpg",
    "getpgid",
    "mkfifo",
    "chown",
)
FUNCTIONS += ("sched_getaffinity", "statvfs", "symlink", "O_NONBLOCK", "O_CLOEXEC", "O_DIRECTORY", "O_NOFOLLOW")
SIGNALS = ("SIGUSR1", "SIGUSR2", "SIGKILL", "SIGHUP", "SIGALRM", "SIGCHLD")
KEEPERS = (select, selectors, subprocess, threading)  # of the standard library: loaded as they are here


class Missing(importlib.abc.MetaPathFinder):
    """No such modules."""

    def __init__(self, names: set[str]) -> None:
        self._names = names

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname.partition(".")[0] in self._names:
            raise ModuleNotFoundError(f"No module named {fullname!r}", name=fullname)
        return None


def open_files() -> set[str]:
    found = set()
    for number in os.listdir("/proc/self/fd"):
        try:
            found.add(os.readlink(f"/proc/self/fd/{number}"))
        except OSError:
            continue
    return found


def only_closed(name: str) -> None:
    """The function of `os` refuses a file that this process has open."""
    real = getattr(os, name)

    def checked(*paths: Any, **words: Any) -> Any:
        files = [os.path.realpath(each) for each in paths if isinstance(each, (str, bytes, os.PathLike))]
        if "dir_fd" not in words and set(files) & open_files():
            raise PermissionError(13, "The process cannot access the file because it is being used", files[0])
        return real(*paths, **words)

    setattr(os, name, checked)


def pretend(missing: set[str]) -> None:
    """From now on this process is as poor as that."""
    sys.meta_path.insert(0, Missing(missing))
    for name in missing & set(sys.modules):
        del sys.modules[name]
    if "fcntl" in missing:
        for name in FUNCTIONS:
            delattr(os, name)
        for name in SIGNALS:
            delattr(signal, name)
        for name in ("replace", "rename", "unlink", "remove"):
            only_closed(name)


def white_pictures() -> None:
    """What is shown is a question of other tests."""
    from breastrig.rendering.picture import Scene
    from helpers.plain_report import white

    Scene.render = white


if __name__ == "__main__":
    pretend({"unix": UNIX | SERVER, "server": SERVER}[sys.argv[1]])
    from breastrig.cli.main import main

    for words in " ".join(sys.argv[2:]).split(" -- "):
        if words.startswith(("compare", "report")):
            white_pictures()
        code = main(words.split())
        sys.stdout.write(f"{words.split()[0]}: {code}\n")

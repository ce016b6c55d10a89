"""Caddy with the Caddyfile that we ship, on loopback, in front of a service of the tests' own."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import trustme

from helpers.nginx import certified, free_port, listening


@contextmanager
def caddy_in_front_of(port: int, file: Path, name: str, authority: trustme.CA, folder: Path) -> Iterator[int]:
    """The port of Caddy, which speaks TLS and asks the service at `port`; `folder`: for its own files."""
    own_port, program = free_port(), Path(sys.executable).with_name("caddy")
    certified(name, authority, folder)
    environment = {
        "HOME": str(folder),
        "XDG_CONFIG_HOME": str(folder),
        "XDG_DATA_HOME": str(folder),
        "BREASTRIG_SITE": f"{name}:{own_port}",
        "BREASTRIG_TLS": f"{folder / 'certificate'} {folder / 'key'}",
        "BREASTRIG_UPSTREAM": f"127.0.0.1:{port}",
    }
    command = [str(program), "run", "--config", str(file), "--adapter", "caddyfile"]
    with listening(command, own_port, folder / "caddy.log", **environment):
        yield own_port

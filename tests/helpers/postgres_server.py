"""A PostgreSQL server of the tests' own, on loopback, with an empty database for each who asks.

It refuses to run as root; then it runs as `nobody`.
"""

import os
import secrets
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PLACES = "/usr/lib/postgresql"  # where Debian keeps one folder for each version
NONE_HERE = (
    "These tests need PostgreSQL's server programs: install the package postgresql (apt-get install postgresql, or "
    "sh .ci/postgres.sh), or set BREASTRIG_POSTGRES to the folder that holds initdb."
)


def programs() -> Path:
    """The folder of initdb and postgres; fails with a sentence when there is none."""
    places = [Path(os.environ["BREASTRIG_POSTGRES"])] if os.environ.get("BREASTRIG_POSTGRES") else []
    places += sorted(Path(PLACES).glob("*/bin"), key=lambda place: int(place.parent.name), reverse=True)
    found = shutil.which("initdb")
    places += [Path(found).resolve().parent] if found else []
    for place in places:
        if (place / "initdb").is_file() and (place / "postgres").is_file():
            return place
    raise AssertionError(NONE_HERE)


class PostgresServer:
    """`new_database()` gives the URL of an empty database."""

    def __init__(self, port: int, password: str) -> None:
        self.port = port
        self._password = password

    def new_database(self) -> str:
        import psycopg

        name = f"breastrig_{secrets.token_hex(6)}"
        with psycopg.connect(self._url("postgres"), autocommit=True) as connection:
            connection.execute(f"CREATE DATABASE {name}")  # letters and digits of our own
        return self._url(name)

    def _url(self, database: str) -> str:
        return f"postgresql://breastrig:{self._password}@127.0.0.1:{self.port}/{database}"


@contextmanager
def postgres_server() -> Iterator[PostgresServer]:
    """A running server with the safety of a crash off, as its data are of no use afterwards."""
    bin_folder, password = programs(), secrets.token_hex(16)
    folder = Path(tempfile.mkdtemp(prefix="pg-", dir="/tmp"))  # short, for the socket's name
    as_user: list[str] = []
    if os.geteuid() == 0:
        as_user = ["setpriv", "--reuid=nobody", "--regid=nogroup", "--clear-groups", "--"]
        shutil.chown(folder, "nobody")
    (folder / "password").write_text(password)
    (folder / "password").chmod(0o644)  # the folder is its owner's alone
    try:
        options = ["--auth=scram-sha-256", "--username=breastrig", f"--pwfile={folder / 'password'}", "--no-sync"]
        _run([*as_user, bin_folder / "initdb", "-D", folder / "data", *options, "--encoding=UTF8", "--locale=C"])
        port = _free_port()
        settings = ("fsync=off", "synchronous_commit=off", "full_page_writes=off", "max_connections=60")
        settings += (f"port={port}", "listen_addresses=127.0.0.1", "unix_socket_directories=")
        command = [*as_user, bin_folder / "postgres", "-D", folder / "data"]
        command += [part for setting in settings for part in ("-c", setting)]
        with (folder / "log").open("w") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, cwd=folder)
        try:
            _wait(bin_folder, port, process, folder / "log")
            yield PostgresServer(port, password)
        finally:
            process.send_signal(2)  # a fast stop, which does not wait for clients
            process.wait(timeout=120)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _run(command: list[object]) -> None:
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, cwd="/", check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def _wait(bin_folder: Path, port: int, process: "subprocess.Popen[bytes]", log: Path) -> None:
    from helpers.waiting import until

    def ready() -> bool:
        assert process.poll() is None, log.read_text()
        asked = [str(bin_folder / "pg_isready"), "-q", "-h", "127.0.0.1", "-p", str(port)]
        return subprocess.run(asked, check=False).returncode == 0

    until(ready, "PostgreSQL")


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port

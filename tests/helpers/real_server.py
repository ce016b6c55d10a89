"""`breastrig serve` as a process of its own, with fits that need no numerics; and what is known of its children."""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx

PROGRAM = Path(__file__).with_name("serve_fake.py")


@contextmanager
def starting(data: Path, model: Path, log: Path, *options: str, **environment: str) -> Iterator[subprocess.Popen[str]]:
    """A server that may not be ready yet; it is killed at the end."""
    with log.open("a") as errors:
        process = subprocess.Popen(
            [sys.executable, str(PROGRAM), "--port", "0", "--data", str(data), "--model", str(model), *options],
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
            env=os.environ | {"PYTHONPATH": search_path(), **environment},
        )
    assert process.stdout is not None
    try:
        yield process
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


@contextmanager
def server(
    data: Path, model: Path, log: Path, *options: str, **environment: str
) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """(process, address) of a running server."""
    with starting(data, model, log, *options, **environment) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.search(r"http://\S+", line)
        assert found, f"{line}\n{log.read_text()}"
        yield process, found[0]


def search_path() -> str:
    """The folder of the helpers, before whatever the tests were started with."""
    return os.pathsep.join([str(PROGRAM.parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])])


def children(pid: int) -> set[int]:
    """All processes below one."""
    below: set[int] = set()
    tasks = [pid]
    while tasks:
        try:
            found = Path(f"/proc/{tasks[-1]}/task/{tasks.pop()}/children").read_text().split()
        except FileNotFoundError:
            continue
        new = {int(one) for one in found} - below
        below |= new
        tasks.extend(new)
    return below


def alive(pids: set[int]) -> set[int]:
    """Those that still run (a zombie does not)."""
    running = set()
    for pid in pids:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except (FileNotFoundError, ProcessLookupError):
            continue
        if state != "Z":
            running.add(pid)
    return running


def read_events(client: httpx.Client, address: str, **headers: str) -> list[str]:
    """The event blocks of a stream, to its end."""
    with client.stream("GET", address, headers=headers) as answer:
        assert answer.status_code == 200
        return [block for block in "".join(answer.iter_text()).split("\n\n") if block.startswith("id:")]

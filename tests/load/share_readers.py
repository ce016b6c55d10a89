"""Readers of a large scan through a share link: some that read it all at once, and some that never read.

They are not bound to succeed at once: beyond its bounds the service asks them to come again, and they do.  What counts
is that all that read get the same whole file, and that the server's memory does not grow with them.
"""

import hashlib
import os
import re
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event, Thread

import httpx
import numpy as np
import trimesh

from breastrig.core.assets import asset_folder

SERVE = ("-m", "breastrig.cli.main", "serve", "--no-token")
CHUNK = 2**16
PATIENCE_S = 300.0
LOOK_EVERY_S = 0.02
SILENT_S = 5.0  # how long the silent ones are left alone with the server
MOST_GROWTH_MB = 100.0  # all readers together; one coloured mesh of 2,000,000 triangles alone has 56


@dataclass
class ShareReaders:
    """What a run found; megabytes are those of the server's own process."""

    triangles: int = 0
    mesh_mb: float = 0.0
    before_mb: float = 0.0
    reading_mb: float = 0.0  # at most, while the readers read
    silent_mb: float = 0.0  # at most, while the silent ones hold their connections
    after_mb: float = 0.0
    seconds: float = 0.0  # until the last reader had its file
    whole: int = 0  # readers that got all of it, the same bytes
    sent_back: int = 0  # answers that asked a reader to come again
    silent_answers: dict[str, int] = field(default_factory=dict)  # status -> how many of the silent ones got it
    errors: list[str] = field(default_factory=list)

    @property
    def growth_mb(self) -> float:
        return max(self.reading_mb, self.silent_mb, self.after_mb) - self.before_mb

    def table(self) -> list[str]:
        silent = ", ".join(f"{count} x {status}" for status, count in sorted(self.silent_answers.items()))
        return [
            f"scan through a link     {self.triangles:,} triangles, {self.mesh_mb:.0f} MB without colours",
            f"readers                 {self.whole} whole in {self.seconds:.1f} s, {self.sent_back} asked to come again",
            f"never read              {silent}",
            f"the server's memory MB  {self.before_mb:.0f} before, {self.reading_mb:.0f} while reading, "
            f"{self.silent_mb:.0f} with those that never read, {self.after_mb:.0f} after",
            *(f"error                   {error}" for error in self.errors),
        ]


def fine_scan(triangles: int) -> bytes:
    """The example patient with about so many triangles and vertex colours, as a binary PLY."""
    mesh = trimesh.load(asset_folder("example") / "standing" / "scan.ply", process=False)
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    while 4 * len(faces) <= 1.05 * triangles:
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    left = min(max(0, triangles - len(faces)) // 3, len(faces))
    vertices, faces = trimesh.remesh.subdivide(vertices, faces, face_index=np.arange(left))
    colours = np.random.default_rng(4).integers(0, 255, (len(vertices), 4), dtype=np.uint8)
    scan = trimesh.Trimesh(vertices, faces, vertex_colors=colours, process=False)
    return bytes(scan.export(file_type="ply"))


def run_share_readers(
    triangles: int, readers: int = 12, silent: int = 30, program: Sequence[str] = SERVE, **environment: str
) -> ShareReaders:
    """On a server of its own, which `program` starts, with the example patient's fit."""
    found = ShareReaders()
    with tempfile.TemporaryDirectory() as folder, _server(Path(folder), program, environment) as (pid, port):
        base = f"http://127.0.0.1:{port}"
        with httpx.Client(base_url=base, timeout=PATIENCE_S) as owner:
            scan = owner.post("/api/scans", files={"file": ("a.ply", fine_scan(triangles))}).json()
            found.triangles = scan["triangles"]
            token = _shared(owner, scan["id"])
            opened = owner.post("/api/shared/open", json={"token": token})
            mesh = opened.json()["links"]["mesh"]
            cookie = "; ".join(f"{name}={value}" for name, value in opened.cookies.items())
            assert found.triangles > 0.9 * triangles
            found.mesh_mb = int(owner.head(mesh, headers={"Cookie": cookie}).headers["Content-Length"]) / 1e6
        found.before_mb = _resident_mb(pid)
        with _watched(pid) as most:
            _read_all(found, base, mesh, cookie, readers)
        found.reading_mb = most[0]
        with _watched(pid) as most, ExitStack() as stack:
            connections = [stack.enter_context(_asked(port, mesh, cookie)) for _ in range(silent)]
            time.sleep(SILENT_S)
            for connection in connections:
                status = connection.recv(12, socket.MSG_PEEK).decode().split(" ")[-1] or "closed"
                found.silent_answers[status] = found.silent_answers.get(status, 0) + 1
        found.silent_mb = most[0]
        time.sleep(1.0)
        found.after_mb = _resident_mb(pid)
    if found.whole != readers:
        found.errors.append(f"{readers - found.whole} readers did not get the scan")
    if found.growth_mb > MOST_GROWTH_MB:
        found.errors.append(f"the server grew by {found.growth_mb:.0f} MB, more than {MOST_GROWTH_MB:.0f}")
    return found


def _shared(owner: httpx.Client, scan_id: str) -> str:
    """The secret of a link that shows the scan without its colours."""
    fit = owner.post("/api/fits", json={"scan": scan_id, "drawing": None}).json()
    end = time.monotonic() + PATIENCE_S
    while (state := owner.get(fit["links"]["self"]).json()["state"]) in ("queued", "running"):
        assert time.monotonic() < end, "the fit does not end"
        time.sleep(0.2)
    assert state == "done", state
    made = owner.post(fit["links"]["shares"], json={"scan": "plain"})
    assert made.status_code == 201, made.text
    return str(made.json()["url"]).split("#")[1]


def _read_all(found: ShareReaders, base: str, mesh: str, cookie: str, readers: int) -> None:
    began = time.monotonic()

    def read(_number: int) -> tuple[str, int]:
        sent_back = 0
        with httpx.Client(base_url=base, timeout=PATIENCE_S, headers={"Cookie": cookie}) as visitor:
            while time.monotonic() - began < PATIENCE_S:
                with visitor.stream("GET", mesh) as answer:
                    if answer.status_code == 200:
                        digest = hashlib.sha256()
                        for chunk in answer.iter_bytes(CHUNK):
                            digest.update(chunk)
                        return digest.hexdigest(), sent_back
                    assert answer.status_code in (429, 503), answer.status_code
                    sent_back += 1
                    wait_s = int(answer.headers["Retry-After"])
                time.sleep(wait_s)
        raise AssertionError("a reader was asked to come again for too long")

    with ThreadPoolExecutor(readers) as pool:
        tasks = [pool.submit(read, number) for number in range(readers)]
        digests = []
        for task in tasks:
            try:
                digest, sent_back = task.result()
                digests.append(digest)
                found.sent_back += sent_back
            except (httpx.HTTPError, AssertionError) as error:
                found.errors.append(f"reader: {error!r}"[:300])
    found.seconds = time.monotonic() - began
    found.whole = max((digests.count(one) for one in set(digests)), default=0)


@contextmanager
def _asked(port: int, mesh: str, cookie: str) -> Iterator[socket.socket]:
    """A connection that has asked for the scan and will not read it."""
    with socket.create_connection(("127.0.0.1", port), timeout=SILENT_S) as connection:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        connection.sendall(f"GET {mesh} HTTP/1.1\r\nHost: localhost\r\nCookie: {cookie}\r\n\r\n".encode())
        yield connection


def _resident_mb(pid: int) -> float:
    """Of the server alone, without its workers."""
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.split("VmRSS:")[1].split()[0]) / 1000


@contextmanager
def _watched(pid: int) -> Iterator[list[float]]:
    """[the most memory (MB) that the server had inside the block]"""
    most, over = [0.0], Event()

    def look() -> None:
        while not over.wait(LOOK_EVERY_S):
            most[0] = max(most[0], _resident_mb(pid))

    watcher = Thread(target=look, daemon=True)
    watcher.start()
    try:
        yield most
    finally:
        over.set()
        watcher.join()


@contextmanager
def _server(folder: Path, program: Sequence[str], environment: dict[str, str]) -> Iterator[tuple[int, int]]:
    """(process id, port) of `breastrig serve` with a data folder of its own."""
    with (folder / "log").open("w") as errors:
        server = subprocess.Popen(
            [sys.executable, *program, "--port", "0", "--data", str(folder / "data")],
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
            env=os.environ | environment,
        )
    assert server.stdout is not None
    try:
        ready = re.search(r"http://[^:]+:(\d+)/", server.stdout.readline())
        assert ready, (folder / "log").read_text()
        yield server.pid, int(ready[1])
        server.terminate()
        server.wait(timeout=60)
    finally:
        server.kill()
        server.wait()
        server.stdout.close()

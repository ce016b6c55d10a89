"""Clients that want nothing but to be there: idle connections, slow headers, slow bodies, slow readers.

Each comes from one of some loopback addresses that no working client has, and comes again when the server sends it
away.  They are no errors of the server's: the table says how many it held, and how many it sent away.
"""

import asyncio
import resource
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field

ADDRESSES = 40  # so many houses
DRIP_S = 1.0
AT_ONCE = 100  # connections that are being opened
PATIENCE_S = 120.0  # for the server to take them all, before the others begin
HEAD = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n"
BODY = b"POST /api/scans HTTP/1.1\r\nHost: localhost\r\nContent-Type: multipart/form-data; boundary=b\r\n"
LARGE = b"GET /api/models/torso.glb HTTP/1.1\r\nHost: localhost\r\n\r\n"


@dataclass(frozen=True)
class SlowClients:
    """How many of each kind."""

    idle: int = 0
    headers: int = 0
    bodies: int = 0
    readers: int = 0

    @property
    def total(self) -> int:
        return self.idle + self.headers + self.bodies + self.readers


@dataclass
class Kept:
    """What became of one kind."""

    wanted: int
    held: int = 0  # now
    sent_away: int = 0
    not_let_in: int = 0


@dataclass
class Slow:
    port: int
    kinds: dict[str, Kept] = field(default_factory=dict)
    opening: asyncio.Semaphore = field(default_factory=lambda: asyncio.Semaphore(AT_ONCE))

    async def settled(self) -> None:
        """Until all are there, or for as long as one can wait for that."""
        with suppress(TimeoutError):
            async with asyncio.timeout(PATIENCE_S):
                while any(kept.held < kept.wanted for kept in self.kinds.values()):
                    await asyncio.sleep(0.1)


def allow_files(wanted: int) -> None:
    """For this process; the clients are here."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(wanted, hard), hard))


def start(tasks: asyncio.TaskGroup, port: int, clients: SlowClients) -> tuple[Slow, list[asyncio.Task[None]]]:
    """All of them, until they are cancelled."""
    slow = Slow(port)
    ways = (("idle", clients.idle, _idle), ("slow headers", clients.headers, _headers))
    ways += (("slow bodies", clients.bodies, _bodies), ("slow readers", clients.readers, _reader))
    started = []
    for kind, count, way in ways:
        kept = slow.kinds[kind] = Kept(count)
        started += [tasks.create_task(_again(slow, kept, number, way)) for number in range(count)]
    return slow, started


async def _again(slow: Slow, kept: Kept, number: int, way: object) -> None:
    while True:
        try:
            async with _connected(slow, number) as (reader, writer):
                await way(kept, reader, writer)
        except (OSError, asyncio.IncompleteReadError, TimeoutError):
            kept.not_let_in += 1
        await asyncio.sleep(DRIP_S)


@asynccontextmanager
async def _connected(slow: Slow, number: int) -> AsyncIterator[tuple[asyncio.StreamReader, asyncio.StreamWriter]]:
    plain = socket.socket()
    plain.setblocking(False)
    plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)  # what is not read stays with the server
    plain.bind((f"127.0.7.{1 + number % ADDRESSES}", 0))
    async with slow.opening, asyncio.timeout(PATIENCE_S):
        await asyncio.get_running_loop().sock_connect(plain, ("127.0.0.1", slow.port))
        reader, writer = await asyncio.open_connection(sock=plain, limit=1024)
    try:
        yield reader, writer
    finally:
        writer.transport.abort()


async def _held(kept: Kept, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, drip: bytes) -> None:
    """Sends a little now and then until the server ends it."""
    kept.held += 1
    try:
        while True:
            with suppress(TimeoutError):
                async with asyncio.timeout(DRIP_S):
                    await reader.read(1)
                return
            writer.write(drip)
    finally:
        kept.held -= 1
        kept.sent_away += 1


async def _idle(kept: Kept, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    async with asyncio.timeout(30):
        writer.write(HEAD + b"\r\n")
        head = await reader.readuntil(b"\r\n\r\n")
        length = next(line for line in head.lower().split(b"\r\n") if line.startswith(b"content-length:"))
        await reader.readexactly(int(length.split(b":")[1]))
    await _held(kept, reader, writer, b"")


async def _headers(kept: Kept, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    writer.write(HEAD + b"X: ")
    await _held(kept, reader, writer, b"x")


async def _bodies(kept: Kept, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    writer.write(BODY + b"Content-Length: 1000000\r\n\r\n")
    await _held(kept, reader, writer, b"-" * 10)


async def _reader(kept: Kept, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Asks for the model and reads a kilobyte now and then."""
    writer.write(LARGE)
    kept.held += 1
    try:
        while await reader.read(1000):
            await asyncio.sleep(DRIP_S)
    finally:
        kept.held -= 1
        kept.sent_away += 1

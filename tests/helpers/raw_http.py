"""HTTP by hand over a plain socket: for clients that are slow, broken, or come from another address."""

import socket
from dataclasses import dataclass


@dataclass(frozen=True)
class Answer:
    status: int
    headers: dict[str, str]  # names in lower case
    body: bytes


def connected(port: int, source: str = "127.0.0.1") -> socket.socket:
    """A connection from one of this machine's loopback addresses."""
    return socket.create_connection(("127.0.0.1", port), timeout=120, source_address=(source, 0))


def request(address: str, method: str = "GET", body: bytes = b"", **headers: object) -> bytes:
    """A whole request; header names with _ for -."""
    named = {"Host": "localhost", **{name.replace("_", "-"): value for name, value in headers.items()}}
    if body:
        named.setdefault("Content-Length", len(body))
    lines = [f"{method} {address} HTTP/1.1", *(f"{name}: {value}" for name, value in named.items())]
    return "\r\n".join(lines).encode() + b"\r\n\r\n" + body


def answer(connection: socket.socket, *, bodiless: bool = False) -> Answer:
    """The next answer: not a byte more is read.  Fails when the connection ends before."""
    head = b""
    while not head.endswith(b"\r\n\r\n"):
        byte = connection.recv(1)
        assert byte, f"the connection ended after {head!r}"
        head += byte
    first, *lines = head.decode("latin-1").strip().split("\r\n")
    headers = {name.lower(): value for name, _, value in (line.partition(": ") for line in lines)}
    left = 0 if bodiless else int(headers.get("content-length", 0))
    body = b""
    while len(body) < left:
        chunk = connection.recv(left - len(body))
        assert chunk, f"the connection ended after {len(body)} of {left} bytes"
        body += chunk
    return Answer(int(first.split(" ")[1]), headers, body)


def is_closed(connection: socket.socket) -> bool:
    """Whether the server ends the connection, without another word, within the socket's time."""
    try:
        return connection.recv(1) == b""
    except ConnectionError:
        return True


def is_open(connection: socket.socket) -> bool:
    """Whether nothing has come and nothing has ended."""
    connection.setblocking(False)
    try:
        return connection.recv(1, socket.MSG_PEEK) != b""
    except BlockingIOError:
        return True
    except ConnectionError:
        return False
    finally:
        connection.settimeout(120)

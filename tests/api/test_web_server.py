"""The web server around the application: what slow, idle and broken clients cost, and what they do to others.

In this process, with limits of a few requests and fractions of a second.
"""

import json
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import replace
from typing import Any

import pytest
from flask import Response
from helpers import in_worker
from helpers.raw_http import answer, connected, is_closed, is_open, request
from helpers.waiting import PATIENCE_S, ask_for_fit, until

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.api.web_server import Server, ServerLimits
from breastrig.execution.pool import client_key
from breastrig.service.service import Service

pytestmark = pytest.mark.long

TOKEN = "a-token-of-more-than-sixteen-characters"
BIG = bytes(range(256)) * 80_000  # 20 MB: more than the system takes for a reader who reads nothing
UPLOAD = b'--b\r\nContent-Disposition: form-data; name="file"; filename="a.ply"\r\n\r\nno scan\r\n--b--\r\n'
MULTIPART = "multipart/form-data; boundary=b"

Serve = Callable[..., AbstractContextManager["Served"]]


class Served:
    """A running server and routes of the tests' own."""

    def __init__(self, server: Server) -> None:
        self.server = server
        self.port = server.effective_port
        self.release = threading.Event()
        self.at_work = threading.Semaphore(0)
        self.closed = threading.Event()

    def block(self) -> str:
        """Holds a thread until the test lets it go."""
        self.at_work.release()
        assert self.release.wait(20)
        return "done"

    def big(self) -> Response:
        response = Response((BIG[k : k + 100_000] for k in range(0, len(BIG), 100_000)), mimetype="text/plain")
        response.content_length = len(BIG)
        response.call_on_close(self.closed.set)
        return response

    def ask(self, address: str = "/healthz", source: str = "127.0.0.1", **headers: object) -> int:
        """The status of a request on a connection of its own."""
        with connected(self.port, source) as connection:
            connection.sendall(request(address, **headers))
            return answer(connection).status


@pytest.fixture
def serve(service: Service, config: Config) -> Serve:
    @contextmanager
    def serving(limits: dict[str, Any] | None = None, **changes: Any) -> Iterator[Served]:
        used = replace(config, **changes)
        app = create_app(used, service)
        served = Served(Server(app.wsgi_app, used, 0, lambda: None, ServerLimits(**limits or {})))
        app.add_url_rule("/test/block", "block", served.block)
        app.add_url_rule("/test/big", "big", served.big)
        app.add_url_rule("/test/cut", "cut", lambda: Response(cut(), mimetype="text/plain"))
        app.add_url_rule("/test/broken", "broken", lambda: Response(broken(), mimetype="text/plain"))
        runs = threading.Thread(target=served.server.run)
        runs.start()
        try:
            yield served
        finally:
            served.release.set()
            served.server.stop()
            runs.join(20)
            served.server.close()
        assert not runs.is_alive()

    return serving


def broken() -> Iterator[bytes]:
    yield bytes(200_000)
    raise ZeroDivisionError


def cut() -> Iterator[bytes]:
    yield bytes(200_000)
    raise ConnectionAbortedError("another reader needed the place")


def problem_of(connection: socket.socket, status: int) -> str:
    """The sentence of a problem-details answer."""
    found = answer(connection)
    assert (found.status, found.headers["content-type"]) == (status, "application/problem+json")
    assert found.headers["x-content-type-options"] == "nosniff"
    assert "server" not in found.headers
    document = json.loads(found.body)
    assert document["status"] == status
    sentence: str = document["detail"]
    return sentence


def upload_head(size: int, **headers: object) -> bytes:
    return request("/api/scans", "POST", Content_Type=MULTIPART, Content_Length=size, **headers)


@pytest.mark.slow
def test_idle_connections_hold_no_thread_and_stay_open(serve: Serve) -> None:
    with serve() as served, ExitStack() as stack:
        assert served.ask() == 200
        threads = threading.active_count()
        for _ in range(1024):  # select() knows no file beyond
            stack.callback(os.close, os.open(os.devnull, os.O_RDONLY))
        idle = [stack.enter_context(connected(served.port)) for _ in range(40)]
        assert idle[0].fileno() > 1024
        for connection in idle:
            connection.sendall(request("/healthz"))
            assert answer(connection).status == 200
        assert threading.active_count() < threads + 10  # of the pool, where an answer's thread was not yet free again
        assert served.ask("/api/meta") == 200
        assert all(map(is_open, idle))
        idle[0].sendall(request("/healthz"))
        assert answer(idle[0]).status == 200


@pytest.mark.slow
def test_a_low_limit_of_open_files_is_raised_and_what_the_system_refuses_is_left() -> None:
    program = """
import resource, sys
from breastrig.api.web_server import _raise_file_limit
resource.setrlimit(resource.RLIMIT_NOFILE, (256, 2000))
print(_raise_file_limit(1500), resource.getrlimit(resource.RLIMIT_NOFILE)[0])
print(_raise_file_limit(9000), resource.getrlimit(resource.RLIMIT_NOFILE)[0])
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "1500 1500\n2000 2000\n"


def test_who_says_nothing_or_half_a_head_is_left_after_a_while(serve: Serve) -> None:
    with serve({"idle_s": 1}) as served, ExitStack() as stack:
        silent, half, second = (stack.enter_context(connected(served.port)) for _ in range(3))
        half.sendall(b"GET /healthz HTTP/1.1\r\nHost: loc")
        second.sendall(request("/healthz"))
        assert answer(second).status == 200
        second.sendall(b"G")
        assert is_closed(silent)
        assert is_closed(half)
        assert is_closed(second)


def test_a_head_without_end_and_what_is_no_http_are_refused(serve: Serve) -> None:
    with serve({"head_bytes": 4096}) as served:
        for sent in (b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " + b"x" * 10_000, b"\x16\x03\x01 no HTTP\r\n\r\n"):
            with connected(served.port) as connection:
                connection.sendall(sent)
                assert answer(connection).status == 400
                while connection.recv(1000):  # until the server ends the connection
                    pass


def test_beyond_the_most_connections_a_new_one_is_refused(serve: Serve) -> None:
    with serve({"connections": 64}) as served, ExitStack() as stack:
        silent = [stack.enter_context(connected(served.port)) for _ in range(64)]
        until(lambda: served.ask() == 503, "a full house")
        for connection in silent[:10]:
            connection.close()
        until(lambda: served.ask() == 200, "places that are free again")


def test_a_body_that_stops_ends_its_request_and_frees_its_thread(serve: Serve) -> None:
    with serve({"silent_s": 0.3, "threads": 2}) as served, ExitStack() as stack:
        slow = [stack.enter_context(connected(served.port)) for _ in range(4)]
        for connection in slow:
            connection.sendall(upload_head(10_000) + b"--b")
        assert [problem_of(connection, 400) for connection in slow]
        assert served.ask() == 200


def test_a_body_is_not_waited_for_before_the_headers_have_been_judged(serve: Serve) -> None:
    right = {"Authorization": f"Bearer {TOKEN}"}
    cases: list[tuple[bytes, int]] = [
        (upload_head(100_000_000), 401),
        (upload_head(100_000_000, Authorization="Bearer wrong"), 401),
        (upload_head(100_000_000, **right, Origin="http://evil.example"), 403),
        (upload_head(1_900_000_000, **right), 413),
        (request("/api/scans", "POST", Content_Type="text/plain", Content_Length=1000, **right), 415),
        (request("/api/fits", "POST", Content_Type="application/json", Content_Length=21_000_000, **right), 413),
        (request("/api/nothing", "POST", Content_Length=1000, **right), 404),
        (request("/api/meta", "PUT", Content_Length=1000, **right), 405),
        (request("/sign-in", "POST", Content_Length=20_000), 413),
        (request("/healthz", Content_Length=20_000), 413),
        (upload_head(100, **right, Host="evil.example"), 421),
    ]
    with serve({"idle_s": 1}, token=TOKEN, public_hosts=("scans.example",)) as served:
        for sent, status in cases:
            with connected(served.port) as connection:
                connection.sendall(sent.replace(b"Host: localhost\r\n", b"", sent.count(b"Host:") - 1))
                assert problem_of(connection, status)


def test_a_refused_body_is_taken_until_its_end_so_that_the_answer_arrives(serve: Serve) -> None:
    with serve(token=TOKEN) as served, connected(served.port) as connection:
        for _ in range(2):
            connection.sendall(upload_head(30_000_000) + bytes(30_000_000))
            assert "needs its token" in problem_of(connection, 401)


@pytest.mark.slow
def test_who_asks_whether_to_send_a_body_is_answered_before_it_is_sent(serve: Serve) -> None:
    with serve({"idle_s": 1}, token=TOKEN) as served:
        with connected(served.port) as connection:
            connection.sendall(upload_head(10_000, Expect="100-continue"))
            assert problem_of(connection, 401)
            assert is_closed(connection)
        with connected(served.port) as connection:
            right = f"Bearer {TOKEN}"
            connection.sendall(upload_head(len(UPLOAD), Expect="100-continue", Authorization=right))
            assert answer(connection).status == 100
            connection.sendall(UPLOAD)
            assert problem_of(connection, 422)


def test_a_body_of_unknown_length_is_refused(serve: Serve) -> None:
    head = request("/api/fits", "POST", Content_Type="application/json", Transfer_Encoding="chunked")
    with serve() as served, connected(served.port) as connection:
        connection.sendall(head + b'D\r\n{"scan": "a"}\r\n0\r\n\r\n')
        assert "with its length" in problem_of(connection, 411)


@pytest.mark.slow
def test_readers_that_read_nothing_are_left(serve: Serve) -> None:
    with serve({"silent_s": 0.5, "threads": 2}) as served, ExitStack() as stack:
        slow = [stack.enter_context(connected(served.port)) for _ in range(4)]
        for connection in slow:
            connection.sendall(request("/test/big"))
        assert served.ask() == 200
        assert served.closed.wait(20)


def test_a_patient_reader_gets_all_of_a_large_answer(serve: Serve) -> None:
    with serve({"threads": 1}) as served, connected(served.port) as connection:
        for _ in range(2):
            connection.sendall(request("/test/big"))
            assert answer(connection).body == BIG
        assert served.closed.is_set()


@pytest.mark.usefixtures("computed_anew")
def test_one_client_cannot_take_all_readers(
    serve: Serve, service: Service, torso: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    readers = service._readers
    monkeypatch.setattr(readers, "per_client", 1)
    file = UPLOAD.replace(b"no scan", torso)
    with serve() as served, ExitStack() as stack:
        before = client_key.set("127.0.0.2")
        slow = readers.schedule(in_worker.rest, (60.0,), 90.0)
        client_key.reset(before)
        greedy, other = (stack.enter_context(connected(served.port, f"127.0.0.{last}")) for last in (2, 3))
        for connection in (greedy, other):
            connection.sendall(upload_head(len(file)) + file)
        assert "as many as one client may have" in problem_of(greedy, 429)
        kept = answer(other)
        assert kept.status == 201
        slow.cancel()
        other.sendall(request(kept.headers["location"], "DELETE"))
        assert answer(other).status == 204


def test_a_stream_ends_with_its_fit_and_is_given_up_when_its_viewer_leaves(
    serve: Serve, service: Service, scan_id: str
) -> None:
    fit_id = ask_for_fit(service, scan_id, preset="paper")
    with serve(heartbeat_s=3600.0) as served, ExitStack() as stack:
        viewers = [stack.enter_context(connected(served.port)) for _ in range(5)]
        for viewer in viewers:
            viewer.sendall(request(f"/api/fits/{fit_id}/events"))
            assert viewer.recv(1000).startswith(b"HTTP/1.1 200")
        viewers.pop().close()
        until(lambda: service._notifier.listening <= 4, "a stream that was given up")
        service.cancel_fit(fit_id)
        for viewer in viewers:
            heard = b""
            while not heard.endswith(b"0\r\n\r\n"):
                heard += viewer.recv(65_536)
            assert b"event: cancelled" in heard


def test_one_client_cannot_take_all_threads(serve: Serve) -> None:
    with serve({"threads": 3, "threads_each": 2}) as served, ExitStack() as stack:
        slow = [stack.enter_context(connected(served.port, "127.0.0.2")) for _ in range(2)]
        for connection in slow:
            connection.sendall(request("/test/block"))
            assert served.at_work.acquire(timeout=PATIENCE_S)
        with connected(served.port, "127.0.0.2") as third:
            third.sendall(request("/healthz"))
            assert "as many requests in work as one client may" in problem_of(third, 429)
        assert served.ask(source="127.0.0.3") == 200
        served.release.set()
        assert [answer(connection).body for connection in slow] == [b"done"] * 2


def test_an_answer_that_breaks_off_ends_the_connection_and_is_logged_without_its_address(
    serve: Serve, caplog: pytest.LogCaptureFixture
) -> None:
    with serve() as served, connected(served.port) as connection:
        connection.sendall(request("/test/broken?name=Miller"))
        received = b""
        while chunk := connection.recv(100_000):
            received += chunk
        assert received.startswith(b"HTTP/1.1 200")
        assert not received.endswith(b"0\r\n\r\n")
        assert served.ask() == 200
    assert "ZeroDivisionError" in caplog.text
    assert "Miller" not in caplog.text
    assert "/test" not in caplog.text


def test_a_reader_that_is_sent_away_on_purpose_is_no_error(serve: Serve, caplog: pytest.LogCaptureFixture) -> None:
    with serve() as served, connected(served.port) as connection:
        connection.sendall(request("/test/cut"))
        received = b""
        while chunk := connection.recv(100_000):
            received += chunk
        assert received.startswith(b"HTTP/1.1 200")
        assert not received.endswith(b"0\r\n\r\n")
    assert [record for record in caplog.records if record.levelname == "ERROR"] == []


def test_requests_that_come_together_are_answered_in_their_order(serve: Serve) -> None:
    with serve() as served, connected(served.port) as connection:
        connection.sendall(
            request("/healthz") + request("/nothing") + request("/api/meta", "HEAD") + request("/healthz")
        )
        assert [answer(connection).status for _ in range(2)] == [200, 404]
        assert answer(connection, bodiless=True).status == 200
        assert answer(connection).status == 200


def test_a_header_with_an_underscore_is_not_taken_for_another(serve: Serve) -> None:
    with serve() as served, connected(served.port) as connection:
        connection.sendall(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nX_Forwarded_For: 8.8.8.8\r\n\r\n")
        assert answer(connection).status == 200


def test_a_stopping_server_lets_answers_end_and_closes_what_only_waits(serve: Serve) -> None:
    with serve() as served, connected(served.port) as idle, connected(served.port) as busy:
        idle.sendall(request("/healthz"))
        assert answer(idle).status == 200
        busy.sendall(request("/test/block"))
        assert served.at_work.acquire(timeout=PATIENCE_S)
        served.server.stop()
        assert is_closed(idle)
        served.release.set()
        assert answer(busy).body == b"done"
        assert is_closed(busy)

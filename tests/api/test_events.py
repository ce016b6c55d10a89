import json
from itertools import chain

import pytest
from flask.testing import FlaskClient
from helpers.problems import problem

from breastrig.api.routes import events
from breastrig.service.service import Service


def parsed(stream: bytes) -> list[tuple[int, str, dict]]:
    """(id, event, data) of each event of a stream."""
    events = []
    for block in stream.decode().split("\n\n"):
        fields = dict(line.split(": ", 1) for line in block.splitlines() if not line.startswith(":"))
        if "data" in fields:
            events.append((int(fields["id"]), fields["event"], json.loads(fields["data"])))
    return events


def test_the_stream_sends_the_stored_events_and_closes(client: FlaskClient, fit_id: str) -> None:
    answer = client.get(f"/api/fits/{fit_id}/events")
    assert (answer.status_code, answer.mimetype) == (200, "text/event-stream")
    assert answer.headers["Cache-Control"] == "no-store"
    assert answer.headers["X-Accel-Buffering"] == "no"
    assert answer.data.startswith(b"retry: 1000\n\n")
    events = parsed(answer.data)
    assert [(number, kind) for number, kind, _ in events] == [
        (1, "started"),
        (2, "iterated"),
        (3, "iterated"),
        (4, "iterated"),
        (5, "iterated"),
        (6, "done"),
    ]
    assert all(data["kind"] == kind for _, kind, data in events)
    assert parsed(client.get(f"/api/fits/{fit_id}/events").data) == events


def test_who_opens_a_stream_late_gets_all_of_it_in_one_piece(client: FlaskClient, fit_id: str) -> None:
    answer = client.get(f"/api/fits/{fit_id}/events", buffered=False)
    pieces = list(answer.iter_encoded())
    assert [len(parsed(piece)) for piece in pieces] == [6]


def test_a_long_stream_comes_in_pieces_of_bounded_size(
    client: FlaskClient, fit_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = client.get(f"/api/fits/{fit_id}/events").data
    monkeypatch.setattr(events, "TOGETHER", 1)
    pieces = list(client.get(f"/api/fits/{fit_id}/events", buffered=False).iter_encoded())
    assert [len(parsed(piece)) for piece in pieces] == [1, 1, 1, 1, 1, 1]
    assert b"".join(pieces) == whole


def test_the_polling_twin_gives_the_same(client: FlaskClient, fit_id: str) -> None:
    streamed = parsed(client.get(f"/api/fits/{fit_id}/events").data)
    page = client.get(f"/api/fits/{fit_id}/events.json")
    assert page.headers["Cache-Control"] == "no-store"
    assert page.json["state"] == "done"
    assert [(one["id"], one["event"]) for one in page.json["events"]] == [(n, data) for n, _, data in streamed]
    rest = client.get(f"/api/fits/{fit_id}/events.json?after=4").json
    assert [one["id"] for one in rest["events"]] == [5, 6]


def test_many_events_come_page_by_page(client: FlaskClient, fit_id: str) -> None:
    whole = client.get(f"/api/fits/{fit_id}/events.json").json
    assert whole["next"] is None
    received, address = [], f"/api/fits/{fit_id}/events.json?limit=4"
    while address:
        page = client.get(address).json
        assert len(page["events"]) <= 4
        received += page["events"]
        address = page["next"]
    assert received == whole["events"]
    for limit in ("0", "1001", "x"):
        assert "limit" in problem(client.get(f"/api/fits/{fit_id}/events.json?limit={limit}"), 422)


def test_a_stream_goes_on_where_it_was_left(client: FlaskClient, fit_id: str) -> None:
    place = f"/api/fits/{fit_id}/events"
    assert [e[0] for e in parsed(client.get(place, headers={"Last-Event-ID": "3"}).data)] == [4, 5, 6]
    assert [e[0] for e in parsed(client.get(f"{place}?after=4").data)] == [5, 6]
    assert [e[0] for e in parsed(client.get(f"{place}?after=1", headers={"Last-Event-ID": "5"}).data)] == [6]


def test_who_has_heard_everything_is_asked_not_to_come_back(client: FlaskClient, fit_id: str) -> None:
    answer = client.get(f"/api/fits/{fit_id}/events", headers={"Last-Event-ID": "6"})
    assert (answer.status_code, answer.data) == (204, b"")


def test_a_node_names_only_what_it_changes(client: FlaskClient, fit_id: str) -> None:
    nodes = client.get(f"/api/fits/{fit_id}/events.json").json["events"][1]["event"]["nodes"]
    assert {frozenset(node) for node in nodes} == {
        frozenset({"name", "translation", "rotation"}),
        frozenset({"name", "scale"}),
        frozenset({"name", "weights"}),
    }


@pytest.mark.slow
@pytest.mark.parametrize("header", ["-1", "abc", "1.5", "٣", "9" * 40])
def test_a_last_event_id_that_is_no_number_is_refused(client: FlaskClient, fit_id: str, header: str) -> None:
    answer = client.get(f"/api/fits/{fit_id}/events", headers={"Last-Event-ID": header.encode().decode("latin-1")})
    assert "Last-Event-ID" in problem(answer, 400)


@pytest.mark.parametrize("after", ["-1", "abc", "", "9" * 40])
def test_an_after_that_is_no_number_is_refused(client: FlaskClient, fit_id: str, after: str) -> None:
    for place in ("events", "events.json"):
        assert problem(client.get(f"/api/fits/{fit_id}/{place}?after={after}"), 422).startswith("after:")


def test_a_running_fit_is_followed_with_heartbeats_until_it_is_cancelled(client: FlaskClient, scan_id: str) -> None:
    fit_id = client.post("/api/fits", json={"scan": scan_id, "preset": "paper", "drawing": None}).json["id"]
    answer = client.get(f"/api/fits/{fit_id}/events?after=1000", buffered=False)
    stream = answer.iter_encoded()
    begin = b"retry: 1000\n\n"
    first = next(stream)
    assert first.startswith(begin)
    rest = chain([first.removeprefix(begin)], stream)
    later = next(chunk for chunk in rest if not chunk.startswith(b"event: queued"))  # it may have to wait first
    assert later == b": still here\n\n"
    answer.close()
    client.post(f"/api/fits/{fit_id}/cancel")
    assert parsed(client.get(f"/api/fits/{fit_id}/events").data)[-1][1] == "cancelled"


def test_streams_leave_room_for_other_requests(client: FlaskClient, service: Service, fit_id: str) -> None:
    taken = 0
    while service.streams.acquire(blocking=False):
        taken += 1
    try:
        assert "events.json" in problem(client.get(f"/api/fits/{fit_id}/events"), 503)
        assert client.get(f"/api/fits/{fit_id}/events.json").status_code == 200
    finally:
        service.streams.release(taken)
    for _ in range(3 * taken):  # a stream that ends, or is never begun, gives its place back
        client.get(f"/api/fits/{fit_id}/events", buffered=False).close()
    assert client.get(f"/api/fits/{fit_id}/events").status_code == 200

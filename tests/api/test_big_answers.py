"""Large files to visitors: whole and in parts, from the disk, and only so many at once."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from flask.testing import FlaskClient
from helpers.problems import problem
from helpers.shares import shown_files

from breastrig.api import big_answers
from breastrig.api.app_context import KEY
from breastrig.api.big_answers import BigAnswers, WhileOpen
from breastrig.api.config import Config
from breastrig.api.share_limits import BIG_ANSWERS, BIG_ANSWERS_EACH, BIG_BYTES, BIG_RETRY_S, STILL_OPEN_S
from breastrig.service.service import Service

CONTENT = bytes(range(256)) * (BIG_BYTES // 256 + 1)


@pytest.fixture
def visitor(
    client: FlaskClient, client_for: Callable[[Config], FlaskClient], config: Config, service: Service, fit_id: str
) -> Iterator[tuple[FlaskClient, str, BigAnswers]]:
    """(a browser with an open link, the address of a large file, the answers under way)"""
    browser = client_for(replace(config, host="0.0.0.0", token="a-token-of-more-than-sixteen-characters"))
    made = client.post(f"/api/fits/{fit_id}/shares", json={}).json
    (shown_files(service, made["id"]) / "fitted.ply").write_bytes(CONTENT)
    token = made["url"].removeprefix("/s#")
    links = browser.post("/api/shared/open", json={"token": token}).json["links"]
    under_way = browser.application.extensions[KEY].big_answers
    yield browser, links["fitted_ply"], under_way
    assert under_way.under_way == 0


def test_a_large_file_is_sent_whole_and_in_parts(visitor: tuple[FlaskClient, str, BigAnswers]) -> None:
    browser, link, _ = visitor
    whole = browser.get(link)
    assert (whole.status_code, whole.data == CONTENT) == (200, True)
    assert whole.headers["Accept-Ranges"] == "bytes"
    assert whole.headers["Cache-Control"] == "no-store"
    assert whole.headers["Content-Disposition"] == "attachment; filename=fitted.ply"
    size = len(CONTENT)
    for asked, start, end in (
        ("bytes=0-0", 0, 1),
        (f"bytes={size - 10}-", size - 10, size),
        ("bytes=-700000", size - 700_000, size),
        ("bytes=65535-65537", 65535, 65538),
        (f"bytes=10-{size + 5}", 10, size),
    ):
        part = browser.get(link, headers={"Range": asked})
        assert part.status_code == 206, asked
        assert part.data == CONTENT[start:end], asked
        assert part.headers["Content-Range"] == f"bytes {start}-{end - 1}/{size}"
        assert part.content_length == end - start
    problem(browser.get(link, headers={"Range": f"bytes={size}-"}), 416)
    tag = whole.headers["ETag"]
    assert browser.get(link, headers={"Range": "bytes=0-4", "If-Range": tag}).status_code == 206
    assert browser.get(link, headers={"Range": "bytes=0-4", "If-Range": '"another"'}).data == CONTENT
    assert browser.get(link, headers={"If-None-Match": tag}).status_code == 304
    head = browser.head(link)
    assert (head.status_code, head.content_length, head.data) == (200, size, b"")


def test_beyond_the_bound_a_reader_is_asked_to_come_again(visitor: tuple[FlaskClient, str, BigAnswers]) -> None:
    browser, link, under_way = visitor
    readers = [browser.get(link, buffered=False) for _ in range(BIG_ANSWERS_EACH)]
    assert under_way.under_way == BIG_ANSWERS_EACH
    refused = browser.get(link)
    assert "try again" in problem(refused, 503)
    assert refused.headers["Retry-After"] == str(BIG_RETRY_S)
    assert browser.get(link.replace("fitted.ply", "result.json")).status_code == 200  # small ones are not counted
    readers.pop().close()
    assert browser.get(link).data == CONTENT
    for reader in readers:
        assert reader.data == CONTENT
        reader.close()


def test_the_addresses_of_one_house_share_its_places(visitor: tuple[FlaskClient, str, BigAnswers]) -> None:
    browser, link, under_way = visitor
    places = []
    for number in range(BIG_ANSWERS_EACH):
        leave = under_way.take(f"share {number}", "2001:db8:1:2::/64")
        assert leave is not None
        places.append(leave)
    problem(browser.get(link, environ_base={"REMOTE_ADDR": "2001:db8:1:2:ffff::9"}), 503)
    assert browser.get(link, environ_base={"REMOTE_ADDR": "2001:db8:1:3::9"}).data == CONTENT
    for leave in places:
        leave()


def test_nothing_of_the_file_is_in_memory_before_it_is_read(visitor: tuple[FlaskClient, str, BigAnswers]) -> None:
    browser, link, _ = visitor
    with browser.get(link, buffered=False) as reader:
        pieces = [len(piece) for piece in reader.iter_encoded()]
    assert max(pieces) <= 2**16
    assert sum(pieces) == len(CONTENT)


@pytest.mark.slow
def test_a_file_that_is_deleted_before_it_is_opened_is_not_there(
    visitor: tuple[FlaskClient, str, BigAnswers], monkeypatch: pytest.MonkeyPatch
) -> None:
    browser, link, _ = visitor
    opened = Path.open

    def gone(path: Path, *mode: Any, **more: Any) -> object:
        if path.name == "fitted.ply":
            raise FileNotFoundError
        return opened(path, *mode, **more)

    with monkeypatch.context() as deleted:
        deleted.setattr(Path, "open", gone)
        answer = browser.get(link)
    assert "deleted" in problem(answer, 404)


def test_places_are_bounded_for_a_share_for_an_address_and_in_all() -> None:
    answers = BigAnswers()
    of_share = [answers.take("A", f"10.0.0.{number}") for number in range(BIG_ANSWERS_EACH + 1)]
    assert [place is not None for place in of_share] == [True] * BIG_ANSWERS_EACH + [False]
    of_address = [answers.take(f"share {number}", "10.0.9.9") for number in range(BIG_ANSWERS_EACH + 1)]
    assert [place is not None for place in of_address] == [True] * BIG_ANSWERS_EACH + [False]
    rest = [answers.take(f"other {number}", f"10.0.8.{number}") for number in range(BIG_ANSWERS)]
    assert sum(place is not None for place in rest) == BIG_ANSWERS - 2 * BIG_ANSWERS_EACH
    assert answers.under_way == BIG_ANSWERS
    assert of_share[0] is not None
    of_share[0]()
    assert answers.under_way == BIG_ANSWERS - 1
    assert answers.take("A", "10.0.7.7") is not None


@pytest.mark.slow
@pytest.mark.parametrize("end", ["revoked", "closed", "scan deleted", "patient deleted"])
def test_a_download_under_way_ends_with_the_link(
    visitor: tuple[FlaskClient, str, BigAnswers],
    client: FlaskClient,
    scan_id: str,
    fit_id: str,
    end: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(big_answers, "STILL_OPEN_S", 0.0)
    browser, link, under_way = visitor
    patient = client.get(f"/api/scans/{scan_id}").json["patient"]
    with browser.get(link, buffered=False) as reader:
        pieces = reader.iter_encoded()
        assert CONTENT.startswith(next(pieces))
        if end == "closed":
            browser.post(link.replace("fitted.ply", "close"))
        else:
            ended = {"scan deleted": f"/api/scans/{scan_id}", "patient deleted": f"/api/patients/{patient}"}
            client.delete(ended.get(end, f"/api/fits/{fit_id}/shares/{link.split('/')[3]}"))
        with pytest.raises(ConnectionAbortedError):
            next(pieces)
    assert under_way.under_way == 0


def test_whether_a_reader_may_go_on_is_asked_now_and_then(monkeypatch: pytest.MonkeyPatch) -> None:
    now, asked = [100.0], []
    monkeypatch.setattr(big_answers.time, "monotonic", lambda: now[0])
    file = WhileOpen(BytesIO(CONTENT), lambda: bool(asked.append(now[0])) or len(asked) < 2)
    for _ in range(100):
        file.read(1)
    assert asked == []
    for _ in range(10):
        now[0] += STILL_OPEN_S / 8
        file.read(1)
    assert len(asked) == 1
    now[0] += STILL_OPEN_S
    with pytest.raises(ConnectionAbortedError):
        file.read(1)

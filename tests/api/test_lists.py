"""The lists of all scans and all fits: page by page, as each is answered alone, by a number of queries that stays."""

import io
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from flask.testing import FlaskClient
from helpers.problems import problem
from helpers.stored_fits import add_waiting_fit, named
from helpers.waiting import ended

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.service.service import Service
from breastrig.storage.documents.scans import add_scan, get_scan
from breastrig.storage.storage import Storage


@contextmanager
def queries(service: Service) -> Iterator[list[str]]:
    """What the database is asked meanwhile."""
    asked: list[str] = []

    real = service.storage.index.asked

    def listen(question: Callable[..., object], *given: object) -> object:
        asked.append(str(question))
        return real(question, *given)

    service.storage.index.asked = listen
    try:
        yield asked
    finally:
        service.storage.index.asked = real


def pages(client: FlaskClient, address: str | None, what: str) -> list[list[str]]:
    """The ids of each page, to the last one."""
    found = []
    while address is not None:
        page = client.get(address).json
        found.append([one["id"] for one in page[what]])
        address = page["next"]
    return found


@pytest.fixture
def upload(client: FlaskClient, torso: bytes) -> Iterator[Callable[[], str]]:
    scans: list[str] = []

    def add() -> str:
        scans.append(client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json["id"])
        return scans[-1]

    yield add
    for scan in scans:
        client.delete(f"/api/scans/{scan}")


@pytest.mark.slow
def test_all_scans_are_listed_page_by_page_the_newest_first(
    client: FlaskClient, service: Service, upload: Callable[[], str]
) -> None:
    first = upload()
    stored = get_scan(service.storage, first)
    patient = client.get(f"/api/scans/{first}").json["patient"]
    same_moment = [named(f"{letter}-of-one-moment") for letter in "bac"]
    for scan in same_moment:  # uploads of one millisecond
        add_scan(service.storage, replace(stored, id=scan, created_at="2999-01-01T00:00:00.000Z"), patient, again=True)
    try:
        found = pages(client, "/api/scans?limit=2", "scans")
        assert [len(page) for page in found[:-1]] == [2] * (len(found) - 1)
        ids = [scan for page in found for scan in page]
        assert ids[:3] == sorted(same_moment, reverse=True)
        assert len(ids) == len(set(ids))
        assert first in ids
        listed = client.get("/api/scans").json["scans"]
        assert [scan["id"] for scan in listed] == ids
        assert listed == [client.get(f"/api/scans/{scan}").json for scan in ids]
        assert [scan["created_at"] for scan in listed] == sorted((one["created_at"] for one in listed), reverse=True)
        after = client.get("/api/scans?limit=2").json["next"]
        client.delete(f"/api/scans/{ids[1]}")  # where the next page goes on from
        assert pages(client, after, "scans")[0] == ids[2:4]
    finally:
        for scan in same_moment:
            client.delete(f"/api/scans/{scan}")


@pytest.mark.parametrize("wrong", ["limit=0", "limit=201", "after=", "after=yesterday", "after=2026~%00", "before=3"])
def test_a_place_that_no_list_has_named_is_refused(client: FlaskClient, wrong: str) -> None:
    assert wrong.partition("=")[0] in problem(client.get(f"/api/scans?{wrong}"), 422)


@pytest.mark.slow
def test_all_fits_are_listed_page_by_page_the_newest_first(
    client: FlaskClient, service: Service, upload: Callable[[], str]
) -> None:
    fits = [client.post("/api/fits", json={"scan": upload()}).json["id"] for _ in range(3)]
    for fit in fits:
        ended(service, fit)
    found = pages(client, "/api/fits?limit=2", "fits")
    assert [fit for page in found for fit in page][:3] == fits[::-1]
    assert [len(page) for page in found[:-1]] == [2] * (len(found) - 1)
    listed = client.get("/api/fits?limit=3").json["fits"]
    assert listed == [client.get(f"/api/fits/{fit}").json for fit in fits[::-1]]
    problem(client.get("/api/fits?limit=0"), 422)


@pytest.mark.slow
def test_a_page_asks_no_more_than_twice_for_each_row(
    config: Config, service: Service, scan_id: str, tmp_path: Path
) -> None:
    """Of a service without workers, where fits wait."""
    stored = get_scan(service.storage, scan_id)
    idle = Service(Storage(tmp_path / "data"), model=config.model)
    idle.storage.prepare()
    client = create_app(config, idle).test_client()
    for number in range(6):
        add_scan(idle.storage, replace(stored, id=named(f"scan-{number}")))
        add_waiting_fit(idle.storage, named("scan-0"), named(f"fit-{number}"))
    for address in ("/api/scans", "/api/fits", f"/api/scans/{named('scan-0')}/fits"):
        for limit in (1, 3, 6):
            with queries(idle) as asked:
                assert client.get(f"{address}?limit={limit}").status_code == 200
            assert len(asked) <= 4 + 2 * limit, (address, limit, asked)  # each row is looked up, none is searched for
    positions = [fit["queue_position"] for fit in client.get("/api/fits?limit=4").json["fits"]]
    assert positions == [6, 5, 4, 3]
    idle.storage.close()

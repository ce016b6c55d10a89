import io
import json
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from flask.testing import FlaskClient
from helpers import fake_fit
from helpers.on_disk import bytes_below
from helpers.problems import problem
from helpers.stored_fits import fit_ids
from helpers.toy_rig import toy_rig
from helpers.waiting import ended, until

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.cases.documents import FitDocument
from breastrig.execution.limits import FitLimits
from breastrig.gltf.pose_nodes import posed_by_nodes
from breastrig.service.service import Service
from breastrig.storage.documents.fits import Once, get_fit
from breastrig.storage.storage import Storage, utc_now

pytestmark = pytest.mark.long

PERSONAL = "no-store"


def test_a_fit_is_accepted_executed_and_described(client: FlaskClient, service: Service, scan_id: str) -> None:
    answer = client.post("/api/fits", json={"scan": scan_id, "drawing": "lumpectomy", "stance": "supine"})
    assert answer.status_code == 202
    fit_id, links = answer.json["id"], answer.json["links"]
    assert answer.headers["Location"] == links["self"] == f"/api/fits/{fit_id}"
    ended(service, fit_id)
    fit = client.get(links["self"]).json
    assert fit == {
        "id": fit_id,
        "scan": scan_id,
        "state": "done",
        "queue_position": None,
        "created_at": fit["created_at"],
        "stance": "supine",
        "asked_stance": "supine",
        "preset": "default",
        "drawing": "lumpectomy",
        "refine": True,
        "cuts": "",
        "start_from": None,
        "predicted_from": None,
        "landmarks": {},
        "certain": [],
        "last_event": 6,
        "iterations": 4,
        "numbers": {
            "iteration": 3,
            "stage": "all",
            "energy": 7.0,
            "mean_distance_mm": 2.0,
            "landmark_distance_mm": None,
            "coverage": 0.9,
            "elapsed_s": 0.03,
        },
        "reason": None,
        "links": links,
    }


def test_landmarks_come_from_the_scan_unless_they_are_given(
    client: FlaskClient, service: Service, scan_id: str
) -> None:
    stored, given = {"nipple_L": [70.0, 350.0, 120.0]}, {"nipple_R": [-70.0, 350.0, 120.0]}
    client.put(f"/api/scans/{scan_id}/landmarks", json={"landmarks": stored})
    for body, expected in (({}, stored), ({"landmarks": given}, given), ({"landmarks": {}}, {})):
        answer = client.post("/api/fits", json={"scan": scan_id, "drawing": None, **body})
        ended(service, answer.json["id"])
        assert client.get(answer.json["links"]["result"]).json["landmarks_given"] == expected


def test_certain_picks_come_from_the_scan_unless_the_request_brings_its_own(
    client: FlaskClient, service: Service, scan_id: str
) -> None:
    stored = {"nipple_L": [70.0, 350.0, 120.0], "nipple_R": [-70.0, 350.0, 120.0]}
    client.put(f"/api/scans/{scan_id}/landmarks", json={"landmarks": stored, "certain": ["nipple_L"]})
    for body, expected in (
        ({}, ["nipple_L"]),
        ({"certain": []}, []),
        ({"certain": ["nipple_R"]}, ["nipple_R"]),
        ({"landmarks": stored}, []),
        ({"landmarks": stored, "certain": ["nipple_R"]}, ["nipple_R"]),
    ):
        answer = client.post("/api/fits", json={"scan": scan_id, "drawing": None, **body})
        ended(service, answer.json["id"])
        assert client.get(answer.json["links"]["result"]).json["certain"] == expected


def test_what_only_repeats_a_proposal_keeps_its_confidence(client: FlaskClient, service: Service, scan_id: str) -> None:
    """Stored or brought; 1 says that somebody has looked, and a moved one is a person's own."""
    client.get(f"/api/scans/{scan_id}/landmarks/proposed")
    there, moved = {"nipple_L": [70.0, 350.0, 120.0]}, {"nipple_L": [70.0, 350.5, 120.0]}
    client.put(f"/api/scans/{scan_id}/landmarks", json={"landmarks": there})
    for body, expected in (
        ({}, {"nipple_L": 0.5}),
        ({"confidence": {"nipple_L": 1.0}}, {"nipple_L": 1.0}),
        ({"certain": ["nipple_L"], "confidence": {}}, {}),
        ({"landmarks": there}, {"nipple_L": 0.5}),
        ({"landmarks": moved}, {}),
        ({"landmarks": moved, "confidence": {"nipple_L": 0.3}}, {"nipple_L": 0.3}),
    ):
        answer = client.post("/api/fits", json={"scan": scan_id, "drawing": None, **body})
        assert answer.status_code == 202, answer.json
        ended(service, answer.json["id"])
        assert client.get(answer.json["links"]["result"]).json["confidence"] == expected


def test_a_fit_follows_the_skin_unless_it_is_asked_not_to(client: FlaskClient, service: Service, scan_id: str) -> None:
    for asked, refine in (({}, True), ({"refine": True}, True), ({"refine": False}, False)):
        links = client.post("/api/fits", json={"scan": scan_id, "drawing": None, **asked}).json["links"]
        ended(service, links["self"].rsplit("/", 1)[1])
        assert client.get(links["self"]).json["refine"] is refine
        assert client.get(links["result"]).json["refined"] is refine


NO_FITS: list[tuple[dict[str, object], str]] = [
    ({"refine": "perhaps"}, "refine: Input should be a valid boolean."),
    ({"preset": "best"}, '"best" is not a preset; known are: default, paper.'),
    ({"drawing": "lumpectomy+tumour:L,13,45,12"}, "clock of tumour cannot be 13: an hour of the clock"),
    ({"drawing": "mona_lisa"}, '"mona_lisa" is not a drawing of this model; known are: lumpectomy, reduction, '),
    ({"landmarks": {"elbow": [0, 0, 0]}}, '"elbow" is not a landmark'),
    ({"landmarks": {"nipple_L": [0, 0, 9000]}}, "nipple_L lies"),
    ({"landmarks": {}, "certain": ["nipple_L"]}, '"certain" names nipple_L, which is not among these landmarks'),
    ({"landmarks": {}, "confidence": {"nipple_L": 0.5}}, '"confidence" names nipple_L, which is not among these'),
    ({"confidence": {"nipple_L": 2}}, "confidence.nipple_L: "),
    ({"colour": "red"}, "colour: Extra inputs are not permitted."),
]


def test_a_fit_that_cannot_be_meant_is_refused(client: FlaskClient, scan_id: str) -> None:
    for body, word in NO_FITS:
        assert word in problem(client.post("/api/fits", json={"scan": scan_id, "drawing": None, **body}), 422)


@pytest.mark.slow
def test_a_fit_goes_on_only_from_one_of_its_own_scan_that_is_done(
    client: FlaskClient, service: Service, torso: bytes, scan_id: str, fit_id: str
) -> None:
    other = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json["id"]

    def ask(**body: object):
        return client.post("/api/fits", json={"drawing": None, **body})

    assert "same scan" in problem(ask(scan=other, start_from=fit_id), 422)
    assert "no such fit" in problem(ask(scan=scan_id, start_from="nobody"), 404)
    assert "with: Extra inputs are not permitted." in problem(ask(scan=scan_id, **{"with": {"scan": other}}), 422)
    client.delete(f"/api/scans/{other}")
    running = ask(scan=scan_id, preset="paper").json["id"]  # one that takes its time
    assert "one that is done" in problem(ask(scan=scan_id, start_from=running), 409)
    client.post(f"/api/fits/{running}/cancel")
    assert "that one is cancelled" in problem(ask(scan=scan_id, start_from=running), 409)
    went_on = ask(scan=scan_id, start_from=fit_id)
    assert went_on.status_code == 202
    assert ended(service, went_on.json["id"]).start_from == fit_id


@pytest.mark.slow
def test_the_fits_of_a_scan_are_listed_page_by_page(client: FlaskClient, service: Service, scan_id: str) -> None:
    body = {"scan": scan_id, "drawing": None}
    ids = [client.post("/api/fits", json=body).json["id"] for _ in range(5)]
    for fit_id in ids:
        ended(service, fit_id)
    address = client.get(f"/api/scans/{scan_id}").json["links"]["fits"]
    assert client.get(address).json == {"fits": [client.get(f"/api/fits/{i}").json for i in ids[::-1]], "next": None}
    found, sizes, address = [], [], f"{address}?limit=2"
    while address:
        page = client.get(address).json
        found += [fit["id"] for fit in page["fits"]]
        sizes.append(len(page["fits"]))
        address = page["next"]
    assert (found, sizes) == (ids[::-1], [2, 2, 1])
    assert len(client.get(f"/api/scans/{scan_id}/fits?limit=5").json["fits"]) == 5
    assert client.get(f"/api/scans/{scan_id}/fits?limit=5").json["next"] is None
    problem(client.get(f"/api/scans/{scan_id}/fits?limit=0"), 422)
    problem(client.get("/api/scans/nobody/fits"), 404)


@pytest.mark.slow
def test_a_request_that_is_sent_again_with_its_key_starts_no_second_fit(
    client: FlaskClient, service: Service, scan_id: str
) -> None:
    def ask(key: str | None, **more: object):
        headers = {} if key is None else {"Idempotency-Key": key}
        return client.post("/api/fits", json={"scan": scan_id, "drawing": None, **more}, headers=headers)

    first = ask("a-key")
    ended(service, first.json["id"])
    client.put(f"/api/scans/{scan_id}/landmarks", json={"landmarks": {"nipple_L": [70.0, 350.0, 120.0]}})
    again = ask("a-key", stance="auto")  # a default that is spelt out is the same request
    assert (again.status_code, again.json) == (202, first.json)
    assert "another request" in problem(ask("a-key", stance="supine"), 422)
    others = [ask("another-key"), ask(None), ask(None)]
    assert len({answer.json["id"] for answer in (first, *others)}) == 4
    assert len(list(service.storage.root.rglob("fit.json"))) == len(fit_ids(service.storage))
    for answer in others:
        ended(service, answer.json["id"])
    assert b"a-key" not in bytes_below(service.storage.root)


@pytest.mark.slow
def test_a_key_is_forgotten_with_its_fit(client: FlaskClient, service: Service, torso: bytes) -> None:
    ids = []
    for _ in range(2):
        scan = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json["id"]
        answer = client.post("/api/fits", json={"scan": scan, "drawing": None}, headers={"Idempotency-Key": "k"})
        assert answer.status_code == 202
        ids.append(answer.json["id"])
        client.delete(f"/api/scans/{scan}")
    assert ids[0] != ids[1]


@pytest.mark.slow
def test_many_threads_with_one_key_get_one_fit(client: FlaskClient, service: Service, scan_id: str) -> None:
    asked, once = FitDocument(asked_at=utc_now()), Once.of("key", "request")
    with ThreadPoolExecutor(8) as threads:
        made = set(threads.map(lambda _: service.add_fit(scan_id, asked, once=once), range(16)))
    assert len(made) == 1
    ended(service, made.pop())


def test_a_key_that_is_none_is_refused(client: FlaskClient, scan_id: str) -> None:
    for key in ("", "a b", "x" * 256, "é"):
        answer = client.post("/api/fits", json={"scan": scan_id, "drawing": None}, headers={"Idempotency-Key": key})
        assert "Idempotency-Key" in problem(answer, 400)


def test_a_fit_of_no_scan_is_refused(client: FlaskClient) -> None:
    assert "no such scan" in problem(client.post("/api/fits", json={"scan": "nobody"}), 404)
    assert "scan: Field required" in problem(client.post("/api/fits", json={}), 422)


FILES = {
    "result.json": "application/json",
    "fitted.glb": "model/gltf-binary",
    "fitted.ply": "application/octet-stream",
    "drawing.json": "application/json",
    "distances.bin": "application/octet-stream",
    "uncertainty.bin": "application/octet-stream",
}


def test_results_are_files_with_an_etag_that_the_browser_may_keep(
    client: FlaskClient, service: Service, fit_id: str
) -> None:
    for name, media_type in FILES.items():
        answer = client.get(f"/api/fits/{fit_id}/{name}")
        assert answer.status_code == 200
        assert answer.data == (service.storage.files.fit(fit_id) / name).read_bytes()
        assert (answer.mimetype, answer.headers["Cache-Control"]) == (media_type, PERSONAL)
        said = answer.headers["Content-Disposition"]
        assert re.fullmatch(
            rf"attachment; filename=[A-Z0-9]{{3}}-[A-Z0-9]{{3}}_standing_[-0-9]{{10}}_{re.escape(name)}", said
        )
        again = client.get(f"/api/fits/{fit_id}/{name}", headers={"If-None-Match": answer.headers["ETag"]})
        assert (again.status_code, again.data) == (304, b"")


@pytest.mark.slow
def test_what_a_browser_has_kept_is_worth_nothing_after_delete(
    client: FlaskClient, service: Service, scan_id: str, fit_id: str
) -> None:
    fit = f"/api/fits/{fit_id}"
    places = [f"{fit}/{name}" for name in ("result.json", "fitted.glb", "fitted.ply", "drawing.json", "distances.bin")]
    places += [f"{fit}/iterations/0.gltf", f"/api/scans/{scan_id}/mesh.glb"]
    kept = {place: client.get(place).headers["ETag"] for place in places}
    client.delete(f"/api/scans/{scan_id}")
    for place, tag in kept.items():
        problem(client.get(place, headers={"If-None-Match": tag}), 404)
    assert not service.storage.files.fit(fit_id).exists()


def test_a_range_beyond_the_end_is_refused(client: FlaskClient, fit_id: str) -> None:
    for place in ("fitted.glb", "iterations/0.gltf"):
        answer = client.get(f"/api/fits/{fit_id}/{place}", headers={"Range": "bytes=90000000-"})
        assert "range" in problem(answer, 416)


def test_an_iteration_is_a_complete_gltf_of_what_the_event_said(client: FlaskClient, fit_id: str) -> None:
    answer = client.get(f"/api/fits/{fit_id}/iterations/2.gltf")
    assert (answer.status_code, answer.mimetype) == (200, "model/gltf+json")
    assert answer.headers["Cache-Control"] == PERSONAL
    document = json.loads(answer.data)
    shared = [buffer for buffer in document["buffers"] if not buffer["uri"].startswith("data:")]
    assert len(shared) == 2  # the model's and the drawing's; what depends on the pose lies in the file itself
    for buffer in shared:
        assert len(client.get(buffer["uri"]).data) == buffer["byteLength"]
    events = client.get(f"/api/fits/{fit_id}/events.json").json["events"]
    moved = {node["name"]: node for node in events[3]["event"]["nodes"]}
    nodes = {node.get("name"): node for node in document["nodes"]}
    assert set(moved) <= set(nodes)
    for name, node in moved.items():
        for key in ("translation", "rotation", "scale", "weights"):
            if key in node and key in nodes[name]:
                assert np.allclose(node[key], nodes[name][key], atol=1e-6), (name, key)
    again = client.get(f"/api/fits/{fit_id}/iterations/2.gltf", headers={"If-None-Match": answer.headers["ETag"]})
    assert again.status_code == 304


def test_the_parameters_behind_an_event_are_found_again() -> None:
    expected = fake_fit.parameters_at(3)
    found = posed_by_nodes(toy_rig(), [node.model_dump() for node in fake_fit.iterated(3).nodes])
    for field in ("rotations", "translations", "scales", "weights"):
        assert np.allclose(getattr(found, field), getattr(expected, field), atol=1e-6)


def test_an_iteration_that_is_not_there_is_not_found(client: FlaskClient, fit_id: str) -> None:
    assert "it has 4 so far" in problem(client.get(f"/api/fits/{fit_id}/iterations/4.gltf"), 404)
    problem(client.get(f"/api/fits/{fit_id}/iterations/{10**30}.gltf"), 404)
    problem(client.get(f"/api/fits/{fit_id}/iterations/-1.gltf"), 404)
    problem(client.get("/api/fits/nobody/iterations/0.gltf"), 404)


def test_a_running_fit_has_no_results_and_can_be_cancelled(client: FlaskClient, service: Service, scan_id: str) -> None:
    fit_id = client.post("/api/fits", json={"scan": scan_id, "preset": "paper", "drawing": None}).json["id"]
    until(lambda: get_fit(service.storage, fit_id).iterations > 0, "an iteration")
    assert "still running" in problem(client.get(f"/api/fits/{fit_id}/result.json"), 409)
    assert client.get(f"/api/fits/{fit_id}/iterations/0.gltf").status_code == 200
    answer = client.post(f"/api/fits/{fit_id}/cancel")
    assert (answer.status_code, answer.json["state"]) == (202, "cancelled")
    assert answer.json["reason"] == "The fit was cancelled."
    assert client.post(f"/api/fits/{fit_id}/cancel").status_code == 202
    assert "it is cancelled" in problem(client.get(f"/api/fits/{fit_id}/result.json"), 409)


def test_a_fit_that_is_done_is_not_cancelled(client: FlaskClient, fit_id: str) -> None:
    assert "it is done" in problem(client.post(f"/api/fits/{fit_id}/cancel"), 409)


def test_unknown_fits_are_not_found(client: FlaskClient) -> None:
    for place in ("", "/events", "/events.json", "/result.json", "/fitted.glb", "/fitted.ply", "/drawing.json"):
        assert "no such fit" in problem(client.get(f"/api/fits/nobody{place}"), 404)
    problem(client.post("/api/fits/nobody/cancel"), 404)


@pytest.mark.slow
def test_a_waiting_fit_says_its_place_and_too_many_are_refused_for_a_while(
    config: Config, model: Path, tmp_path: Path, torso: bytes
) -> None:
    service = Service(
        Storage(tmp_path / "data"),
        runner=fake_fit.patient,
        model=model,
        fits=FitLimits(workers=1, grace_s=0.1, waiting_per_client=2),
    )
    with service.started():
        client = create_app(config, service).test_client()
        scan = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json["id"]
        body = {"scan": scan, "drawing": None}
        running = client.post("/api/fits", json=body).json["links"]
        until(lambda: client.get(running["self"]).json["state"] == "running", "the first to run")
        assert client.get(running["self"]).json["queue_position"] is None
        places = [client.post("/api/fits", json=body).json["links"] for _ in range(2)]
        assert [client.get(links["self"]).json["queue_position"] for links in places] == [1, 2]
        refused = client.post("/api/fits", json=body)
        assert "are waiting already" in problem(refused, 429)
        assert int(refused.headers["Retry-After"]) > 0
        with client.get(places[1]["events"]) as stream:
            first = next(stream.iter_encoded())  # all that is known is sent at once
            assert first == b'retry: 1000\n\nevent: queued\ndata: {"kind":"queued","position":2}\n\n'

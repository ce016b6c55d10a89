"""What shows nobody is sent compressed to those who take it; what shows a patient is not."""

import gzip

from flask.testing import FlaskClient

from breastrig.api.config import Config

TAKES = {"Accept-Encoding": "br, gzip"}


def test_the_model_is_compressed_for_those_who_take_it(client: FlaskClient, config: Config) -> None:
    glb = config.model.read_bytes()
    plain = client.get("/api/models/torso.glb")
    answer = client.get("/api/models/torso.glb", headers=TAKES)
    assert plain.data == glb
    assert "Content-Encoding" not in plain.headers
    assert answer.headers["Content-Encoding"] == "gzip"
    assert gzip.decompress(answer.data) == glb
    assert len(answer.data) < len(glb)
    assert answer.headers["ETag"] != plain.headers["ETag"]
    for one in (plain, answer):
        assert "Accept-Encoding" in one.headers["Vary"]
    again = client.get("/api/models/torso.glb", headers=TAKES | {"If-None-Match": answer.headers["ETag"]})
    assert again.status_code == 304


def test_a_range_is_of_the_file_itself(client: FlaskClient, config: Config) -> None:
    part = client.get("/api/models/torso.glb", headers=TAKES | {"Range": "bytes=4-11"})
    assert (part.status_code, part.data) == (206, config.model.read_bytes()[4:12])
    assert "Content-Encoding" not in part.headers


def test_what_a_client_refuses_it_does_not_get(client: FlaskClient) -> None:
    answer = client.get("/api/models/torso.glb", headers={"Accept-Encoding": "gzip;q=0"})
    assert "Content-Encoding" not in answer.headers


def test_a_patients_files_are_sent_as_they_are(client: FlaskClient, scan_id: str, fit_id: str) -> None:
    for place in (f"/api/scans/{scan_id}/mesh.glb", f"/api/fits/{fit_id}/result.json", f"/api/fits/{fit_id}"):
        assert "Content-Encoding" not in client.get(place, headers=TAKES).headers


def test_small_files_are_not_worth_it(client: FlaskClient) -> None:
    assert "Content-Encoding" not in client.get("/assets/index-abc123.js", headers=TAKES).headers

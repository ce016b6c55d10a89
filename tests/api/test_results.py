"""A fit's files, alone and in one; what is sent of them ends with the scan."""

import errno
import io
import zipfile
from pathlib import Path

import pytest
from flask.testing import FlaskClient
from helpers.problems import problem
from helpers.waiting import until

from breastrig.api import big_answers
from breastrig.api.share_limits import BIG_BYTES
from breastrig.files.result import FIT_FILES
from breastrig.gltf.read_rig import read_rig
from breastrig.service.service import Service
from breastrig.use.folder.fit_folder import read_fit_folder

CONTENT = bytes(range(256)) * (BIG_BYTES // 256 + 1)
WITHOUT_ADDRESS = {"scan.ply", "fit.log.jsonl"}


def unzipped(content: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(content)) as packed:
        assert packed.testzip() is None
        return {name: packed.read(name) for name in packed.namelist()}


@pytest.mark.slow
def test_the_zip_has_every_file_as_its_own_address_answers_it(
    client: FlaskClient, service: Service, fit_id: str, model: Path, tmp_path: Path
) -> None:
    fit = client.get(f"/api/fits/{fit_id}").json
    scan = client.get(f"/api/scans/{fit['scan']}").json
    answer = client.get(fit["links"]["result_zip"])
    assert (answer.status_code, answer.mimetype) == (200, "application/zip")
    assert answer.headers["Cache-Control"] == "no-store"
    named = f"{scan['patient_code']}_standing_{scan['created_at'][:10]}_result.zip"
    assert answer.headers["Content-Disposition"] == f"attachment; filename={named}"
    files = unzipped(answer.data)
    stored = {file.name for file in service.storage.files.fit(fit_id).iterdir()}
    assert list(files) == [name for name in (*FIT_FILES, "plan.json") if name in stored | {"plan.json"}]
    for name in files.keys() - WITHOUT_ADDRESS:
        assert files[name] == client.get(f"/api/fits/{fit_id}/{name}").data, name
    assert client.get(fit["links"]["result_zip"]).data == answer.data
    assert answer.content_length == len(answer.data) == client.head(fit["links"]["result_zip"]).content_length
    part = client.get(fit["links"]["result_zip"], headers={"Range": "bytes=10-19", "If-Range": answer.headers["ETag"]})
    assert (part.status_code, part.data) == (206, answer.data[10:20])
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    assert read_fit_folder(tmp_path, model).rig.sha256 == read_rig(model).sha256


def test_results_are_sent_in_parts_and_as_heads(client: FlaskClient, fit_id: str) -> None:
    links = client.get(f"/api/fits/{fit_id}").json["links"]
    for name in ("result", "fitted_glb", "distances"):
        place = links[name]
        whole = client.get(place)
        assert (whole.status_code, whole.headers["Accept-Ranges"]) == (200, "bytes")
        part = client.get(place, headers={"Range": "bytes=3-7"})
        assert (part.status_code, part.data) == (206, whole.data[3:8])
        assert part.headers["Content-Range"] == f"bytes 3-7/{len(whole.data)}"
        last = client.get(place, headers={"Range": "bytes=-4", "If-Range": whole.headers["ETag"]})
        assert (last.status_code, last.data) == (206, whole.data[-4:])
        assert client.get(place, headers={"Range": f"bytes={len(whole.data)}-"}).status_code == 416
        head = client.head(place)
        assert (head.status_code, head.content_length, head.data) == (200, len(whole.data), b"")
    told = client.get(links["events"] + ".json").json["events"][-1]["event"]["result"]
    assert client.get(links["result"]).json == told


def test_files_that_cannot_be_reached_for_now_give_503(
    client: FlaskClient, service: Service, fit_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(*_asked: object) -> None:
        raise OSError(errno.EIO, "the disk does not answer")

    monkeypatch.setattr(service.storage.files, "find", gone)
    answer = client.get(f"/api/fits/{fit_id}/result.json")
    monkeypatch.undo()
    assert (answer.status_code, answer.headers["Retry-After"]) == (503, "10")
    assert problem(answer, 503) == "The service cannot reach its files at the moment; try again later."


@pytest.mark.slow
def test_a_fit_without_results_has_no_zip(client: FlaskClient, scan_id: str) -> None:
    links = client.post("/api/fits", json={"scan": scan_id, "preset": "paper"}).json["links"]
    assert "its results come when it is done" in problem(client.get(links["result_zip"]), 409)
    client.post(links["cancel"])
    until(lambda: client.get(links["self"]).json["state"] == "cancelled", "its end")
    assert "it is cancelled" in problem(client.get(links["result_zip"]), 409)
    problem(client.get("/api/fits/nobody/result.zip"), 404)


@pytest.mark.slow
def test_a_zip_of_a_fit_that_is_deleted_meanwhile_is_not_there(
    client: FlaskClient, fit_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(_path: Path, *_mode: str, **_more: object) -> None:
        raise FileNotFoundError

    with monkeypatch.context() as deleted:
        deleted.setattr(Path, "open", gone)
        answer = client.get(f"/api/fits/{fit_id}/result.zip")
    assert "deleted" in problem(answer, 404)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("what", "deleted"),
    [("fits/{fit}/fitted.ply", "patient"), ("fits/{fit}/result.zip", "scan"), ("scans/{scan}/mesh.glb", "scan")],
)
def test_the_owners_download_under_way_ends_when_the_scan_is_deleted(
    client: FlaskClient,
    service: Service,
    scan_id: str,
    fit_id: str,
    what: str,
    deleted: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(big_answers, "STILL_OPEN_S", 0.0)
    patient = client.get(f"/api/scans/{scan_id}").json["patient"]
    (service.storage.files.fit(fit_id) / "fitted.ply").write_bytes(CONTENT)
    (service.storage.files.scan(scan_id) / "mesh.glb").write_bytes(CONTENT)
    address = f"/api/{what.format(fit=fit_id, scan=scan_id)}"
    whole = client.get(address).data
    with client.get(address, buffered=False) as reader:
        pieces = reader.iter_encoded()
        assert whole.startswith(next(pieces))
        client.delete(f"/api/scans/{scan_id}" if deleted == "scan" else f"/api/patients/{patient}")
        with pytest.raises(ConnectionAbortedError):
            next(pieces)

"""Fits outlive the model that they were made with: after a restart with another one all that was answered still is."""

import json
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from flask.testing import FlaskClient
from helpers.remembered_fits import run_fit_once
from helpers.toy_rig import toy_rig
from helpers.waiting import ended

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.execution.limits import FitLimits
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.service.kept_models import KeptModels
from breastrig.service.service import Service
from breastrig.storage.storage import Storage
from breastrig.use.values.model import load_model
from breastrig_studies.output.rig_files import write_rig


@contextmanager
def serving(root: Path, model: Path | None) -> Iterator[tuple[Service, FlaskClient]]:
    service = Service(Storage(root), runner=run_fit_once, model=model, fits=FitLimits(workers=1, grace_s=0.1))
    with service.started():
        yield service, create_app(Config(model=model), service).test_client()


@pytest.fixture(scope="module")
def toy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("model")
    write_rig(toy_rig(), folder)
    return folder / "toy.glb"


@pytest.mark.slow
def test_all_of_a_fit_is_answered_after_a_restart_with_another_model(tmp_path: Path, toy: Path) -> None:
    with serving(tmp_path, None) as (service, client):
        scan = client.post("/api/examples/standing").json
        picked = scan["example_landmarks"]["landmarks"]
        fit = client.post("/api/fits", json={"scan": scan["id"], "landmarks": picked}).json
        assert ended(service, fit["id"]).state == "done"
        tumour = {"id": "t", "kind": "tumour", "side": "L", "clock": 10, "distance_mm": 40, "radius_mm": 15}
        plan = {"schema": "breastrig/plan@1", "unit": "mm", "items": [tumour | {"scan": scan["id"]}]}
        place = f"/api/patients/{scan['patient']}/plan"
        seen = {"If-Match": client.get(place).headers["ETag"]}
        assert client.put(place, json=plan, headers=seen).status_code == 200
        first = f"{fit['links']['self']}/iterations/1.gltf"
        own = read_rig(default_rig_path()).sha256
        asked = [
            *(("GET", fit["links"][name], None) for name in ("result", "plan", "measures", "fitted_glb")),
            ("GET", first, None),
            ("GET", json.loads(client.get(first).data)["buffers"][0]["uri"], None),
            *(("GET", f"/api/models/{own}/torso.{kind}", None) for kind in ("glb", "json")),
            ("POST", f"{fit['links']['self']}/pattern", {"name": "reduction"}),
            ("POST", fit["links"]["moved"], {"landmarks": picked}),
        ]
        before = [client.open(address, method=method, json=body, buffered=True) for method, address, body in asked]
        assert [answer.status_code for answer in before] == [200] * len(asked)
    with serving(tmp_path, toy) as (service, client):
        assert client.get("/api/meta").json["model"]["name"] == "toy"
        after = [client.open(address, method=method, json=body, buffered=True) for method, address, body in asked]
        newest = client.get(f"/api/models/{read_rig(toy).sha256}/torso.glb")
        assert newest.data == client.get("/api/models/torso.glb").data == toy.read_bytes()
        assert "immutable" in newest.headers["Cache-Control"]
        assert client.get(f"/api/models/{'0' * 64}/torso.glb").status_code == 404
        for (_, address, _), one, other in zip(asked, before, after, strict=True):
            assert other.status_code == 200, (address, other.data[:300])
            assert one.data == other.data or address.endswith(("measures.json", "moved")), address
        for number, part in ((2, "measures"), (-1, "nodes")):  # beside these stand times
            assert json.loads(after[number].data)[part] == json.loads(before[number].data)[part]
        kept = sorted((tmp_path / "models").iterdir())
        assert {path.stem for path in kept} == {read_rig(toy).sha256, own, load_model("male").sha256}
        assert max(path.stat().st_size for path in kept) < 5_000_000


def test_a_model_is_kept_once_and_a_changed_side_file_beside_it(tmp_path: Path, toy: Path) -> None:
    storage = Storage(tmp_path)
    storage.prepare()
    models = KeptModels(storage, toy)
    models.keep()
    [file] = (tmp_path / "models").iterdir()
    written = file.stat().st_mtime_ns
    models.keep()
    assert file.stat().st_mtime_ns == written
    with zipfile.ZipFile(file) as packed:
        assert set(packed.namelist()) >= {"toy.glb", "toy.json"}
    file.unlink()
    (tmp_path / "models").rmdir()
    models.keep()  # no place for it: said in the log alone
    with models.at_hand("0" * 64) as glb:
        assert glb == toy
    storage.close()

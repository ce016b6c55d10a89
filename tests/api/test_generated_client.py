"""A client that openapi-python-client makes of openapi.json: it uploads, fits, lists, and gets every file whole."""

import importlib
import io
import json
import random
import re
import subprocess
import sys
import threading
import zipfile
from collections.abc import Iterator
from pathlib import PurePosixPath
from types import ModuleType
from typing import Any

import httpx
import pytest
from helpers.blank_pictures import any_reports_of_links
from helpers.image_uploads import IMAGE
from helpers.remembered_fits import run_fit_once
from helpers.waiting import ended
from PIL import Image

from breastrig.api.answers import BINARY
from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.api.web_server import Server, ServerLimits
from breastrig.api.write_openapi import FILE
from breastrig.core.assets import asset_folder
from breastrig.execution.limits import FitLimits
from breastrig.scan.kept_image import write_image
from breastrig.service import reports
from breastrig.service.service import Service
from breastrig.storage.files import VOLUME
from breastrig.storage.storage import Storage

EXAMPLE = asset_folder("example") / "standing"
PATHS: dict[str, dict[str, Any]] = json.loads(FILE.read_bytes())["paths"]
NAME = "generated_breastrig_client"


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The name of the package; its generator had nothing to warn of, so no answer is left out of it."""
    folder = tmp_path_factory.mktemp("client")
    (folder / "config.json").write_text('{"post_hooks": []}')
    words = ["--path", str(FILE), "--output-path", str(folder / NAME), "--config", str(folder / "config.json")]
    command = [sys.executable, "-m", "openapi_python_client", "generate", "--meta", "none", "--fail-on-warning", *words]
    made = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert made.returncode == 0, made.stdout
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        yield NAME


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Service, str]]:
    """A service and its address."""
    service = Service(
        Storage(tmp_path_factory.mktemp("data")), runner=run_fit_once, fits=FitLimits(workers=1, grace_s=0.1)
    )
    config = Config()
    with pytest.MonkeyPatch.context() as patch, service.started():
        any_reports_of_links(patch)
        stand_in_for_reports(patch, service)
        server = Server(create_app(config, service).wsgi_app, config, 0, lambda: None, ServerLimits())
        runs = threading.Thread(target=server.run)
        runs.start()
        try:
            yield service, f"http://127.0.0.1:{server.effective_port}"
        finally:
            server.stop()
            runs.join(20)
            server.close()


def stand_in_for_reports(patch: pytest.MonkeyPatch, service: Service) -> None:
    """Any bytes will do for what takes seconds to make, and whose content other tests look at."""
    page, pages = io.BytesIO(), io.BytesIO()
    Image.new("RGB", (200, 300), "white").save(page, "PNG")
    with zipfile.ZipFile(pages, "w") as packed:
        packed.writestr("1.png", page.getvalue())
    names = ("report.pdf", "volume.vtu", "template.pdf", "dicom.zip")
    made: dict[object, bytes] = {reports.MAKERS[name]: random.Random(name).randbytes(5000) for name in names}
    made[reports.MAKERS["pages.zip"]] = pages.getvalue()
    result = service.reports._processes.result
    patch.setattr(service.reports._processes, "result", lambda task, *given: made.get(task) or result(task, *given))


def module_of(generated: str, operation: dict[str, Any]) -> ModuleType:
    """That of one operation."""
    name = re.sub(r"(?<!^)(?=[A-Z])", "_", operation["operationId"]).lower()
    return importlib.import_module(f"{generated}.api.{operation['tags'][0]}.{name}")


def files_of_the_schema() -> dict[str, dict[str, Any]]:
    """{path: media types of its answer} of all that is answered with neither JSON nor text."""
    found = {}
    for path, methods in PATHS.items():
        content = methods.get("get", {}).get("responses", {}).get("200", {}).get("content", {})
        if not all(one == "application/json" or one.startswith("text/") for one in content):
            found[path] = content
    return found


def test_every_file_is_declared_as_bytes_or_as_json() -> None:
    files = files_of_the_schema()
    endings = {PurePosixPath(path).suffix for path in files}
    assert endings == {"", ".glb", ".gltf", ".ply", ".bin", ".png", ".pdf", ".stl", ".svg", ".vtu", ".zip"}
    for path, content in files.items():
        assert BINARY in content or all(one.endswith("+json") for one in content), path
        for media_type, declared in content.items():
            expected = {"type": "object"} if media_type.endswith("+json") else {"type": "string", "format": "binary"}
            assert declared["schema"] == expected, path


@pytest.mark.slow
def test_a_generated_client_uploads_fits_lists_and_gets_every_file(generated: str, served: tuple[Service, str]) -> None:
    service, address = served
    package, models = importlib.import_module(generated), importlib.import_module(f"{generated}.models")
    types = importlib.import_module(f"{generated}.types")

    def call(path: str, method: str = "get", status: int = 200, **given: Any) -> Any:
        answer = module_of(generated, PATHS[path][method]).sync_detailed(client=client, **given)
        assert answer.status_code == status, answer.content
        return answer.parsed

    with (
        package.Client(base_url=address, timeout=httpx.Timeout(60.0)) as client,
        httpx.Client(base_url=address, timeout=60.0) as http,
    ):
        sent = types.File(payload=io.BytesIO((EXAMPLE / "scan.ply").read_bytes()), file_name="scan.ply")
        scan = call("/api/scans", "post", 201, body=models.ScanUpload(file=sent, units=models.ScanUploadUnits.AUTO))
        write_image(IMAGE, service.storage.files.scan(scan.id) / VOLUME)
        picked = json.loads((EXAMPLE / "landmarks.json").read_bytes())
        sent = models.LandmarkFile.from_dict(picked)
        call("/api/scans/{scan_id}/landmarks", "put", scan_id=scan.id, body=sent)
        fit = call("/api/fits", "post", 202, body=models.FitRequest(scan=scan.id, drawing="lumpectomy"))
        assert ended(service, fit.id).state == "done"
        points = [picked["landmarks"][name] for name in ("nipple_L", "nipple_R")]
        line = {"id": "a", "kind": "line", "scan": scan.id, "name": "a", "points": points, "closed": False}
        plan = models.Plan.from_dict({"schema": "breastrig/plan@1", "unit": "mm", "items": [line]})
        call("/api/patients/{patient_id}/plan", "put", patient_id=scan.patient, body=plan, if_match='"0"')
        assert [one.id for one in call("/api/scans").scans] == [scan.id]
        assert [one.id for one in call("/api/fits").fits] == [fit.id]
        assert [one.id for one in call("/api/scans/{scan_id}/fits", scan_id=scan.id).fits] == [fit.id]
        wanted = models.ShareRequest(scan=models.ShareRequestScan.FULL)
        share = call("/api/fits/{fit_id}/shares", "post", 201, fit_id=fit.id, body=wanted)
        opening = models.ShareOpening(token=share.url.partition("#")[2])
        assert call("/api/shared/open", "post", body=opening).id == share.id
        http.cookies = client.get_httpx_client().cookies
        ids = {
            "scan_id": scan.id,
            "fit_id": fit.id,
            "share_id": share.id,
            "sha256": call("/api/meta").model.sha256,
            "name": "lumpectomy",
            "iteration": 1,
        }
        for path in files_of_the_schema():
            # the first takes 20 s: tests/report/test_guide.py has it; the other needs a deletion: test_audited.py
            if path.endswith(("guide.stl", "certificate.pdf")):
                continue
            if path.endswith(("/visits.svg", "/change.png", "/change.glb")):  # of two scans: tests/use/test_visits.py
                continue
            plain = http.get(path.format(**ids))
            assert (plain.status_code, len(plain.content) > 100) == (200, True), path
            parsed = call(path, **{name: ids[name] for name in re.findall(r"{(\w+)}", path)})
            if plain.headers["Content-Type"].endswith("+json"):
                assert parsed.to_dict() == plain.json(), path
            else:
                assert parsed.payload.read() == plain.content, path
        table = call("/api/fits/{fit_id}/measures.csv", fit_id=fit.id)
        assert table.startswith("stance,")
        assert table == http.get(f"/api/fits/{fit.id}/measures.csv").text
        call("/api/scans/{scan_id}", "delete", 204, scan_id=scan.id)
        assert call("/api/scans").scans == []

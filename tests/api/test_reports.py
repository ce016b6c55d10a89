"""The report over HTTP, PDF and numbers: real fits of the example patient, what is kept with a fit, what is refused."""

import io
import pickle
import zipfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pydicom
import pypdf
import pytest
from flask.testing import FlaskClient
from helpers.archives import answering
from helpers.blank_pictures import blank_pictures_in_reports
from helpers.remembered_fits import run_fit_once
from helpers.waiting import ended
from PIL import Image
from pydicom.dataset import Dataset

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.api.wire.files import MeasuresFile
from breastrig.archive.nodes import node
from breastrig.archive.objects import CLASSES
from breastrig.cli.main import main
from breastrig.drawings.plan_schema import ITEMS, POINTS, TEXT
from breastrig.execution.limits import FitLimits
from breastrig.service import reports
from breastrig.service.reports import TWO_PATIENTS
from breastrig.service.service import Service
from breastrig.storage.documents.fits import get_fit
from breastrig.storage.storage import Storage, utc_now
from breastrig.use.guides.template import template_pdf_of
from breastrig.use.reports.report import ReportJob, reported

pytestmark = pytest.mark.long

Real = tuple[Service, FlaskClient, dict[str, str], dict[str, str]]


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Real]:
    """A service with the fits of the example patient standing and lying."""
    storage = Storage(tmp_path_factory.mktemp("reports"))
    service = Service(storage, runner=run_fit_once, fits=FitLimits(workers=1, grace_s=0.1))
    with service.started():
        client = create_app(Config(), service).test_client()
        scans, fits = {}, {}
        patient = None
        for name in ("standing", "supine"):
            scan = client.post(f"/api/examples/{name}").json
            scans[name] = scan["id"]
            patient = patient or scan["patient"]
            client.put(f"/api/scans/{scan['id']}/patient", json={"patient": patient})
            picked = scan["example_landmarks"]["landmarks"]
            asked = {"scan": scan["id"], "landmarks": picked, "drawing": "lumpectomy"}
            fits[name] = client.post("/api/fits", json=asked).json["id"]
            assert ended(service, fits[name]).state == "done"
        yield service, client, scans, fits


@pytest.fixture
def blank(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports whose pictures are white."""
    blank_pictures_in_reports(monkeypatch)


def text_of(content: bytes) -> str:
    pages = [page.extract_text() for page in pypdf.PdfReader(io.BytesIO(content)).pages]
    return " ".join(" ".join(pages).split())


def jobs_of(service: Service, monkeypatch: pytest.MonkeyPatch) -> list[ReportJob]:
    """The reports that are made from now on."""
    jobs, result = [], service.reports._processes.result

    def counted(function: object, args: tuple[ReportJob], timeout: float) -> object:
        jobs.extend(job for job in args if isinstance(job, ReportJob))
        return result(function, args, timeout)

    monkeypatch.setattr(service.reports._processes, "result", counted)
    return jobs


def code_of(client: FlaskClient, scan: str) -> str:
    link = client.get(f"/api/scans/{scan}").json["links"]["patient"]
    return str(client.get(link).json["code"])


@pytest.mark.slow
@pytest.mark.usefixtures("blank")
def test_the_report_is_made_once_and_not_kept_and_names_the_patient_by_the_code_as_its_file_does(
    real: Real, monkeypatch: pytest.MonkeyPatch
) -> None:
    service, client, scans, fits = real
    folder = service.storage.files.fit(fits["standing"])
    before = sorted(folder.iterdir())
    jobs = jobs_of(service, monkeypatch)
    address = f"/api/fits/{fits['standing']}/report.pdf"
    with ThreadPoolExecutor(6) as pool:
        answers = list(pool.map(lambda _: client.application.test_client().get(address), range(6)))
    first = answers[0]
    assert (first.status_code, first.mimetype, first.headers["Cache-Control"]) == (200, "application/pdf", "no-store")
    assert {answer.data for answer in answers} == {first.data} == {client.get(address).data}
    assert len(jobs) == 1
    assert sorted(folder.iterdir()) == before
    assert client.get(address, headers={"If-None-Match": first.headers["ETag"]}).status_code == 304
    code, day = code_of(client, scans["standing"]), utc_now()[:10]
    assert f"filename={code}_standing_{day}_report.pdf" in first.headers["Content-Disposition"]
    text = text_of(first.data)
    assert all(words in text for words in ("Research use only", f"Patient {code}", f"standing, scan received {day}"))
    patient = client.get(f"/api/scans/{scans['standing']}").json["links"]["patient"]
    client.patch(patient, json={"code": "K7M-4QX"})
    renamed = client.get(address)
    assert "Patient K7M-4QX" in text_of(renamed.data)
    assert code not in text_of(renamed.data)
    for name in ("fitted.glb", "drawing.json", "result.json"):
        with client.get(f"/api/fits/{fits['standing']}/{name}") as answer:
            assert answer.headers["Content-Disposition"] == f"attachment; filename=K7M-4QX_standing_{day}_{name}"


@pytest.mark.slow
def test_what_is_cut_away_after_the_fit_is_not_in_its_report(real: Real, monkeypatch: pytest.MonkeyPatch) -> None:
    service, client, scans, fits = real
    address, place = f"/api/fits/{fits['standing']}/measures.json", f"/api/scans/{scans['standing']}/cuts"
    low, high = (client.get(f"/api/scans/{scans['standing']}").json["bounds_m"][end] for end in ("min", "max"))
    below = low[1] + 0.05 * (high[1] - low[1])  # all that lies lower, as seen from the front
    cut = {"to_picture": np.eye(4).ravel().tolist(), "lasso": [[-9, -9], [9, -9], [9, below], [-9, below]]}
    first = client.get(address).data
    jobs = jobs_of(service, monkeypatch)
    client.put(place, json={"cuts": [cut]})
    assert client.get(address).data != b""
    [job] = jobs
    [shown] = reported(job)
    assert shown.stance.scan_vertices[shown.stance.scan_faces].mean(axis=1)[:, 1].min() >= below - 1e-6
    assert len(shown.stance.scan_vertices) == len(np.unique(shown.stance.scan_faces))
    client.put(place, json={"cuts": []})
    assert client.get(address).data == first
    assert len(jobs) == 1, "the one without the cut is remembered still"


def test_a_length_and_the_median_plane_are_the_same_for_page_and_report(real: Real) -> None:
    """The page's tape asks for lengths, and mirrors in the plane of result.json: one number for one distance."""
    _, client, _, fits = real
    place = f"/api/fits/{fits['standing']}"
    with client.get(f"{place}/result.json") as answer:
        picks = answer.json
    per_unit = {"m": 1000.0, "mm": 1.0}[picks["scan"]["unit"]]
    at = {name: per_unit * np.array(point) for name, point in picks["landmarks_picked"].items()}
    rows = {(row["measure"], row["kind"]): row for row in client.get(f"{place}/measures.json").json["measures"]}
    asked = [at["suprasternal_notch"], at["nipple_L"], at["inframammary_fold_L"]]
    answer = client.post(f"{place}/lengths", json={"places": [point.tolist() for point in asked]})
    assert answer.status_code == 200, answer.json
    for leg, measure in zip(answer.json["legs"], ("notch_nipple", "nipple_fold"), strict=True):
        assert leg["mm"] == pytest.approx(rows[measure, "along the skin"]["left"], abs=0.011)
        drawn = np.linalg.norm(np.diff(leg["points"], axis=0), axis=1).sum()
        assert drawn == pytest.approx(leg["mm"], abs=0.05)
    plane = picks["median_plane"]
    for side, key, sign in (("L", "left", 1.0), ("R", "right", -1.0)):
        far = sign * (np.dot(plane["normal"], at[f"nipple_{side}"]) - per_unit * plane["offset"])
        assert far == pytest.approx(rows["nipple_midline", "straight"][key], abs=0.011)
    off = [[5000.0, 0.0, 0.0], at["nipple_L"].tolist()]
    assert client.post(f"{place}/lengths", json={"places": off}).status_code == 422
    assert client.post(f"{place}/lengths", json={"places": off[1:]}).status_code == 422
    assert client.post("/api/fits/nobody/lengths", json={"places": off}).status_code == 404


@pytest.mark.slow
def test_the_measures_of_two_stances_hold_their_changes_and_doubts_where_they_are_filed_as_two_patients(
    real: Real,
) -> None:
    _, client, scans, fits = real
    asked = f"/api/fits/{fits['standing']}/measures.json?with={fits['supine']}"
    one = client.get(f"/api/scans/{scans['supine']}").json["patient"]
    other = client.post("/api/examples/supine").json
    client.put(f"/api/scans/{scans['supine']}/patient", json={"patient": other["patient"], "again": True})
    assert client.get(asked).json["doubts"] == [TWO_PATIENTS]
    client.put(f"/api/scans/{scans['supine']}/patient", json={"patient": one})
    client.delete(other["links"]["self"])
    document = MeasuresFile.model_validate(client.get(asked).json)
    assert document.doubts == []
    assert [stance.name for stance in document.stances] == ["standing", "supine"]
    assert {row.stance for row in document.measures} == {"standing", "supine", "supine - standing"}


def test_the_volume_is_that_of_the_command(real: Real, tmp_path: Path) -> None:
    service, client, _, fits = real
    answer = client.get(f"/api/fits/{fits['standing']}/volume.vtu")
    assert answer.mimetype == "application/vnd.vtk.vtu"
    assert main(["volume", str(service.storage.files.fit(fits["standing"])), "-o", str(tmp_path / "torso.vtu")]) == 0
    assert answer.data == (tmp_path / "torso.vtu").read_bytes()
    assert client.get("/api/fits/nobody/volume.vtu").status_code == 404


def test_the_template_is_of_the_fit_and_its_patient(real: Real, monkeypatch: pytest.MonkeyPatch) -> None:
    """What it shows is tried by tests/report/test_template.py."""
    service, client, scans, fits = real
    asked: list[tuple[object, ReportJob]] = []
    result = service.reports._processes.result

    def made(function: object, args: tuple[ReportJob], timeout: float) -> object:
        if function is not template_pdf_of:
            return result(function, args, timeout)
        asked.append((function, *args))
        return b"%PDF-"

    monkeypatch.setattr(service.reports._processes, "result", made)
    answer = client.get(f"/api/fits/{fits['supine']}/template.pdf")
    headers = (answer.status_code, answer.mimetype, answer.headers["Cache-Control"])
    assert headers == (200, "application/pdf", "no-store")
    assert answer.data == b"%PDF-"
    [(_, job)] = asked
    code = code_of(client, scans["supine"])
    assert (job.fit, job.identity.code) == (service.storage.files.fit(fits["supine"]), code)
    assert f"filename={code}_supine_{utc_now()[:10]}_template.pdf" in answer.headers["Content-Disposition"]
    assert client.get("/api/fits/nobody/template.pdf").status_code == 404


def test_a_guide_is_of_one_side_and_its_name_says_how_far_the_notch_is(
    real: Real, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What makes it takes half a minute here and is tried by tests/report/test_guide.py."""
    service, client, _, fits = real
    assert pickle.loads(pickle.dumps(reports.MAKERS["guide_R.stl"])).keywords == {"side": "R"}
    made = b"Patient's right. Arrow's tip to notch: 154 mm along the skin.".ljust(134)
    monkeypatch.setattr(service.reports, "made", lambda name, *_: {"guide_R.stl": made}[name])
    place = f"/api/fits/{fits['supine']}/guide.stl"
    answer = client.get(f"{place}?side=R")
    assert (answer.status_code, answer.mimetype, answer.headers["Cache-Control"]) == (200, "model/stl", "no-store")
    assert answer.data == made
    assert "guide-right-notch-154mm.stl" in answer.headers["Content-Disposition"]
    assert client.get(place).status_code == client.get(f"{place}?side=both").status_code == 422


@pytest.mark.slow
@pytest.mark.usefixtures("blank")
def test_the_pages_of_the_report_are_pictures_too(real: Real) -> None:
    _, client, _, fits = real
    place = f"/api/fits/{fits['standing']}/report"
    count = len(pypdf.PdfReader(io.BytesIO(client.get(f"{place}.pdf").data)).pages)
    for page in range(1, count + 1):
        answer = client.get(f"{place}.png?page={page}")
        assert (answer.status_code, answer.mimetype, answer.headers["Cache-Control"]) == (200, "image/png", "no-store")
        assert answer.headers["Page-Count"] == str(count)
        width, height = Image.open(io.BytesIO(answer.data)).size
        assert height / width == pytest.approx(297 / 210, abs=0.01)
    assert client.get(f"{place}.png?page={count + 1}").status_code == 404
    assert client.get(f"{place}.png?page=0").status_code == 422


@pytest.mark.parametrize("name", ["report.pdf", "report.png", "measures.json", "measures.csv"])
def test_what_is_refused(real: Real, name: str) -> None:
    _, client, _, fits = real
    place = f"/api/fits/{fits['standing']}/{name}"
    for address, status in (
        (f"/api/fits/nobody/{name}", 404),
        (f"{place}?with=nobody", 404),
        (f"{place}?with={fits['standing']}", 422),
        (f"{place}?other=1", 422),
    ):
        answer = client.get(address)
        assert answer.status_code == status, address
        assert answer.mimetype == "application/problem+json"


@pytest.mark.usefixtures("blank")
@pytest.mark.filterwarnings("ignore:Exception ignored in. <socket")  # one of pynetdicom's, not connected
def test_a_fit_goes_to_the_archives_that_the_service_names_and_nowhere_else(real: Real, tmp_path: Path) -> None:
    service, client, scans, fits = real
    code = client.get(f"/api/scans/{scans['standing']}").json["patient_code"]
    (tmp_path / "codes.csv").write_text(f"code,id,name\n{code},4711,Groß^Eva\n", encoding="utf-8")
    stored: list[Dataset] = []
    with answering(set(CLASSES.values()), lambda each: stored.append(each) or 0) as port:
        to = {"dicom": f"STORE@127.0.0.1:{port}", "objects": ("report", "measures")}
        archives = {"pacs": node(**to, identities=tmp_path / "codes.csv"), "coded": node(**to)}
        sending = create_app(Config(archives=archives), service).test_client()
        assert sending.get("/api/meta").json["archives"] == ["pacs", "coded"]
        for name in archives:
            sent = sending.post(f"/api/fits/{fits['standing']}/archive", json={"archive": name})
            assert (sent.status_code, sent.json) == (200, {"notes": []})
        for name in ("other", f"STORE@127.0.0.1:{port}"):
            sent = sending.post(f"/api/fits/{fits['standing']}/archive", json={"archive": name})
            assert sent.status_code == 422
            assert "sends to no archive of that name" in sent.json["detail"]
    assert [(each.PatientID, str(each.PatientName)) for each in stored[:2]] == 2 * [("4711", "Groß^Eva")]
    assert [each.PatientID for each in stored[2:]] == [code, code]
    failed = sending.post(f"/api/fits/{fits['standing']}/archive", json={"archive": "coded"})
    assert failed.status_code == 502
    assert "cannot be reached" in failed.json["detail"]
    assert client.get("/api/meta").json["archives"] == []
    with zipfile.ZipFile(io.BytesIO(client.get(f"/api/fits/{fits['standing']}/dicom.zip").data)) as files:
        found = {name: pydicom.dcmread(io.BytesIO(files.read(name))) for name in files.namelist()}
    assert list(found) == ["report.dcm", "measures.dcm", "skin.dcm", "scan.dcm"]
    assert {each.PatientID for each in found.values()} == {code}
    assert found["report.dcm"].SOPInstanceUID == stored[2].SOPInstanceUID


def test_a_fit_that_is_not_done_has_no_report(client: FlaskClient, scan_id: str) -> None:
    fit = client.post("/api/fits", json={"scan": scan_id, "preset": "paper"}).json["id"]
    for name in (
        "report.pdf",
        "report.png",
        "measures.json",
        "measures.csv",
        "volume.vtu",
        "template.pdf",
        "dicom.zip",
        "guide.stl?side=L",
    ):
        assert client.get(f"/api/fits/{fit}/{name}").status_code == 409
    client.post(f"/api/fits/{fit}/cancel")


@pytest.mark.slow
def test_a_fit_without_the_files_of_one_is_a_sentence_without_folders(client: FlaskClient, fit_id: str) -> None:
    """The fit of this service is a fake, whose files hold nothing."""
    answer = client.get(f"/api/fits/{fit_id}/report.pdf")
    assert answer.status_code == 422
    assert "/" not in answer.json["detail"].replace("/result.json", "")


@pytest.mark.slow
@pytest.mark.usefixtures("blank")
def test_a_report_with_a_plan_is_remembered_and_not_kept_on_the_disk(real: Real) -> None:
    """It may hold what was carried from another scan, and must not outlive that scan's deletion."""
    service, client, scans, fits = real
    folder = service.storage.files.fit(fits["standing"])
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    plan = client.get(f"/api/scans/{scans['standing']}").json["links"]["plan"]
    seen = client.get(plan).headers["ETag"]
    note = {"kind": "note", "id": "n", "scan": scans["standing"], "text": "wants it smaller"}
    tumour = {"kind": "tumour", "id": "t", "scan": scans["standing"], "side": "L", "clock": 3.0, "distance_mm": 30.0}
    items = [note, tumour | {"radius_mm": 10.0, "depth_mm": 15.0}]
    stored = client.put(plan, json={"items": items}, headers={"If-Match": seen})
    assert stored.status_code == 200, stored.json
    address = f"/api/fits/{fits['standing']}/report.pdf"
    first = client.get(address).data
    text = text_of(first)
    assert all(words in text for words in ("Tumour, left", "wants it smaller", "Hour 3:00", "Below the skin 15 mm"))
    assert f"plan, version 1 {utc_now()[:10]}" in text
    assert "Sternum upper" not in text  # the plan speaks for the fit's own drawing
    assert client.get(address).data == first
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    client.put(plan, json={"items": []}, headers={"If-Match": stored.headers["ETag"]})


@pytest.mark.slow
@pytest.mark.usefixtures("blank")
def test_a_links_report_has_no_code_and_notes_only_where_the_owner_says_so(real: Real) -> None:
    _, client, scans, fits = real
    links = client.get(f"/api/scans/{scans['standing']}").json["links"]
    client.patch(links["patient"], json={"code": "Secret Code 77"})
    note = {"kind": "note", "id": "n", "scan": scans["standing"], "text": "wants it smaller"}
    line = {"kind": "tumour", "id": "t", "scan": scans["standing"], "side": "L", "clock": 3.0}
    items = [note, line | {"distance_mm": 30.0, "radius_mm": 10.0}]
    seen = client.get(links["plan"]).headers["ETag"]
    assert client.put(links["plan"], json={"items": items}, headers={"If-Match": seen}).status_code == 200
    for notes in (False, True):
        made = client.post(f"/api/fits/{fits['standing']}/shares", json={"scan": "plain", "notes": notes}).json
        visitor = client.application.test_client()
        token = made["url"].removeprefix("/s#")
        shown = visitor.post("/api/shared/open", json={"token": token}).json["links"]
        with visitor.get(shown["report"]) as answer:
            text = text_of(answer.data)
            assert answer.headers["Content-Disposition"] == "attachment; filename=report.pdf"
        assert "Tumour, left breast" in text
        assert ("wants it smaller" in text) == notes
        assert "Secret" not in text


@pytest.mark.slow
@pytest.mark.usefixtures("blank")
def test_no_length_that_a_plan_can_reach_ends_the_patient(real: Real) -> None:
    """A megabyte, with as many items and points as the schema takes: nudged, fitted again, drawn, reported."""
    service, client, scans, fits = real
    scan = scans["standing"]
    picked = get_fit(service.storage, fits["standing"]).landmarks_mm
    lines = [
        {"kind": "line", "id": f"l{k}".ljust(64, "x"), "scan": scan, "name": f"line {k} ".ljust(100, "y")}
        | {"points": [[*map(round, picked["xiphoid"])]] * (POINTS // 10)}
        for k in range(10)
    ]
    parameters = dict.fromkeys(("areola_mm", "limb_mm"), 40.0 + 1 / 3) | {"side": "both", "opening_deg": 90 + 1 / 3}
    parameters |= dict.fromkeys(("nipple_above_fold_mm", "nipple_outward_mm", "fold_below_mm"), -1 / 3)
    wise = {"kind": "pattern", "id": "w" * 64, "scan": scan, "name": "reduction"}
    wise |= {"parameters": parameters | {"limb_angle_deg": 60 + 1 / 3}}
    tumours = [
        {"kind": "tumour", "id": f"t{k}", "scan": scan, "side": "LR"[k % 2], "clock": 1 + k / 3, "depth_mm": 100 / 3}
        | {"distance_mm": 60 / 3.3, "radius_mm": 30 / 3.7}
        for k in range(10)
    ]
    others = ITEMS - len(lines) - len(tumours) - 1
    notes = [{"kind": "note", "id": f"n{k}", "scan": scan, "text": ("word " * 10).strip()} for k in range(others)]
    notes[0]["text"] = "x" * TEXT
    plan = client.get(f"/api/scans/{scan}").json["links"]["plan"]
    seen = client.get(plan).headers["ETag"]
    stored = client.put(plan, json={"items": [*lines, wise, *tumours, *notes]}, headers={"If-Match": seen})
    assert stored.status_code == 200, stored.json

    by_text = "+".join(
        ["reduction:" + ",".join(f"{key}={value}" for key, value in wise["parameters"].items())]
        + [f"tumour:{each['side']},{each['clock']},{each['distance_mm']},{each['radius_mm']}" for each in tumours]
    )
    moved = picked | {"nipple_L": [value + 1.0 for value in picked["nipple_L"]]}
    assert client.post(f"/api/fits/{fits['standing']}/moved", json={"landmarks": moved}).status_code == 200
    again = {"scan": scan, "landmarks": moved, "start_from": fits["standing"], "drawing": by_text}
    answer = client.post("/api/fits", json=again)
    assert answer.status_code == 202, answer.json
    assert ended(service, answer.json["id"]).state == "done"
    links = client.get(answer.json["links"]["self"]).json["links"]
    with client.get(links["drawing"]) as answer:
        assert {shape["name"] for shape in answer.json["shapes"]} >= {"tumour_L", "tumour_5_L", "tumour_5_R"}
    drawn = client.get(links["plan"]).json
    assert {shape["item"] for shape in drawn["shapes"]} >= {each["id"] for each in (*lines, *tumours)}
    assert len(drawn["notes"]) == others
    glb = client.get(links["fitted_glb"])
    assert glb.status_code == 200, glb.json
    report = client.get(links["report"])
    assert report.status_code == 200, report.json
    client.put(plan, json={"items": []}, headers={"If-Match": stored.headers["ETag"]})


@pytest.mark.slow
@pytest.mark.usefixtures("blank")
def test_deleting_the_scan_deletes_the_report(real: Real) -> None:
    service, client, scans, fits = real
    place = f"/api/fits/{fits['standing']}/report.pdf"
    assert client.get(place).status_code == 200
    assert client.delete(f"/api/scans/{scans['standing']}").status_code == 204
    assert client.get(place).status_code == 404
    for name in ("report.pdf", "measures.json"):
        assert not list(service.storage.root.rglob(name))

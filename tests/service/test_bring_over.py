"""Patients of the rows become cases with all that is theirs, whole or not at all, however often it is interrupted."""

import json
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.fits import claimed, events_after, get_fit
from breastrig.cases.links import get_link, shown_folder
from breastrig.cases.of_scans import get_cuts, get_ink, get_landmarks, get_proposals
from breastrig.cases.plans import get_plan, plan_versions
from breastrig.cli.main import main
from breastrig.core.picks import Picks
from breastrig.service.bring_over import bring_over
from breastrig.storage.files import share_place
from breastrig.storage.folders import new_id
from breastrig.storage.rows.events import append
from breastrig.storage.rows.expiring_scans import announce
from breastrig.storage.rows.fits import NewFit, Once, add_fit, claim_fit
from breastrig.storage.rows.patients import get_patient, patient_of_scan, put_plan, rename_patient
from breastrig.storage.rows.scans import ScanRow, add_scan, put_cuts, put_landmarks
from breastrig.storage.rows.searches import drop_ink, put_ink, put_proposals
from breastrig.storage.rows.shares import ShareRow, add_share
from breastrig.storage.storage import Storage

FACTS = {"unit": "mm", "stance": {"proposed": "standing"}, "triangles": 2}
PICKS = Picks({"nipple_L": [1.0, 2.0, 3.0]}, ("nipple_L",), {})
CUTS = ({"to_picture": [1.0] * 16, "lasso": [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]},)
EVENTS = ({"kind": "started", "stance": "standing"}, {"kind": "iterated", "nodes": []}, {"kind": "done", "result": {}})
SECRETS = ("scrypt$a$passcode", "ab" * 32)
PATIENTS = 3


def one_patient(storage: Storage, code: str) -> None:
    """With a scan, its documents, two fits (done, waiting), a link and two versions of a plan."""
    scan, done, waiting, snapshot = (new_id() for _ in range(4))
    storage.files.make(f"scans/{scan}")
    for name in ("scan.stored", "mesh.glb", "thumbnail.png"):
        (storage.files.scan(scan) / name).write_bytes(f"skin of {code}".encode())
    add_scan(storage, ScanRow(scan, "2026-01-01T00:00:00.000Z", "stored", code * 9, FACTS))
    patient = patient_of_scan(storage, scan)
    rename_patient(storage, patient, code)
    put_landmarks(storage, scan, PICKS)
    put_cuts(storage, scan, CUTS)
    drawing = {"schema": "breastrig/drawing@1", "unit": "mm", "shapes": [{"name": "violet-1"}, {"name": "violet-2"}]}
    put_ink(storage, scan, drawing)
    drop_ink(storage, scan, {"violet-2": True})
    put_proposals(storage, scan, "model", {"nipple_L": {"point": [1, 2, 3]}})
    announce(storage, [scan], "2026-02-01T00:00:00.000Z")
    for version, text in enumerate((f"first of {code}", f"second of {code}")):
        put_plan(storage, patient, [{"kind": "note", "id": "n", "scan": scan, "text": text}], version)
    asked = NewFit(scan=scan, stance="auto", landmarks_mm=PICKS.points_mm, certain=PICKS.certain, refine=True)
    for fit in (done, waiting):
        storage.make_fit(fit)
        add_fit(storage, "2026-01-02T00:00:00.000Z", fit, asked, Once.of(fit, "request"))
    claim_fit(storage, done)
    for event in EVENTS:
        append(storage, done, event)
    (storage.files.fit(done) / "result.json").write_text("{}")
    (storage.files.fit(done) / "fit.log.jsonl").write_text("another log")
    storage.files.make(share_place(snapshot))
    (storage.files.folder(share_place(snapshot)) / "shown.glb").write_bytes(b"shown")
    share = ShareRow(
        new_id(), done, "2026-01-03", "2999-01-01", "plain", SECRETS[0], snapshot, "2026-01-03", notes=True
    )
    add_share(storage, share, SECRETS[1][: -len(code)] + code)


@pytest.fixture
def storage(tmp_path: Path) -> Iterator[Storage]:
    storage = Storage(tmp_path / "data")
    storage.prepare()
    for number in range(PATIENTS):
        one_patient(storage, f"P{number}")
    yield storage
    storage.close()


@pytest.fixture
def cases(tmp_path: Path) -> Path:
    (tmp_path / "cases").mkdir()
    return tmp_path / "cases"


def check(storage: Storage, folder: Path) -> None:
    """All that the rows say of a patient is in the case."""
    case = CaseFolder(folder)
    row = get_patient(storage, case.id)
    assert (case.document().code, case.document().created_at) == (row.code, row.created_at)
    [scan] = case.scan_ids()
    assert case.scan(scan).facts == FACTS
    assert (case.scan_folder(scan) / layout.STORED).read_bytes() == f"skin of {row.code}".encode()
    assert get_landmarks(case, scan) == PICKS
    assert get_cuts(case, scan) == CUTS
    ink = get_ink(case, scan)
    assert ink is not None
    assert (len(ink.shapes), ink.dropped) == (2, ["violet-2"])
    assert get_proposals(case, scan, "model") is not None
    assert (case.scan_folder(scan) / layout.EXPIRES).is_file()
    assert plan_versions(case) == [1, 2]
    texts = [get_plan(case, version).document.items[0].text for version in (1, 2)]  # type: ignore[union-attr]
    assert texts == [f"first of {row.code}", f"second of {row.code}"]
    assert get_plan(case).document.whole
    fits = {get_fit(case, scan, name).state: name for name in os.listdir(case.scan_folder(scan) / layout.FITS)}
    assert set(fits) == {"done", "queued"}
    done = case.path / layout.fit_part(scan, fits["done"])
    assert [json.loads(line) for _, line in events_after(done)] == list(EVENTS)
    asked = get_fit(case, scan, fits["done"]).document
    assert (asked.stance, asked.refine, asked.landmarks_mm) == ("auto", True, PICKS.points_mm)
    assert asked.key_sha256 == Once.of(fits["done"], "request").key_sha256
    [link] = os.listdir(done / layout.LINKS)
    assert get_link(case, scan, fits["done"], link).notes
    assert (shown_folder(case, scan, fits["done"], link) / "shown.glb").read_bytes() == b"shown"
    with claimed(case, scan, fits["queued"]) as claim:
        assert claim is not None


def test_each_patient_becomes_a_case(storage: Storage, cases: Path, tmp_path: Path) -> None:
    found = bring_over(storage, cases, tmp_path / "incoming")
    assert (len(found.cases), found.scans, found.fits, found.plans, found.links) == (3, 3, 6, 6, 3)
    assert sorted(found.cases) == sorted(os.listdir(cases))
    for folder in cases.iterdir():
        check(storage, folder)
    assert {secret.passcode_hash for secret in found.secrets} == {SECRETS[0]}
    content = b"".join(file.read_bytes() for file in cases.rglob("*") if file.is_file())
    for word in (SECRETS[0], SECRETS[1][:32], *(secret.token_sha256 for secret in found.secrets)):
        assert word.encode() not in content
    again = bring_over(storage, cases, tmp_path / "incoming")
    assert (again.cases, sorted(again.there)) == ([], sorted(found.cases))


@pytest.mark.parametrize("patients", range(PATIENTS + 1))
def test_what_was_interrupted_at_a_patient_is_finished_by_the_next_call(
    storage: Storage, cases: Path, tmp_path: Path, patients: int
) -> None:
    left = [patients]

    def stopped() -> None:
        if left[0] == 0:
            raise KeyboardInterrupt
        left[0] -= 1

    try:
        bring_over(storage, cases, tmp_path / "incoming", stopped=stopped)
    except KeyboardInterrupt:
        assert len(os.listdir(cases)) == patients
    bring_over(storage, cases, tmp_path / "incoming")
    assert len(os.listdir(cases)) == PATIENTS
    for folder in cases.iterdir():
        check(storage, folder)


def test_an_error_in_the_middle_of_a_patient_leaves_nothing_of_it(
    storage: Storage, cases: Path, tmp_path: Path, monkeypatch
) -> None:
    def full(*_given: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("breastrig.service.bring_over.sync_file", full)
        with pytest.raises(OSError, match="No space"):
            bring_over(storage, cases, tmp_path / "incoming")
    assert os.listdir(cases) == os.listdir(tmp_path / "incoming") == []
    assert len(bring_over(storage, cases, tmp_path / "incoming").cases) == PATIENTS


def test_where_there_are_no_hard_links_files_are_copied(
    storage: Storage, cases: Path, tmp_path: Path, monkeypatch
) -> None:
    def refused(*_given: object) -> None:
        raise OSError(18, "Invalid cross-device link")

    monkeypatch.setattr("breastrig.service.bring_over.os.link", refused)
    bring_over(storage, cases, tmp_path / "incoming")
    for folder in cases.iterdir():
        check(storage, folder)


def test_the_command_line_writes_them_beside_a_service_that_is_stopped(
    storage: Storage, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data, folder = str(storage.root), tmp_path / "backup"
    with storage.exclusive():
        assert main(["backup", data, "-o", str(folder)]) == 2
    assert "Another BreastRig server uses" in capsys.readouterr().err
    assert main(["backup", data, "-o", f"{data}/inside"]) == 2
    assert main(["backup", str(tmp_path), "-o", str(folder)]) == 2
    assert main(["backup", data, "-o", str(folder), "--code", "nobody"]) == 2
    assert main(["backup", data, "-o", str(folder), "--code", "P1"]) == 0
    assert capsys.readouterr().out == f"1 cases with 1 scans and 2 fits in {folder}\n"
    assert main(["backup", data, "-o", str(folder)]) == 0
    assert "1 were there already" in capsys.readouterr().out
    assert main(["case", "list", str(folder)]) == 0
    assert sorted(line.split()[0] for line in capsys.readouterr().out.splitlines()) == ["P0", "P1", "P2"]
    assert all(layout.ID.fullmatch(each.name) for each in folder.iterdir())

"""A data folder of version 0.2.0 is brought over, each patient whole or not at all, however often it is interrupted."""

import json
import os
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from helpers import fake_fit

from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.fits import events_after, fits_of_scan
from breastrig.cases.of_scans import get_landmarks
from breastrig.cases.plans import get_plan, plan_versions
from breastrig.cli.main import main
from breastrig.core.errors import BadSettings
from breastrig.execution.limits import FitLimits
from breastrig.index.questions import secret_of_token
from breastrig.service.bring_over import OLD, take_over
from breastrig.service.service import Service
from breastrig.storage.storage import Storage

TABLES = Path(__file__).parents[1] / "storage" / "tables_0001.sql"
PATIENTS = 3
FACTS = {"unit": "mm", "stance": {"proposed": "standing"}, "bounds_m": {"min": [0, 0, 0], "max": [1, 1, 1]}}


def name_of(kind: str, number: int) -> str:
    return f"{kind}-{number}".ljust(22, "-")


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """As 0.2.0 has left it: a patient has a scan, two versions of a plan, a fit that is done and one that waits."""
    root = tmp_path / "data"
    for kind in ("scans", "fits", "shares"):
        (root / kind).mkdir(parents=True)
    (root / "installation").write_text(name_of("installation", 1))
    with closing(sqlite3.connect(root / OLD)) as rows, rows:
        rows.executescript(TABLES.read_text())

        def add(table: str, **values: object) -> None:
            marks = ", ".join("?" for _ in values)
            rows.execute(f"INSERT INTO {table} ({', '.join(values)}) VALUES ({marks})", tuple(values.values()))

        for k in range(PATIENTS):
            scan, patient = name_of("scan", k), name_of("patient", k)
            (root / "scans" / scan).mkdir()
            (root / "scans" / scan / "scan.stored").write_bytes(f"skin {k}".encode())
            facts = json.dumps(FACTS)
            add("scans", id=scan, created_at=f"2026-01-0{k + 1}", file_type="stored", sha256=f"{k}", facts=facts)
            add("patients", position=k + 1, id=patient, code=f"P{k}", created_at="2026-01-01", version=2)
            add("scans_of_patients", scan=scan, patient=patient)
            add("landmarks", scan=scan, points_mm='{"umbilicus": [1, 2, 3]}')
            for version in (1, 2):
                item = {"kind": "note", "id": "n", "scan": scan, "text": f"text {version}"}
                plan = {"schema": "breastrig/plan@1", "unit": "mm", "items": [item], "whole": True}
                add("plans", patient=patient, version=version, json=json.dumps(plan))
            for state in ("done", "queued"):
                fit = name_of(state, k)
                (root / "fits" / fit).mkdir()
                known = {"created_at": f"2026-02-0{k + 1}", "preset": "default", "landmarks_mm": "{}", "iterations": 0}
                add("fits", id=fit, place=2 * k + (state == "done"), scan=scan, state=state, stance="auto",
                    last_event=2 if state == "done" else 0, **known)  # fmt: skip
            done = name_of("done", k)
            (root / "fits" / done / "result.json").write_text("{}")
            for number, event in enumerate(({"kind": "started"}, {"kind": "done", "result": {}}), start=1):
                text = json.dumps(event, separators=(",", ":"))
                add("events", fit=done, number=number, kind=event["kind"], json=text)
            columns = {row[1] for row in rows.execute("PRAGMA table_info(shares)")}
            share = {
                "id": name_of("share", k), "fit": done, "token_sha256": f"{k}" * 64, "created_at": "2026",
                "expires_at": "2999", "scan": "plain", "passcode_hash": "scrypt$secret",
                "snapshot": name_of("shown", k),
            }  # fmt: skip
            (root / "shares" / name_of("shown", k)).mkdir()
            (root / "shares" / name_of("shown", k) / "shown.glb").write_bytes(b"shown")
            add("shares", **{key: value for key, value in share.items() if key in columns})
    return root


def check(storage: Storage) -> None:
    """All that was in the rows is in the cases, and the early version's files are gone."""
    assert sorted(os.listdir(storage.root / layout.CASES)) == [name_of("patient", k) for k in range(PATIENTS)]
    for k in range(PATIENTS):
        case = CaseFolder(storage.root / layout.CASES / name_of("patient", k))
        scan = name_of("scan", k)
        assert (case.document().code, case.scan_ids()) == (f"P{k}", {scan})
        assert (case.scan_folder(scan) / layout.STORED).read_bytes() == f"skin {k}".encode()
        assert get_landmarks(case, scan).points_mm == {"umbilicus": [1.0, 2.0, 3.0]}
        assert plan_versions(case) == [1, 2]
        texts = [get_plan(case, version).document.items[0].text for version in (1, 2)]
        assert texts == ["text 1", "text 2"]
        assert {fit.id: fit.state for fit in fits_of_scan(case, scan)} == {
            name_of("done", k): "done",
            name_of("queued", k): "queued",
        }
        done = case.path / layout.fit_part(scan, name_of("done", k))
        assert [json.loads(line)["kind"] for _, line in events_after(done)] == ["started", "done"]
        secret = storage.index.asked(lambda rows, k=k: secret_of_token(rows, f"{k}" * 64))
        assert secret is not None
        assert (secret.link, secret.passcode_hash) == (name_of("share", k), "scrypt$secret")
    kept = b"".join(file.read_bytes() for file in (storage.root / layout.CASES).rglob("*") if file.is_file())
    assert b"scrypt" not in kept
    for name in (OLD, "scans", "fits", "shares"):
        assert not (storage.root / name).exists()


@pytest.mark.parametrize("patients", [0, 2, PATIENTS])
def test_it_may_be_interrupted_at_each_patient(root: Path, patients: int, monkeypatch: pytest.MonkeyPatch) -> None:
    left, real = [patients], os.rename

    def interrupted(source: Path, target: Path) -> None:
        if left[0] == 0:
            raise KeyboardInterrupt
        left[0] -= 1
        real(source, target)

    storage = Storage(root)
    storage.prepare()
    if patients < PATIENTS:
        with monkeypatch.context() as patch:
            patch.setattr("breastrig.service.bring_over.os.rename", interrupted)
            with pytest.raises(KeyboardInterrupt):
                take_over(storage)
        assert len(os.listdir(root / layout.CASES)) == patients
        assert (root / OLD).is_file()
    take_over(storage)
    check(storage)
    take_over(storage)
    check(storage)
    storage.close()


def test_a_server_does_it_at_its_start_and_runs_what_waited(root: Path) -> None:
    service = Service(Storage(root), runner=fake_fit.quick, fits=FitLimits(workers=1, grace_s=0.1), keep_days=None)
    with service.started():
        assert not (root / OLD).exists()
        assert len(os.listdir(root / layout.CASES)) == PATIENTS


def test_where_one_cannot_come_over_the_early_files_stay(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    storage = Storage(root)
    storage.prepare()
    monkeypatch.setattr("breastrig.service.bring_over._bring_over", lambda *_given: None)
    with pytest.raises(BadSettings, match="3 patients of an earlier version could not be brought over"):
        take_over(storage)
    assert (root / OLD).is_file()
    storage.close()


def test_what_was_on_its_way_out_goes_and_what_others_have_put_there_stays(root: Path) -> None:
    for place in ("scans/of others", f"rubbish/scans.{name_of('deleted', 1)}", "rubbish/of others"):
        (root / place).mkdir(parents=True)
        (root / place / "file").write_text("x")
    (root / "reserve").write_bytes(bytes(10))
    storage = Storage(root)
    storage.prepare()
    take_over(storage)
    storage.close()
    assert os.listdir(root / "scans") == os.listdir(root / "rubbish") == ["of others"]
    assert not {"reserve", OLD, "fits", "shares"} & set(os.listdir(root))


def test_purge_deletes_the_patients_of_an_early_version_too(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["purge", "--all", "--data", str(root)]) == 0
    assert capsys.readouterr().out.startswith(f"{PATIENTS} scans deleted from ")
    assert os.listdir(root / layout.CASES) == []


def test_the_index_of_an_early_version_is_made_of_its_patients(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for _ in range(2):
        assert main(["index", str(root)]) == 0
        assert capsys.readouterr().out == f"{PATIENTS} cases, {PATIENTS} scans, {2 * PATIENTS} fits\n"
    storage = Storage(root)
    check(storage)
    storage.close()
    (root / OLD).write_bytes(b"no database at all")
    assert main(["index", str(root)]) == 2
    assert "of an earlier version is damaged" in capsys.readouterr().err


@pytest.mark.parametrize("content", [b"\xa5" * 20_000])
def test_a_damaged_database_of_an_early_version_is_one_sentence_and_stays(
    root: Path, content: bytes, capsys: pytest.CaptureFixture[str]
) -> None:
    (root / OLD).write_bytes(content)
    for command in (["serve", "--port", "0"], ["purge", "--all"]):
        assert main([*command, "--data", str(root)]) == 2
        said = capsys.readouterr().err
        assert f"breastrig: The database {root / OLD} of an earlier version is damaged; " in said
    assert (root / OLD).read_bytes() == content
    assert (root / "scans" / name_of("scan", 1)).is_dir()


def test_deletions_that_were_under_way_are_not_brought_over(root: Path) -> None:
    with closing(sqlite3.connect(root / OLD)) as rows, rows:
        rows.execute(
            "INSERT INTO file_journal (place, scan, removing) VALUES (?, ?, 1)",
            (f"scans/{name_of('scan', 1)}", name_of("scan", 1)),
        )
    storage = Storage(root)
    storage.prepare()
    take_over(storage)
    assert sorted(os.listdir(root / layout.CASES)) == [name_of("patient", k) for k in (0, 2)]
    storage.close()

"""A backup of a folder that is being written holds each patient once, and comes back byte by byte or not at all."""

import json
import os
import tarfile
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.cases import data_folder, new_case, new_fit, new_link, new_scan, note
from helpers.on_disk import bytes_below

from breastrig.audit.deletions import deletion
from breastrig.audit.log import AuditLog
from breastrig.audit.read import check, lines_from
from breastrig.backup import age, write
from breastrig.backup.age import SealedReader, SealedWriter
from breastrig.backup.restore import MANIFEST, restore
from breastrig.backup.write import back_up
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.plans import put_plan, stored_plan
from breastrig.cases.removal import delete_case, delete_scan, move_scan
from breastrig.cli.main import main
from breastrig.core.errors import BadInput
from breastrig.index.questions import LinkSecret, put_secret, secret_of_link
from breastrig.storage.documents.patients import get_plan, listed_page
from breastrig.storage.storage import Storage

WORDS = "correct horse battery staple"


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(age, "WORK", 4)
    monkeypatch.setenv("BREASTRIG_PASSPHRASE", WORDS)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    data_folder(tmp_path / "data")
    return tmp_path / "data"


def patient(data: Path, code: str = "K7M-4QX") -> CaseFolder:
    case = new_case(data / "cases", code)
    scan = new_scan(case, os.urandom(70_000))
    new_fit(case, scan)
    put_plan(case, [note(scan, f"of {code}")])
    return case


def contents(data: Path) -> dict[str, bytes]:
    """Of the cases, but for locks."""
    files = [each for each in (data / "cases").rglob("*") if each.is_file() and each.name not in (".lock", ".claim")]
    return {each.relative_to(data).as_posix(): each.read_bytes() for each in files}


def test_it_comes_back_as_it_was_with_links_closed(tmp_path: Path) -> None:
    storage = Storage(tmp_path / "data")
    storage.prepare()
    case = patient(storage.root)
    link = new_link(case)
    storage.index.look()
    with storage.index.writing() as rows:
        put_secret(rows, LinkSecret(link, "ab" * 32, "scrypt$of$a$passcode"))
    with storage.exclusive():  # as a server holds it
        assert main(["backup", str(tmp_path), str(storage.root)]) == 0
    [file] = tmp_path.glob("breastrig-*.age")
    assert file.stat().st_mode & 0o777 == 0o600
    assert b"K7M-4QX" not in file.read_bytes()
    assert not list((storage.root / "incoming").iterdir())
    assert main(["restore", str(file), str(tmp_path / "new")]) == 0
    assert contents(tmp_path / "new") == contents(storage.root)
    again = Storage(tmp_path / "new")
    again.prepare()
    [row] = listed_page(again, 9, None)[0]
    assert get_plan(again, row.id).items[0]["text"] == "of K7M-4QX"
    assert again.index.asked(secret_of_link, link) is None
    assert b"scrypt" not in bytes_below(again.root)
    assert not check(again.root).fault
    assert [line["how"] for line in lines_from(again.root) if "how" in line] == ["restore", "backup"]
    for each in (storage, again):
        each.close()


@pytest.fixture
def while_packing(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[], None]], None]:
    """Does something once, after the first case was put in."""
    add = write._Packed._add_case

    def during(act: Callable[[], None]) -> None:
        acts = [act]

        def added(packed: write._Packed, path: Path) -> int:
            stamp = add(packed, path)
            if acts:
                acts.pop()()
            return stamp

        monkeypatch.setattr(write._Packed, "_add_case", added)

    return during


def restored(data: Path, tmp_path: Path) -> Path:
    back_up(data, tmp_path / "backup.age", WORDS, "shell:0")
    restore(tmp_path / "backup.age", tmp_path / "new", WORDS, "shell:0")
    return tmp_path / "new"


def test_a_scan_that_moves_meanwhile_is_in_one_case(
    data: Path, tmp_path: Path, while_packing: Callable[[Callable[[], None]], None]
) -> None:
    cases = [patient(data, "A"), patient(data, "B"), patient(data, "C")]
    scans = [next(iter(case.scan_ids())) for case in cases]
    for case in cases:
        new_scan(case)

    def move() -> None:
        for source, target in ((0, 1), (1, 2), (2, 0)):
            move_scan(cases[source], scans[source], cases[target])

    while_packing(move)
    new = restored(data, tmp_path)
    assert contents(new) == contents(data)
    assert {each.id: each.scan_ids() for each in cases} == {
        each.id: CaseFolder(new / "cases" / each.id).scan_ids() for each in cases
    }


def test_who_is_deleted_meanwhile_is_not_in_it(
    data: Path, tmp_path: Path, while_packing: Callable[[Callable[[], None]], None]
) -> None:
    first, second = patient(data, "A"), patient(data, "B")
    while_packing(lambda: [delete_case(each) for each in (first, second)] and None)
    assert contents(restored(data, tmp_path)) == {}


def test_a_plan_that_is_written_all_the_time_is_whole(data: Path, tmp_path: Path) -> None:
    case = patient(data)
    scan, stop = next(iter(case.scan_ids())), threading.Event()

    def write_plans() -> None:
        number = 0
        while not stop.wait(0.05):
            number += 1
            put_plan(case, [note(scan, f"note {number}")])

    writer = threading.Thread(target=write_plans)
    writer.start()
    try:
        new = restored(data, tmp_path)
    finally:
        stop.set()
        writer.join()
    assert stored_plan(CaseFolder(new / "cases" / case.id)).items


def test_who_was_deleted_since_is_left_out_or_named(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gone, kept = patient(data, "A"), patient(data, "B")
    scan = new_scan(kept)
    put_plan(kept, [*stored_plan(kept).items, note(scan, "secret of a scan")])
    file = str(tmp_path / "b.age")
    assert main(["backup", file, str(data)]) == 0
    with deletion(AuditLog(data), "token", "scans.remove_scan", kept.path, scan):
        delete_scan(kept, scan)
    with deletion(AuditLog(data), "token", "patients.remove_patient", gone.path):
        delete_case(gone)
    lines = b"".join(each.read_bytes() for each in sorted((data / "audit").glob("*.jsonl")))
    (tmp_path / "audit.jsonl").write_bytes(lines)  # as the page hands it out
    for number, log in enumerate((data, tmp_path / "audit.jsonl")):
        capsys.readouterr()
        new = tmp_path / f"new{number}"
        assert main(["restore", file, str(new), "--audit", str(log)]) == 0
        said = capsys.readouterr()
        assert f"{gone.id} was deleted since, and is left out" in said.out
        assert f"{scan} was deleted since, and is left out" in said.out
        assert said.err == ""
        assert [each.name for each in (new / "cases").iterdir()] == [kept.id]
        left = bytes_below(new / "cases")
        assert b"secret of a scan" not in left
        assert not check(new).fault
        assert next(line["n"] for line in lines_from(new)) == len(lines.splitlines()) + 1  # the newer log goes on
    assert main(["restore", file, str(tmp_path / "all"), "--audit", str(data), "--with-deleted"]) == 0
    assert f"{gone.id} was deleted since, and is here again" in capsys.readouterr().out
    assert CaseFolder(tmp_path / "all" / "cases" / gone.id).scan_ids()
    assert main(["restore", file, str(tmp_path / "blind")]) == 0
    assert "give --audit to find them" in capsys.readouterr().err
    other = tmp_path / "other"
    data_folder(other)
    AuditLog(other).append()
    assert main(["restore", file, str(tmp_path / "none"), "--audit", str(other)]) == 2
    assert "is not that of the backup, or is older" in capsys.readouterr().err
    assert not (tmp_path / "none" / "installation").exists()


def test_damage_and_wrong_words_leave_nothing_and_say_why(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    patient(data)
    file, new = tmp_path / "b.age", tmp_path / "new"
    assert main(["backup", str(file), str(data)]) == 0
    whole = file.read_bytes()
    for content, said in (
        (whole[:70_000] + bytes([whole[70_000] ^ 1]) + whole[70_001:], "The backup ends too early, or bytes"),
        (whole[: len(whole) // 2], "The backup"),
        (b"PK" + whole, "no backup of BreastRig"),
    ):
        file.write_bytes(content)
        assert main(["restore", str(file), str(new)]) == 2
        assert said in capsys.readouterr().err
        assert not list(new.iterdir())
    file.write_bytes(whole)
    (tmp_path / "words").write_text("not these words\n")
    assert main(["restore", str(file), str(new), "--passphrase-file", str(tmp_path / "words")]) == 2
    assert "The passphrase is not the one" in capsys.readouterr().err
    assert main(["restore", str(file), str(data)]) == 2
    assert "is restored into a new or empty folder" in capsys.readouterr().err
    assert main(["backup", str(file), str(data)]) == 2
    assert "is there already" in capsys.readouterr().err
    assert main(["backup", str(data / "b.age"), str(data)]) == 2
    assert "is lost with it" in capsys.readouterr().err
    monkeypatch.setenv("BREASTRIG_PASSPHRASE", "short")
    assert main(["backup", str(tmp_path / "c.age"), str(data)]) == 2
    assert "at least 12 characters" in capsys.readouterr().err
    monkeypatch.delenv("BREASTRIG_PASSPHRASE")
    assert main(["backup", str(tmp_path / "c.age"), str(data)]) == 2
    assert "nobody to type the passphrase" in capsys.readouterr().err
    assert not list(tmp_path.glob("*c.age*"))


def test_a_backup_that_does_not_come_back_gets_no_name(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    patient(data)
    monkeypatch.setattr(SealedWriter, "close", lambda _self: None)  # the last chunk is missing
    with pytest.raises(BadInput, match="The backup"):
        back_up(data, tmp_path / "b.age", WORDS, "shell:0")
    assert [each.name for each in tmp_path.iterdir()] == ["data"]
    assert not list((data / "incoming").iterdir())


def test_files_that_lead_outside_are_refused(tmp_path: Path) -> None:
    for name in ("cases/../../x", "/etc/x", "cases//x", "other/x", "cases"):
        with (tmp_path / "b.age").open("wb") as file:
            sealed = SealedWriter(file, WORDS)
            with tarfile.open(fileobj=sealed, mode="w|") as tar:
                tar.addfile(tarfile.TarInfo(name))
            sealed.close()
        with pytest.raises(BadInput, match="what BreastRig has not put there"):
            restore(tmp_path / "b.age", tmp_path / "new", WORDS, "shell:0")


def test_any_age_program_and_tar_read_it(data: Path, tmp_path: Path) -> None:
    case = patient(data)
    back_up(data, tmp_path / "b.age", WORDS, "shell:0")
    with (tmp_path / "b.age").open("rb") as file, tarfile.open(fileobj=SealedReader(file, WORDS), mode="r|") as tar:
        found = {entry.name: tar.extractfile(entry).read() for entry in tar}
    assert json.loads(found[MANIFEST])["cases"] == [case.id]
    assert found[f"cases/{case.id}/case.json"] == (case.path / "case.json").read_bytes()


def test_an_interrupted_restoring_begins_again(data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    patient(data)
    back_up(data, tmp_path / "b.age", WORDS, "shell:0")
    new = tmp_path / "new"
    (new / ".restoring" / "cases").mkdir(parents=True)  # as a kill leaves it
    (new / "cases" / "half").mkdir(parents=True)
    assert main(["purge", "--all", "--data", str(new)]) == 2  # no server and no purge takes it
    restore(tmp_path / "b.age", new, WORDS, "shell:0")
    assert contents(new) == contents(data)
    assert not (new / ".restoring").exists()

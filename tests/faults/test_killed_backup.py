"""Kills at random during backup, restore and deletion: nothing is lost, nothing is half there, and the log says it."""

import os
import random
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.cases import data_folder, new_case, new_fit, new_scan, note

from breastrig.audit.deletions import deletion
from breastrig.audit.log import AuditLog
from breastrig.audit.read import check, deletions
from breastrig.backup import age
from breastrig.backup.restore import restore
from breastrig.backup.write import back_up
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.plans import put_plan
from breastrig.cases.removal import delete_case, sweep
from breastrig.core.errors import NotFound
from breastrig.storage.data_folder import Ownership, ownership_of

WORDS = "correct horse battery staple"
FEW = 4
MANY = int(os.environ.get("BREASTRIG_KILLS", "20")) * 5


def killed(act: Callable[[], object], after_s: float) -> bool:
    """Does it in a process that is killed after that time; whether it had ended before."""
    child = os.fork()
    if child == 0:
        try:
            act()
            os._exit(0)
        finally:
            os._exit(1)
    time.sleep(after_s)
    os.kill(child, signal.SIGKILL)
    status = os.waitpid(child, 0)[1]
    assert os.WIFSIGNALED(status) or os.WEXITSTATUS(status) == 0
    return not os.WIFSIGNALED(status)


def contents(data: Path) -> dict[str, bytes]:
    files = [each for each in (data / "cases").rglob("*") if each.is_file() and each.name != ".lock"]
    return {each.relative_to(data).as_posix(): each.read_bytes() for each in files}


@pytest.mark.parametrize("kills", [FEW, pytest.param(MANY, marks=pytest.mark.soak)])
def test_nothing_is_lost(tmp_path: Path, kills: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(age, "WORK", 4)
    data, chance = tmp_path / "data", random.Random(kills)
    cases = [new_case(data_folder(data) if not data.exists() else data / "cases") for _ in range(6)]
    for case in cases:
        scan = new_scan(case, os.urandom(100_000))
        new_fit(case, scan)
        put_plan(case, [note(scan)])
    before = contents(data)
    began = time.monotonic()
    back_up(data, tmp_path / "whole.age", WORDS, "shell:0")
    longest = 1.2 * (time.monotonic() - began)
    for number in range(kills):
        file, new = tmp_path / f"{number}.age", tmp_path / f"new{number}"
        killed(lambda file=file: back_up(data, file, WORDS, "shell:0"), chance.uniform(0, longest))  # type: ignore[misc]
        assert contents(data) == before
        if file.exists():  # one that has its name is whole
            restore(file, tmp_path / f"trial{number}", WORDS, "shell:0")
            assert contents(tmp_path / f"trial{number}") == before
        killed(lambda new=new: restore(tmp_path / "whole.age", new, WORDS, "shell:0"), chance.uniform(0, longest / 2))  # type: ignore[misc]
        if ownership_of(new) is Ownership.OURS:
            assert contents(new) == before
        else:
            restore(tmp_path / "whole.age", new, WORDS, "shell:0")
            assert contents(new) == before
        assert not check(data).fault
    sweep(data)  # as the server does
    assert not list((data / "incoming").iterdir())

    began = time.monotonic()
    remove(data, cases.pop())
    longest = 1.2 * (time.monotonic() - began)
    for _ in range(kills):
        case = cases[-1] if len(cases) > 1 else new_case(data / "cases")
        case = cases.pop() if len(cases) > 1 else case
        killed(lambda case=case: remove(data, case), chance.uniform(0, longest))  # type: ignore[misc]
        sweep(data)
        try:
            CaseFolder(case.path)
        except NotFound:
            assert next(deletions(data, case.id))["of"] == {"patient": case.id}  # none goes unwritten
            assert not case.path.exists()
        AuditLog(data).append()
        assert not check(data).fault


def remove(data: Path, case: CaseFolder) -> None:
    with deletion(AuditLog(data), "shell:0", "case delete", case.path):
        delete_case(case)

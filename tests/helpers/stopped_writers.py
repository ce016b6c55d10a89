"""`python -m helpers.stopped_writers ACTION ROOT`: an action on cases is killed at each call that changes the disk.

A child process that dies like one that was killed, without tidying up, before the N-th change; then a sweep finishes
what it left, and all must be as before the action or as after it.  Prints how often it was killed.
"""

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from breastrig.cases.case_folder import CaseFolder, MadeScan
from breastrig.cases.documents import ScanDocument
from breastrig.cases.layout import CASES, RUBBISH, STORED, new_id
from breastrig.cases.plans import get_plan, plan_versions, put_plan, stored_plan
from breastrig.cases.removal import delete_scan, move_scan, move_to_new, sweep
from breastrig.core.errors import NotFound
from helpers.cases import FACTS, data_folder, new_case, new_scan, note

CHECKS = {"delete": "check_deleted", "move": "check_moved", "part": "check_parted", "arrive": "check_arrived"}
CHANGES = ("rename", "replace", "unlink", "rmdir", "link", "mkdir", "fsync", "utime", "remove")


def dying_at(step: int) -> None:
    """From now on the process ends without a word before the step-th change of the disk."""
    left = [step]

    def counted(real: Callable[..., Any]) -> Callable[..., Any]:
        def call(*given: Any, **more: Any) -> Any:
            if left[0] == 0:
                os._exit(9)
            left[0] -= 1
            return real(*given, **more)

        return call

    for name in CHANGES:
        setattr(os, name, counted(getattr(os, name)))


class Ward:
    """Two cases; the first has two scans, or one, and a plan with three versions."""

    def __init__(self, root: Path, alone: bool) -> None:
        self.root = root
        cases = data_folder(root)
        self.source, self.target = new_case(cases, "source"), new_case(cases, "target")
        self.there = new_scan(self.target)
        self.scan = new_scan(self.source, b"SKIN-OF-THE-SCAN")
        self.others = [] if alone else [new_scan(self.source)]
        items = [note(self.scan, "TEXT-OF-THE-SCAN", "one"), *(note(one, "of another") for one in self.others)]
        for _ in range(3):
            put_plan(self.source, items)
        put_plan(self.target, [note(self.there, "mine", "one")])

    def delete(self) -> None:
        delete_scan(self.source, self.scan)

    def move(self) -> None:
        move_scan(self.source, self.scan, self.target)

    def part(self) -> None:
        move_to_new(self.source, self.scan, self.root / CASES / new_id(), "new")

    def arrive(self) -> None:
        made = self.root / "made"
        made.mkdir()
        (made / STORED).write_bytes(b"SKIN")
        document = ScanDocument(created_at="2026-01-01T00:00:00.000Z", sha256="ab", facts=FACTS)
        CaseFolder.of_scan(self.root / CASES / new_id(), "new", MadeScan(new_id(), document, made))

    def check_deleted(self, before: bool) -> None:
        assert before or self.of_scan() == 0
        if self.others or before:
            assert self.source.scan_ids() == {*self.others, *([self.scan] if before else [])}
            assert len(get_plan(self.source).document.items) == len(self.others) + before
        else:
            assert not self.source.path.exists()

    def check_moved(self, before: bool) -> None:
        owner = self.source if before else self.target
        assert self.scan in owner.scan_ids()
        assert [item.id for item in get_plan(owner).document.items if item.scan == self.scan] != []
        assert self.scan not in (self.target.scan_ids() if before else self.source_scans())
        for case in (self.source, self.target):
            if case.path.exists() and self.scan not in case.scan_ids():
                versions = [get_plan(case, number).document for number in plan_versions(case)]
                assert all(item.scan != self.scan for plan in (*versions, stored_plan(case)) for item in plan.items)
        assert self.source.path.exists() == bool(before or self.others)

    def check_parted(self, before: bool) -> None:
        """The scan is in one case, with its item, and no case is empty."""
        [owner] = [case for case in self.cases() if self.scan in case.scan_ids()]
        assert (owner.path == self.source.path) == before
        assert any(item.scan == self.scan for item in get_plan(owner).document.items)
        assert len(self.cases()) == 2 + bool(not before and self.others)
        assert not list((self.root / CASES).glob("*/.new"))

    def check_arrived(self, _before: bool) -> None:
        assert all(case.scan_ids() for case in self.cases())

    def cases(self) -> list[CaseFolder]:
        return [CaseFolder(folder) for folder in (self.root / CASES).iterdir()]

    def source_scans(self) -> set[str]:
        try:
            return CaseFolder(self.source.path).scan_ids()
        except NotFound:
            return set()

    def of_scan(self) -> int:
        """Files that say anything of the scan."""
        content = [path.read_bytes() for path in self.root.rglob("*") if path.is_file()]
        return sum(b"OF-THE-SCAN" in each for each in content)


def main(action: str, root: Path) -> None:
    os.fsync = lambda _descriptor: None  # a killed process loses nothing of what the kernel has
    kills = 0
    for alone in (False, True) if action != "arrive" else (False,):  # which touches neither case
        step = 0
        while True:
            ward = Ward(root / f"{alone}-{step}", alone)
            child = os.fork()
            if child == 0:
                dying_at(step)
                getattr(ward, action)()
                os._exit(0)
            _, status = os.waitpid(child, 0)
            code = os.waitstatus_to_exitcode(status)
            assert code in (0, 9), (alone, step, code)
            assert sweep(ward.root) == []
            before = ward.scan in ward.source_scans()
            getattr(ward, CHECKS[action])(before)
            assert list((ward.root / RUBBISH).glob("*")) == [], (alone, step)
            assert not before or code == 9 or action == "arrive"
            assert all((folder / "case.json").is_file() for folder in (ward.root / CASES).iterdir())
            if code == 0:
                break
            kills, step = kills + 1, step + 1
    sys.stdout.write(str(kills))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))

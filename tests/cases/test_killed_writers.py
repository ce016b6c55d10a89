"""Writers that are killed at any moment lose nothing that was promised, and leave nothing that was deleted."""

import json
import os
import random
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from helpers.cases import data_folder, new_case, new_scan, note

from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.documents import etag_of
from breastrig.cases.fits import events_after, fits_of_scan
from breastrig.cases.plans import get_plan, plan_versions, stored_plan
from breastrig.cases.removal import sweep

WRITERS = 4
TRIALS = int(os.environ.get("BREASTRIG_KILLS", "20"))  # of the long run


def killed_writers(root: Path, seed: int) -> list[list[str]]:
    """What they had promised when all were killed."""
    chance = random.Random(seed)
    programs = [
        subprocess.Popen(
            [sys.executable, "-m", "helpers.case_writers", str(root), str(100 * seed + number)],
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": "tests"},
        )
        for number in range(WRITERS)
    ]
    for one in programs:
        assert one.stdout is not None
        assert one.stdout.readline() == '["ready"]\n'
    first = programs[0].stdout
    assert first is not None
    said = [json.loads(first.readline()) for _ in range(chance.randrange(10, 20))]
    time.sleep(chance.uniform(0.0, 0.05))
    for one in programs:
        one.kill()
    for one in programs:
        lines = one.communicate()[0].splitlines(keepends=True)
        said += [json.loads(line) for line in lines if line.endswith("\n")]
    return said


def check(root: Path, said: list[list[str]]) -> Counter[str]:
    """After a sweep: nothing that was promised is lost, nothing that was deleted is left."""
    assert sweep(root) == []
    kept = {case.path.name: case for case in map(CaseFolder, sorted((root / layout.CASES).iterdir()))}
    owner = Counter(scan for case in kept.values() for scan in case.scan_ids())
    assert not owner or max(owner.values()) == 1
    deleted = {one[2] for one in said if one[0] == "deleted"}
    assert deleted.isdisjoint(owner)
    content = b"".join(path.read_bytes() for path in root.rglob("*") if path.is_file())
    assert not [scan for scan in deleted if scan.encode() in content]
    assert list((root / layout.RUBBISH).glob("*")) == []
    for case in kept.values():
        for number in plan_versions(case):
            plan = get_plan(case, number).document
            assert plan.version == number
        stored = stored_plan(case).items
        assert {item.scan for item in stored} <= case.scan_ids()
        for scan in case.scan_ids():
            for fit in fits_of_scan(case, scan):
                folder = case.path / layout.fit_part(scan, fit.id)
                kinds = [json.loads(line)["kind"] for _, line in events_after(folder)]
                assert sum(kind in ("done", "failed", "cancelled") for kind in kinds) <= 1
    for what, case_id, *more in said:
        if what == "scan":  # it may have been deleted since, and its writer killed before that was said
            assert owner[more[0]] or more[0].encode() not in content
        if what == "plan" and case_id in kept:
            assert get_plan(kept[case_id]).document.version >= int(more[0])
        if what in ("fit", "ended") and owner[more[0]]:
            [home] = [case for case in kept.values() if more[0] in case.scan_ids()]
            found = {fit.id: fit.state for fit in fits_of_scan(home, more[0])}
            assert more[1] in found
            assert what == "fit" or found[more[1]] == more[2]
    return Counter(one[0] for one in said)


def test_nothing_that_was_promised_is_lost_when_all_writers_are_killed(tmp_path: Path) -> None:
    data_folder(tmp_path)
    said = killed_writers(tmp_path, 1)
    counts = check(tmp_path, said)
    assert counts["plan"] > 0
    assert counts["scan"] > 0


@pytest.mark.soak
def test_many_times(tmp_path: Path) -> None:
    data_folder(tmp_path)
    said, total = [], Counter[str]()
    for seed in range(TRIALS):
        said += killed_writers(tmp_path, seed)
        total = check(tmp_path, said)
    assert all(total[what] > TRIALS for what in ("plan", "fit", "scan", "deleted", "ended"))


TAB = """
import sys
from pathlib import Path
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.documents import etag_of
from breastrig.cases.plans import get_plan, put_plan
from breastrig.cases.writing import Changed
from breastrig.drawings.plan_schema import PlanNote
case, scan, name, wanted = CaseFolder(Path(sys.argv[1])), sys.argv[2], sys.argv[3], int(sys.argv[4])
written = 0
while written < wanted:
    seen = get_plan(case)
    item = PlanNote(id=f"{name}-{written}", scan=scan, text="a note")
    try:
        put_plan(case, [*seen.document.items, item], seen.etag)
        written += 1
    except Changed:
        pass
"""


def test_of_two_processes_at_one_plan_each_takes_over_what_the_other_wrote(tmp_path: Path) -> None:
    case = new_case(data_folder(tmp_path))
    scan = new_scan(case)
    tabs = [
        subprocess.Popen([sys.executable, "-c", TAB, str(case.path), scan, name, "20"]) for name in ("one", "other")
    ]
    assert [tab.wait(timeout=120) for tab in tabs] == [0, 0]
    found = get_plan(case)
    names = {f"{name}-{k}" for name in ("one", "other") for k in range(20)}
    assert {item.id for item in found.document.items} == names
    assert found.document.version == 40
    assert found.etag == etag_of((case.path / layout.PLAN).read_bytes())
    assert note(scan).scan == scan

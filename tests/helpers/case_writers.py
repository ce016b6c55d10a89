"""`python -m helpers.case_writers ROOT NUMBER`: writes into the cases of a data folder until it is killed.

Each line says what is promised by then, as JSON: [what, case, scan, fit or version].
"""

import json
import random
import sys
from pathlib import Path

from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.documents import FitDocument
from breastrig.cases.fits import added, claimed, fits_of_scan, get_fit
from breastrig.cases.layout import CASES
from breastrig.cases.plans import get_plan, put_plan
from breastrig.cases.removal import delete_scan, move_scan
from breastrig.cases.writing import Changed
from breastrig.core.errors import BadInput, Conflict, NotFound
from helpers.cases import new_case, new_scan, note


def say(*words: object) -> None:
    sys.stdout.write(json.dumps(words) + "\n")
    sys.stdout.flush()


def skin(scan: str) -> bytes:
    return b"SKIN-" + scan.encode()


def act(cases: Path, chance: random.Random) -> None:
    found = sorted(folder for folder in cases.iterdir() if folder.is_dir())
    what = chance.random()
    if len(found) < 3 or what < 0.1:
        case = new_case(cases)
        scan = new_scan(case)
        (case.scan_folder(scan) / "mesh.glb").write_bytes(skin(scan))
        say("scan", case.id, scan)
        return
    case = CaseFolder(chance.choice(found))
    scans = sorted(case.scan_ids())
    scan = chance.choice(scans) if scans else ""
    if not scans or what < 0.2:
        scan = new_scan(case)
        (case.scan_folder(scan) / "mesh.glb").write_bytes(skin(scan))
        say("scan", case.id, scan)
    elif what < 0.6:
        seen = get_plan(case)
        items = [item for item in seen.document.items if item.kind == "note"][-5:]
        plan = put_plan(case, [*items, note(scan, f"TEXT-{scan}")], seen.etag)
        say("plan", case.id, plan.document.version)
    elif what < 0.75:
        with added(case, scan, FitDocument(asked_at="2026-01-02T00:00:00.000Z")) as asked:
            say("fit", case.id, scan, asked.fit_id)
    elif what < 0.85:
        for fit in fits_of_scan(case, scan):
            with claimed(case, scan, fit.id) as claim:
                if claim is not None:
                    for event in ({"kind": "started"}, {"kind": "iterated"}, {"kind": "done"}):
                        claim.append(event)
                    say("ended", case.id, scan, fit.id, get_fit(case, scan, fit.id).state)
    elif what < 0.93:
        move_scan(case, scan, CaseFolder(chance.choice(found)))
    elif scan:
        delete_scan(case, scan)
        say("deleted", case.id, scan)


def main(root: Path, number: int) -> None:
    chance = random.Random(number)
    say("ready")
    while True:
        try:
            act(root / CASES, chance)
        except (Changed, NotFound, Conflict, BadInput, FileNotFoundError):  # another writer was quicker
            continue


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))

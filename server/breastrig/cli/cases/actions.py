"""The actions of `breastrig case`: each takes its options and returns the exit code."""

import argparse
from contextlib import nullcontext

from breastrig.audit.deletions import deletion
from breastrig.audit.log import log_of_case
from breastrig.cases import layout
from breastrig.cases.case_folder import CaseFolder
from breastrig.cli.cases.audited import shell
from breastrig.cli.messages.progress import fitted
from breastrig.cli.messages.say import say
from breastrig.cli.options.output_options import writing_file
from breastrig.cli.options.scan_options import say_segments
from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadInput, NotFound
from breastrig.core.private_files import shown
from breastrig.drawings.drawing_file import drawing_document
from breastrig.scan.true_size import length_of
from breastrig.scan.volumes.answers import segments_of_words
from breastrig.use.cases.case import Case, CaseScan

IN_TRUE_SIZE = (
    "The places were taken in the true size of this scan, {:.3f} times that of its own file. If they were "
    "picked on that file: case length --remove, case landmarks, then case length --put."
)


def create(options: argparse.Namespace) -> int:
    case = Case.create(options.case, options.code)
    options.made = {"patient": case.path.name}
    print(f"{case.code} in {case.path}")
    return 0


def add(options: argparse.Namespace) -> int:
    case = Case(options.case)
    scan_id = case.add_scan(
        options.scan,
        options.units,
        model=options.model,
        frame=options.frame,
        segments=segments_of_words(options.segment) or None,
        series=options.series,
        same_place=options.same_place,
        again=options.again,
    )
    options.made = {"scan": scan_id}
    numbers = {scan.id: number for number, scan in enumerate(case.scans, start=1)}
    scan = next(each for each in case.scans if each.id == scan_id)
    say(*scan.notes)
    print(f"scan {numbers[scan_id]}: {_about(scan)}")
    return 0


def lesions(options: argparse.Namespace) -> int:
    case = Case(options.case)
    scan = _chosen(case, options.scan)
    taken = case.add_lesions(
        scan.id,
        options.file,
        frame=options.frame,
        segments=segments_of_words(options.segment) or None,
        same_place=options.same_place,
    )
    say_segments(taken.segments)
    say(*taken.notes)
    for each in taken.lesions:
        print(f"{each.name}: {2 * each.radius:.0f} mm across{'' if each.is_new else ', in the plan already'}")
    if not taken.lesions:
        print("no lesions")
    return 0


def landmarks(options: argparse.Namespace) -> int:
    case = Case(options.case)
    scan = _chosen(case, options.scan)
    case.put_landmarks(scan.id, options.landmarks)
    if scan.scale != 1.0:
        say(IN_TRUE_SIZE.format(scan.scale))
    marks = len(case.marks(scan.id))
    print(f"{len(case.landmarks(scan.id))} landmarks{f', {marks} marks' if marks else ''}")
    return 0


def length(options: argparse.Namespace) -> int:
    case = Case(options.case)
    scan = _chosen(case, options.scan)
    if options.remove:
        case.delete_length(scan.id)
        print("the size of its file")
        return 0
    given = length_of(options.put)
    assert given is not None
    case.put_length(scan.id, given.start, given.end, given.mm)
    print(next(each.notes[-1] for each in case.scans if each.id == scan.id))
    return 0


def visit(options: argparse.Namespace) -> int:
    case = Case(options.case)
    scan = _chosen(case, options.scan)
    case.put_visit(scan.id, options.date, options.label)
    print(_about(next(each for each in case.scans if each.id == scan.id)))
    return 0


def fit(options: argparse.Namespace) -> int:
    case = Case(options.case)
    scan = _chosen(case, options.scan)
    drawing = None if options.drawing == "none" else options.drawing
    run = case.fitting(scan.id, stance=options.stance, preset=options.preset, drawing=drawing, refine=options.refine)
    try:
        fit = fitted(run)
    finally:
        run.close()
    for reason in fit.verdict.reasons:
        say(f"{fit.verdict.level}: {reason}")
    print(f"{fit.verdict.level}, {fit.stance}; {case.fits(scan.id)[-1].folder}")
    return 3 if fit.verdict.level == "unusable" else 0


def predict(options: argparse.Namespace) -> int:
    """Predicts another stance from the scan's newest finished fit."""
    case = Case(options.case)
    scan = _chosen(case, options.scan)
    done = [fit for fit in case.fits(scan.id) if fit.state == "done" and fit.predicted_from is None]
    if not done:
        raise NotFound("This scan has no fit that is done; fit it with `breastrig case fit`.")
    found = case.predict(done[-1].id, options.stance)
    print(f"{found.verdict.level}, {found.stance}, predicted from {done[-1].id}; {case.fits(scan.id)[-1].folder}")
    return 0


def plan(options: argparse.Namespace) -> int:
    case = Case(options.case)
    if options.output is not None:
        if options.seen or options.scan or options.same_patient:
            raise BadInput("--seen, --scan and --same-patient belong to --put and --undo; leave them out with -o.")
        content = json_bytes(case.plan(options.version))
        with writing_file(options) as write:
            write(content)
        return 0
    if options.version is not None or options.force:
        raise BadInput("--version and --force belong to -o; --undo takes the number of a version itself.")
    if options.undo is not None:
        number = case.undo(options.undo, options.seen)
    else:
        scan = _chosen(case, options.scan).id if options.scan else ""
        number = case.put_plan(
            drawing_document(options.put), options.seen, scan=scan, same_patient=options.same_patient
        )
    print(f"version {number}")
    return 0


def show(options: argparse.Namespace) -> int:
    case = Case(options.case)
    plan = case.plan()
    print(f"{case.code}   plan: version {plan['version']}, {len(plan['items'])} items, seen {case.plan_etag}")
    for number, scan in enumerate(case.scans, start=1):
        print(f"scan {number}: {_about(scan)}")
        for fit in case.fits(scan.id):
            said = ", ".join(part for part in (fit.verdict, fit.stance, fit.reason) if part)
            kind = "fit" if fit.predicted_from is None else "prediction"
            print(f"  {kind} of {fit.asked_at[:16]}: {fit.state}{said and ', '}{said}   {fit.id}")
    return 0


def _about(scan: CaseScan) -> str:
    scaled = "" if scan.scale == 1.0 else f", scaled by {scan.scale:.3f}"
    visit = ", ".join(filter(None, (scan.visit.date, scan.visit.label)))
    said = f", visit {visit}" if visit else ""
    return f"{scan.created_at[:10]}, {scan.stance}{said}, {scan.triangles:,} triangles, {scan.unit}{scaled}   {scan.id}"


def list_cases(options: argparse.Namespace) -> int:
    folder = options.case / layout.CASES if (options.case / layout.MARK).is_file() else options.case
    if not folder.is_dir():
        raise NotFound(f"There is no folder {shown(folder)}; check the name.")
    found = 0
    for each in sorted(folder.iterdir()):
        if (each / layout.CASE).is_file():
            case = CaseFolder(each)
            document = case.document()
            found += 1
            print(f"{document.code}   {document.created_at[:10]}, {len(case.scan_ids())} scans   {each}")
    if not found:
        say(f"there is no case in {shown(folder)}")
    return 0


def rename(options: argparse.Namespace) -> int:
    case = Case(options.case)
    case.rename(options.code)
    print(case.code)
    return 0


def move(options: argparse.Namespace) -> int:
    case = Case(options.case)
    scan = _chosen(case, options.scan)
    case.move_scan(scan.id, Case(options.target), again=options.again)
    return 0


def delete(options: argparse.Namespace) -> int:
    case = Case(options.case)
    scan = "" if options.all else _chosen(case, options.scan).id
    log = log_of_case(case.path)
    with nullcontext() if log is None else deletion(log, shell(), "case delete", case.path, scan):
        if scan:
            case.delete_scan(scan)
        else:
            case.delete()
    return 0


def _chosen(case: Case, name: str) -> CaseScan:
    """The scan by its number or id; without a name the only one."""
    scans = case.scans
    if not scans:
        raise NotFound("This case has no scan yet; add one with `breastrig case add`.")
    if name == "":
        if len(scans) > 1:
            raise BadInput(
                f"This case has {len(scans)} scans; say which with --scan (`breastrig case show` lists them)."
            )
        return scans[0]
    if name.isdecimal() and 1 <= int(name) <= len(scans):
        return scans[int(name) - 1]
    found = next((scan for scan in scans if scan.id == name), None)
    if found is None:
        raise NotFound(f"This case has no scan {name[:40]}; `breastrig case show` lists its scans.")
    return found

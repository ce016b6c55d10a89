"""Measures of one fit, or of two stances of one patient, as JSON, CSV and PDF with a tape sheet of the drawing."""

import argparse
from pathlib import Path

from threadpoolctl import threadpool_limits

from breastrig.cli.earlier_fits import unchecked
from breastrig.cli.output_options import (
    add_output_options,
    add_same_patient,
    files_of_fit,
    files_of_model,
    output_folder,
    say_misfits,
)
from breastrig.core import wall_clock
from breastrig.core.assets import model_path
from breastrig.core.identity import SAYS_NOTHING, Identity, file_name, random_code
from breastrig.core.output_files import OutputSet, all_or_nothing
from breastrig.files.result import ResultPatient, read_result
from breastrig.report.document import SCHEMA
from breastrig.report.pages.printable import checked_code
from breastrig.workflow.jobs import ReportJob
from breastrig.workflow.lines.transfer import drawing_document
from breastrig.workflow.report import MEASURES_TABLE, REPORT_RECORD, write_report


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "fit", type=Path, metavar="OUT", help="folder that `breastrig fit` wrote, with or without --with"
    )
    parser.add_argument(
        "--with", dest="other", type=Path, metavar="OUT_B", help="fit of the same patient in another stance"
    )
    parser.add_argument(
        "--plan", type=Path, metavar="FILE", help="plan or drawing that is shown instead of the fit's own drawing"
    )
    parser.add_argument(
        "--code",
        default="",
        metavar="CODE",
        help="the patient's code, never a name, on every page and in the PDF's name; by default that of the fit",
    )
    parser.add_argument("--model", type=model_path, metavar="MODEL", help="the rig that the fits were made with")
    add_same_patient(parser)
    add_output_options(parser, "DIR", "folder for the three files")


def run(options: argparse.Namespace) -> int:
    """Writes report.json, measures.csv and the PDF; returns 0, or 4 where something is not drawn."""
    fit, other = _stances(options)
    inputs = [options.plan, *files_of_fit(fit), *files_of_fit(other), *files_of_model(options.model)]
    plan = None if options.plan is None else drawing_document(options.plan)
    results = [read_result(folder) for folder in (fit, other) if folder is not None]
    known = [result.patient or ResultPatient() for result in results]
    code = (
        checked_code(options.code) or next((each.code for each in known if each.given), known[0].code) or random_code()
    )
    scanned = tuple(each.scanned.isoformat() if each.scanned else "" for each in known)
    version = 0 if plan is None else plan.get("version", 0)
    identity = Identity(code, wall_clock.now(), scanned, plan_version=version if isinstance(version, int) else 0)
    codes = {each.code for each in known if each.given}
    doubts: tuple[str, ...] = (
        (f"The fits carry two codes ({', '.join(sorted(codes))}); {SAYS_NOTHING}",) if len(codes) > 1 else ()
    )
    doubts += unchecked((fit, other))
    pdf = file_name(code, " ".join(each.stance for each in results), identity.day, "report.pdf")
    files = OutputSet(Path(), (MEASURES_TABLE, pdf, REPORT_RECORD), REPORT_RECORD, SCHEMA, varying=True)
    with threadpool_limits(1), all_or_nothing(output_folder(options, [files], inputs)) as out:
        job = ReportJob(
            fit, other, options.model, plan=plan, same_patient=options.same_patient, identity=identity, doubts=doubts
        )
        missing = write_report(job, out, pdf)
    return say_misfits(missing)


def _stances(options: argparse.Namespace) -> tuple[Path, Path | None]:
    """The folder or folders of the fits; an earlier version's fit of two stances left both in one."""
    fit: Path = options.fit
    if options.other is None and (fit / "pair.json").is_file():
        return fit / "first", fit / "second"
    return fit, options.other

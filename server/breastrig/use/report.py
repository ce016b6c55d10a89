"""Reports of fits, for programs and the command line."""

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from breastrig.core import wall_clock
from breastrig.core.identity import SAYS_NOTHING, Identity, file_name, random_code
from breastrig.core.one_thread import one_thread
from breastrig.core.output_files import Output, OutputSet, all_or_nothing
from breastrig.drawings.drawing_file import drawing_document
from breastrig.files.result import FIT_FILES, ResultFile, ResultPatient, read_result
from breastrig.languages.catalogue import Language
from breastrig.report.document import SCHEMA
from breastrig.report.pages.printable import checked_code
from breastrig.use.folder.earlier_fits import unchecked
from breastrig.use.reports.report import MEASURES_TABLE, REPORT_RECORD, ReportJob, write_three_files
from breastrig.use.transfer import folder_of
from breastrig.use.values.drawing import Drawing
from breastrig.use.values.fit_result import Fit
from breastrig.use.values.model import Model, files_of, loaded


def write_report(
    fit: Fit | str | Path,
    folder: str | Path,
    other: Fit | str | Path | None = None,
    *,
    plan: Drawing | Mapping[str, Any] | str | Path | None = None,
    code: str = "",
    same_patient: bool = False,
    language: Language = "en",
    force: bool = False,
    model: Model = None,
    asked_to_stop: Callable[[], None] = lambda: None,
) -> tuple[str, ...]:
    """Writes report.json, measures.csv (mm and ml) and a PDF of a fit, as `breastrig report` does.

    Args:
        fit: The fit, or its folder.
        folder: Where the three files are written, all or none of them.
        other: Of the same patient in another stance; what changes between both is reported.
        plan: A drawing in a fit's unit and frame, a document breastrig/plan@1 or drawing@1 or the path of one, in place
            of the fit's own drawing.
        code: The patient's code, never a name; empty: that of the fit.
        same_patient: Whether the plan is this patient's though its file names another.
        language: Of the PDF: en or de.
        force: Replaces files that are no earlier report; never what was read.
        model: Of folders, where it is not the package's; a `Fit` has its own.
        asked_to_stop: Called before the files are put in place; it may raise.

    Returns:
        Why patterns and items of the plan are not drawn, a sentence each.

    Raises:
        BadInput: With one sentence.
    """
    document = plan_of(plan)
    with ExitStack() as stack:
        folders = [stack.enter_context(folder_of(each, FIT_FILES)) for each in (fit, other) if each is not None]
        results = [read_result(each) for each in folders]
        identity = identity_of(results, code, document)
        pdf = file_name(identity.code, " ".join(each.stance for each in results), identity.day, "report.pdf")
        files = OutputSet(Path(), (MEASURES_TABLE, pdf, REPORT_RECORD), REPORT_RECORD, SCHEMA, varying=True)
        given = [Path(each) / name for each in (fit, other) if isinstance(each, str | Path) for name in FIT_FILES]
        given += [Path(plan)] if isinstance(plan, str | Path) else []
        output = Output(Path(folder), (files,), (*given, *files_of(model)), force, asked_to_stop)
        job = ReportJob(
            folders[0],
            folders[1] if len(folders) > 1 else None,
            None,
            plan=document,
            same_patient=same_patient,
            language=language,
            identity=identity,
            doubts=(*_two_codes(results), *unchecked(each for each in (fit, other) if isinstance(each, str | Path))),
        )
        with one_thread(), all_or_nothing(output) as staging:
            return write_three_files(job, staging, pdf, fit.model if isinstance(fit, Fit) else loaded(model))


def plan_of(plan: Drawing | Mapping[str, Any] | str | Path | None) -> dict[str, Any] | None:
    if isinstance(plan, str | Path):
        return drawing_document(Path(plan))
    return None if plan is None else dict(plan.document if isinstance(plan, Drawing) else plan)


def identity_of(results: list[ResultFile], code: str, plan: dict[str, Any] | None) -> Identity:
    """Code, days and the plan's version, as far as they are known."""
    known = [result.patient or ResultPatient() for result in results]
    code = checked_code(code) or next((each.code for each in known if each.given), known[0].code) or random_code()
    scanned = tuple(each.scanned.isoformat() if each.scanned else "" for each in known)
    version = 0 if plan is None else plan.get("version", 0)
    return Identity(code, wall_clock.now(), scanned, plan_version=version if isinstance(version, int) else 0)


def _two_codes(results: list[ResultFile]) -> tuple[str, ...]:
    codes = {each.patient.code for each in results if each.patient and each.patient.given}
    return (f"The fits carry two codes ({', '.join(sorted(codes))}); {SAYS_NOTHING}",) if len(codes) > 1 else ()

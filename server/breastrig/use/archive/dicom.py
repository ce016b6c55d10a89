"""A fit as DICOM objects, written or sent: for programs and the command line."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadInput
from breastrig.core.one_thread import one_thread
from breastrig.core.output_files import Output, OutputSet, all_or_nothing
from breastrig.core.private_files import write_files
from breastrig.files.result import FIT_FILES, read_result
from breastrig.use.archive.objects import MISSING, dicom_files, objects_of
from breastrig.use.folder.earlier_fits import unchecked
from breastrig.use.report import identity_of, plan_of
from breastrig.use.reports.report import ReportJob
from breastrig.use.transfer import folder_of
from breastrig.use.values.drawing import Drawing
from breastrig.use.values.fit_result import Fit
from breastrig.use.values.model import Model, files_of, loaded

if TYPE_CHECKING:
    from pydicom.dataset import Dataset

RECORD = "dicom.json"
SCHEMA = "breastrig/dicom@1"
Plan = Drawing | Mapping[str, Any] | str | Path | None


def write_dicom(
    fit: Fit | str | Path,
    folder: str | Path,
    *,
    plan: Plan = None,
    code: str = "",
    identities: str | Path | None = None,
    same_patient: bool = False,
    force: bool = False,
    model: Model = None,
    asked_to_stop: Callable[[], None] = lambda: None,
) -> None:
    """Writes a fit as DICOM objects of one study, as `breastrig dicom` does: report.dcm (PDF), measures.dcm (TID 1500),
    skin.dcm and scan.dcm (STL, mm, to the patient's left, back and head), and dicom.json with their UIDs.

    Args:
        fit: The fit, or its folder.
        folder: Where the files are written, all or none of them.
        plan: A drawing in the fit's unit and frame, a document breastrig/plan@1 or drawing@1 or the path of one, in
            place of the fit's own drawing.
        code: The patient's code, never a name; empty: that of the fit.
        identities: The hospital's file (CSV or TOML) that says who the code is; without it the code is the PatientID.
        same_patient: Whether the plan is this patient's though its file names another.
        force: Replaces files that are no earlier result; never what was read.
        model: Of a folder, where it is not the package's; a `Fit` has its own.
        asked_to_stop: Called before the files are put in place; it may raise.

    Raises:
        BadInput: With one sentence.
    """
    names = (*(f"{name}.dcm" for name in ("report", "measures", "skin", "scan")), RECORD)
    files = OutputSet(Path(), names, RECORD, SCHEMA, varying=True)
    read = [Path(fit) / name for name in FIT_FILES] if isinstance(fit, str | Path) else []
    read += [Path(each) for each in (plan, identities) if isinstance(each, str | Path)]
    output = Output(Path(folder), (files,), (*read, *files_of(model)), force, asked_to_stop)
    with all_or_nothing(output) as staging, _objects(fit, plan, code, identities, same_patient, model) as objects:
        uids = {name: str(each.SOPInstanceUID) for name, each in objects.items()}
        write_files(dicom_files(objects) | {RECORD: json_bytes({"schema": SCHEMA, "objects": uids})}, staging)


def send_dicom(
    fit: Fit | str | Path,
    *,
    plan: Plan = None,
    code: str = "",
    identities: str | Path | None = None,
    same_patient: bool = False,
    model: Model = None,
    **archive: Any,
) -> tuple[str, ...]:
    """Sends the same objects (surfaces in mm) to an archive, as `breastrig dicom --send` and `--stow` do.

    Args:
        fit: The fit, or its folder; this and what follows as in `write_dicom`.
        plan: Likewise.
        code: Likewise.
        identities: Likewise.
        same_patient: Likewise.
        model: Likewise.
        archive: `dicom` ("AE@HOST:PORT", C-STORE) or `stow` (an address, STOW-RS); `calling` (our AE title), `tls`,
            `ca`, `certificate`, `authorization` (files), `objects` (of report, measures, skin and scan).

    Returns:
        What the archive noted of objects that it stored, a sentence each.

    Raises:
        BadInput: With one sentence; before anything is sent.
        NotSent: Which objects are stored and which are not, and why.
    """
    try:
        from breastrig.archive.nodes import node
        from breastrig.archive.send import send
    except ModuleNotFoundError as error:
        raise BadInput(MISSING) from error
    to = node(**archive)
    with _objects(fit, plan, code, identities, same_patient, model) as objects:
        return send(objects, to)


@contextmanager
def _objects(
    fit: Fit | str | Path,
    plan: Plan,
    code: str,
    identities: str | Path | None,
    same_patient: bool,
    model: Model,
) -> "Iterator[dict[str, Dataset]]":
    document = plan_of(plan)
    with folder_of(fit, FIT_FILES) as here, one_thread():
        result = read_result(here)
        if not code and (result.patient is None or not result.patient.code):
            raise BadInput("This fit carries no code of a patient, which DICOM objects need; give one with --code.")
        job = ReportJob(
            here,
            plan=document,
            same_patient=same_patient,
            identity=identity_of([result], code, document),
            doubts=unchecked([fit] if isinstance(fit, str | Path) else []),
        )
        rig = fit.model if isinstance(fit, Fit) else loaded(model)
        yield objects_of(job, None if identities is None else Path(identities), rig)

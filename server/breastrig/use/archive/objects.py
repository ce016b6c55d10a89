"""The DICOM objects of a fit's folder."""

import hashlib
import io
import zipfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from datetime import date, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from breastrig.archive.patient_frame import moved, to_patient
from breastrig.core.errors import BadInput
from breastrig.files.result import RESULT, result_text
from breastrig.report.document import stance_said
from breastrig.report.table import flat_rows
from breastrig.rig.model import Rig
from breastrig.use.reports.report import ReportJob, pdf_of, reported

if TYPE_CHECKING:
    from pydicom.dataset import Dataset


MISSING = 'DICOM needs further libraries: pip install "breastrig[pacs]".'


def objects_of(job: ReportJob, identities: Path | None = None, rig: Rig | None = None) -> "dict[str, Dataset]":
    """The objects of the job's fit by name: report, measures, skin and, unless the position is predicted, scan.

    `identities` is the hospital's file of codes.  BadInput for a folder that is no fit, a fit that cannot be used, and
    a code that the file does not name.
    """
    try:
        from breastrig.archive.identities import patient_of
        from breastrig.archive.objects import Contents, dicom_objects
    except ModuleNotFoundError as error:
        raise BadInput(MISSING) from error

    patient = patient_of(job.identity.code, identities)
    job = replace(job, identity=replace(job.identity, made=None))  # the same pages each time
    one = reported(job, rig)[0]
    result, stance = one.result, one.stance
    if result.verdict is not None and result.verdict.level == "unusable":
        raise BadInput(f"This fit cannot be used: {' '.join(result.verdict.reasons)} No DICOM object is made of it.")
    matrix = to_patient(stance, result)
    surfaces = {"skin": (moved(matrix, stance.vertices), stance.rig.faces)}
    if not stance.predicted:
        surfaces["scan"] = (moved(matrix, stance.scan_vertices), stance.scan_faces)
    return dicom_objects(
        Contents(
            patient=patient,
            scan=result.scan.sha256,
            fit=hashlib.sha256(result_text(job.fit)).hexdigest(),
            rig=result.model.sha256,
            stance=stance_said(result),
            quality="" if result.verdict is None else result.verdict.level,
            scanned=None if job.identity.received else _day(job.identity.scanned),
            made=datetime.fromtimestamp((job.fit / RESULT).stat().st_mtime),
            pdf=pdf_of([one], job),
            surfaces=surfaces,
            rows=flat_rows([(one.name, one.rows)]),
        )
    )


def _day(scanned: tuple[str, ...]) -> date | None:
    with suppress(ValueError, IndexError):
        return date.fromisoformat(scanned[0])
    return None


def dicom_files(objects: "Mapping[str, Dataset]") -> dict[str, bytes]:
    """The objects as files, by file name."""
    from pydicom import dcmwrite

    files = {}
    for name, each in objects.items():
        dcmwrite(written := io.BytesIO(), each, enforce_file_format=True)
        files[f"{name}.dcm"] = written.getvalue()
    return files


def dicom_zip_of(job: ReportJob, identities: Path | None = None) -> bytes:
    """The files in a zip: what the service's worker makes."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as files:
        for name, content in dicom_files(objects_of(job, identities)).items():
            files.writestr(name, content)
    return packed.getvalue()

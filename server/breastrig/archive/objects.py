"""One fit as DICOM objects of one study: the report (PDF), scan and fitted skin (STL), and its measures (TID 1500).

UIDs follow from the patient's ID and from what an object says, so that an archive that has an object already gets it
again and not a second one; another plan or another patient's ID makes other objects.
"""

import hashlib
import json
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date, datetime
from typing import Any

import highdicom
from pydicom.dataset import Dataset
from pydicom.sr.codedict import codes
from pydicom.sr.coding import Code
from pydicom.uid import (
    UID,
    Comprehensive3DSRStorage,
    EncapsulatedPDFStorage,
    EncapsulatedSTLStorage,
    ExplicitVRLittleEndian,
)

from breastrig.archive.identities import Patient
from breastrig.archive.measurements import SCHEME, measurement_report
from breastrig.core.arrays import Array, Integers
from breastrig.core.notice import RESEARCH_USE_ONLY
from breastrig.core.version import __version__
from breastrig.report.files.geometry_files import surface_stl
from breastrig.report.table import Cell

NAMESPACE = uuid.UUID("0b5b7a3e-6d53-5c0e-9a53-2f6f0c1b7d55")
MAKER = "BreastRig"
RESEARCH = "research use only"  # in each series' description
STL = "model/stl"
UTF_8 = "ISO_IR 192"
PSEUDONYM = "The hospital keeps its own list of codes"  # DeidentificationMethod
NUMBERS = {"report": 1, "measures": 2, "skin": 3, "scan": 4}  # of series, in the order in which objects are sent
CLASSES = {
    "report": EncapsulatedPDFStorage,
    "measures": Comprehensive3DSRStorage,
    "skin": EncapsulatedSTLStorage,
    "scan": EncapsulatedSTLStorage,
}


@dataclass(frozen=True, eq=False)
class Contents:
    """What is said of one fit."""

    patient: Patient
    scan: str  # digest of the scan's file
    fit: str  # digest of result.json
    rig: str  # digest of the model
    stance: str  # standing; supine, predicted
    quality: str  # level of the verdict; empty: not known
    scanned: date | None
    made: datetime  # when the fit was
    pdf: bytes
    surfaces: Mapping[str, tuple[Array, Integers]]  # skin, and scan where there is one: (V, 3) m LPS, (F, 3)
    rows: Sequence[Mapping[str, Cell]]  # of the table of measures


def uid(*parts: str) -> UID:
    """2.25 and a UUID of the parts."""
    return UID(f"2.25.{uuid.uuid5(NAMESPACE, json.dumps(parts)).int}")


def dicom_objects(said: Contents) -> dict[str, Dataset]:
    """The objects by name: report, measures, skin and, unless the position is predicted, scan."""
    found: dict[str, Dataset] = {
        name: _encapsulated(said, name, surface_stl(vertices, faces, 1e-3), STL)
        for name, (vertices, faces) in said.surfaces.items()
    }
    found["measures"] = _measures(said, list(found.values()))
    found["report"] = _encapsulated(said, "report", said.pdf, "application/pdf")
    for each in found.values():
        del each.InstanceCreationDate, each.InstanceCreationTime  # when it was sent first is the archive's to say
        each.StudyDescription = f"{MAKER} 3D breast scan ({RESEARCH})"
        each.ContentDate, each.ContentTime = said.made.strftime("%Y%m%d"), said.made.strftime("%H%M%S")
        if said.patient.is_code:
            each.PatientIdentityRemoved, each.DeidentificationMethod = "YES", PSEUDONYM
    return {name: found[name] for name in NUMBERS if name in found}


def _common(said: Contents, name: str, digest: str) -> dict[str, Any]:
    """The arguments of highdicom's classes that all objects share."""
    study = uid("study", said.patient.id, said.scan)
    return {
        "series_instance_uid": uid("series", study, said.fit, name),
        "series_number": NUMBERS[name],
        "sop_instance_uid": uid("object", study, said.fit, name, digest),
        "instance_number": 1,
        "manufacturer": MAKER,
        "manufacturer_model_name": MAKER,
        "software_versions": __version__,
        "device_serial_number": said.rig[:16],
        "series_description": f"{MAKER} {name}, {said.stance} ({RESEARCH})",
        "specific_character_set": UTF_8,
        "transfer_syntax_uid": ExplicitVRLittleEndian,
    }


def _encapsulated(said: Contents, name: str, content: bytes, mime: str) -> Dataset:
    patient, is_model = said.patient, mime == STL
    made: Dataset = highdicom.SOPClass(
        study_instance_uid=uid("study", patient.id, said.scan),
        sop_class_uid=CLASSES[name],
        modality="M3D" if is_model else "DOC",
        patient_id=patient.id,
        patient_name=patient.name + "^" * ("^" not in patient.name and patient.name != ""),  # one part: a family name
        patient_birth_date=patient.birth_date.replace("-", ""),
        patient_sex=patient.sex,
        accession_number=patient.accession,
        study_id="",
        study_date=said.scanned or "",
        study_time="",
        referring_physician_name="",
        **_common(said, name, hashlib.sha256(content).hexdigest()),
    )
    made.AcquisitionDateTime = "" if said.scanned is None else said.scanned.strftime("%Y%m%d")
    made.DocumentTitle = f"{MAKER} {name}, {said.stance}. {RESEARCH_USE_ONLY}"
    made.BurnedInAnnotation = "NO" if is_model else "YES"  # the code is on every page
    made.MIMETypeOfEncapsulatedDocument = mime
    made.ConceptNameCodeSequence = []
    made.EncapsulatedDocumentLength = len(content)
    made.EncapsulatedDocument = content + b"\0" * (len(content) % 2)
    if not is_model:
        made.ConversionType = "WSD"
        return made
    made.FrameOfReferenceUID = uid("frame", made.StudyInstanceUID, said.fit)
    made.PositionReferenceIndicator = ""
    made.ConceptNameCodeSequence = _code(codes.cid7061.PhotogrammetricImaging3DCAMModel)
    made.MeasurementUnitsCodeSequence = _code(codes.UCUM.Millimeter)
    made.ModelModification = "NO" if name == "scan" else "YES"
    made.ModelMirroring = "NO"
    made.ModelUsageCodeSequence = _code(codes.cid7064.PlanningIntent)
    made.ContentDescription = "Skin as scanned" if name == "scan" else "Model's skin, fitted to the scan"
    return made


def _code(concept: Code) -> list[Dataset]:
    return [highdicom.sr.CodedConcept.from_code(concept)]


def _measures(said: Contents, evidence: Sequence[Dataset]) -> Dataset:
    """What was measured is the evidence: the surfaces."""
    numbers = [{**row, "paths": None} for row in said.rows]
    all_said = json.dumps([said.quality, numbers, *(each.SOPInstanceUID for each in evidence)])
    common = _common(said, "measures", hashlib.sha256(all_said.encode()).hexdigest())
    report = measurement_report(said.rows, said.quality, common["sop_instance_uid"], uid)
    made: Dataset = highdicom.sr.Comprehensive3DSR(
        evidence=evidence, content=report, is_complete=True, coding_schemes=[SCHEME], **common
    )
    for library in made.ContributingEquipmentSequence:
        del library.ContributionDateTime
    return made

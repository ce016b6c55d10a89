"""Scans: upload, look at, delete; and the landmarks picked on them."""

from collections.abc import Sequence
from pathlib import PurePosixPath

from apiflask import APIBlueprint
from flask import Response

from breastrig.api.answers import BINARY, GLB, PNG, browser_forgets, file_of, in_memory, opened
from breastrig.api.app_context import app_context, service, storage
from breastrig.api.routes.groups import group_for_new
from breastrig.api.wire import common as wire
from breastrig.cases.case_folder import NO_SCAN
from breastrig.core.errors import NotFound
from breastrig.gltf.scan_mesh import scaled_mesh
from breastrig.scan.file_type import ENDINGS, UNKNOWN
from breastrig.scan.kept_image import read_image
from breastrig.scan.volumes.answers import checked_answers, segments_of_json
from breastrig.storage.documents.patients import StoredPatient, patients_of_scans
from breastrig.storage.documents.scans import (
    StoredScan,
    cut_facts,
    get_scan,
    said_model,
    say_model,
    scans_page,
)
from breastrig.storage.files import MESH, THUMBNAIL, VOLUME, OpenedFile, scan_place
from breastrig.use.read_upload import segment_facts

TAG = {"name": "scans", "description": "Upload a scan, pick landmarks on it, delete it with everything made of it."}

scans = APIBlueprint("scans", __name__, url_prefix="/api/scans", tag=TAG)


@scans.post("")
@scans.input(wire.ScanUpload, location="files")
@scans.output(wire.Scan, status_code=201, description="The scan was read and stored")
@scans.doc(
    operation_id="uploadScan",
    responses={
        409: "Is a scan of this patient already",
        413: "Too large",
        415: "No form with a file",
        422: "Cannot be read",
        429: "Too many",
    },
)
def upload_scan(files_data: wire.ScanUpload) -> tuple[wire.Scan, int, dict[str, str]]:
    """Upload a scan

    The bytes decide what the file is. Its name is not kept: the ending serves to word errors, and may be missing.
    Where the file of a label map does not say which side is left, or a zip of DICOM files holds several series, the
    answer is 422 with a `question`: ask a person, and send the file again with the field that it names.
    """
    ending = PurePosixPath(files_data.file.filename or "").suffix.lower()
    file_type = ending.lstrip(".") if ending in ENDINGS else UNKNOWN
    answers = checked_answers(
        files_data.frame, segments_of_json(files_data.segments), files_data.series, files_data.same_place
    )
    patient, model = files_data.patient or None, files_data.model or None
    group = group_for_new(files_data.group) if patient is None else None
    row, labels = service.uploads.add(
        files_data.file.stream, file_type, files_data.units, patient, model, answers, files_data.again, group
    )
    answer = scan_answer(row)
    named = zip(answer.segments, labels, strict=True)
    segments = [each.model_copy(update={"label": label}) for each, label in named]
    answer = answer.model_copy(update={"segments": segments})
    return answer, 201, {"Location": answer.links.self}


@scans.post("/<scan_id>/lesions")
@scans.input(wire.LesionsUpload, location="files")
@scans.output(wire.TakenLesions)
@scans.doc(
    operation_id="addLesions",
    responses={409: "No room in the plan", 413: "Too large", 422: "Cannot be read", 429: "Too many"},
)
def add_lesions(scan_id: str, files_data: wire.LesionsUpload) -> wire.TakenLesions:
    """Add the lesions of another file, drawn on the scan's image, to the plan

    They are added to what is planned; those that the plan has already are not added again.  A chest wall that the file
    names is kept with the scan, for the fits that come; nothing else is kept of it.  Where it does not say that it lies
    where the image does, or which side is left, the answer is 422 with a `question`, as at the upload of a scan.
    """
    answers = checked_answers(files_data.frame, segments_of_json(files_data.segments), same_place=files_data.same_place)
    taken = service.uploads.add_lesions(scan_id, files_data.file.stream, answers)
    lesions = [
        wire.TakenLesion(name=each.name, center=each.center.tolist(), radius_mm=float(each.radius), new=each.is_new)
        for each in taken.lesions
    ]
    segments = [wire.Segment.model_validate(segment_facts(each) | {"label": each.label}) for each in taken.segments]
    return wire.TakenLesions(lesions=lesions, segments=segments, notes=list(taken.notes))


@scans.get("")
@scans.input(wire.ScanQuery, location="query")
@scans.output(wire.ScanPage)
@scans.doc(operation_id="listScans")
def list_scans(query_data: wire.ScanQuery) -> wire.ScanPage:
    """The scans of all patients, the newest first"""
    moment, _, scan_id = (query_data.after or "").partition("~")
    last = None if query_data.after is None else (moment, scan_id)
    rows, more = scans_page(storage, query_data.limit, last)
    after = None if more is None else "~".join(more)
    return wire.ScanPage(scans=_answers(rows), next=query_data.next_page("/api/scans", after=after))


@scans.get("/<scan_id>")
@scans.output(wire.Scan)
@scans.doc(operation_id="getScan")
def show_scan(scan_id: str) -> wire.Scan:
    """The facts of a scan"""
    return scan_answer(get_scan(storage, scan_id))


@scans.delete("/<scan_id>")
@scans.output({}, status_code=204)
@scans.doc(operation_id="deleteScan", responses={500: "Deleted, but files are left; they are tried again"})
def remove_scan(scan_id: str) -> tuple[str, int]:
    """Delete a scan with its landmarks, fits, files and what was planned on it

    Running fits are stopped.  Deleting what is not there is no error.  204 says that all files are gone.
    """
    browser_forgets()
    service.delete_scan(scan_id)
    return "", 204


@scans.get("/<scan_id>/mesh.glb")
@scans.doc(operation_id="getScanMesh", responses={200: file_of(GLB, "The mesh, metres")})
def show_mesh(scan_id: str) -> Response:
    """The scan for display: glTF, metres, the scan's own axes"""
    missing = "This scan has no mesh; it may have been deleted."
    scale = get_scan(storage, scan_id).facts.get("scale")
    if scale is None:
        return _file(scan_id, MESH, GLB, missing)
    with opened(_found(scan_id, MESH, missing)) as file:
        mesh = scaled_mesh(file.read(), scale["factor"])
    return app_context().patients_file([scan_id], in_memory(mesh), GLB)


@scans.get("/<scan_id>/thumbnail.png")
@scans.doc(operation_id="getScanThumbnail", responses={200: file_of(PNG, "The scan from the front, 144 x 180")})
def show_thumbnail(scan_id: str) -> Response:
    """A small picture of the scan

    Without its colours; 404 for scans of an older version, which have none.
    """
    return _file(scan_id, THUMBNAIL, PNG, "This scan has no small picture.")


@scans.get("/<scan_id>/volume")
@scans.doc(operation_id="getScanVolume", responses={200: file_of(BINARY, "One byte a voxel, first index fastest")})
def show_volume(scan_id: str) -> Response:
    """The image that the scan was made of, as it is kept

    Raw grey values of one byte, the first index fastest; `image` of the scan has their shape and place.  404 for scans
    that were made of none.
    """
    file = _found(scan_id, VOLUME, "This scan has no image: it is a surface, or was made of a label map.")
    assert file.path is not None
    try:
        voxels = read_image(file.path).values.tobytes(order="F")
    except FileNotFoundError as error:
        raise NotFound(NO_SCAN) from error
    return app_context().patients_file([scan_id], in_memory(voxels), BINARY)


def _file(scan_id: str, name: str, media_type: str, missing: str) -> Response:
    return app_context().patients_file([scan_id], _found(scan_id, name, missing), media_type)


def _found(scan_id: str, name: str, missing: str) -> OpenedFile:
    get_scan(storage, scan_id)
    file = storage.files.find(scan_place(scan_id), name)
    if file is None:
        raise NotFound(missing)
    return file


@scans.put("/<scan_id>/model")
@scans.input(wire.ScanModel)
@scans.output(wire.Scan)
@scans.doc(operation_id="putScanModel", responses={409: "The scan was uploaded for another model"})
def confirm_model(scan_id: str, json_data: wire.ScanModel) -> wire.Scan:
    """Say that the scan's model is the right one, kept as `model_said`"""
    row = get_scan(storage, scan_id)
    say_model(storage, scan_id, json_data.model, service.models.name_of(row.facts))
    return scan_answer(row)


def scan_answer(row: StoredScan) -> wire.Scan:
    """The stored row as the API shows it.  Raises NotFound when it was deleted meanwhile."""
    answers = _answers([row])
    if not answers:
        raise NotFound(NO_SCAN)
    return answers[0]


def _answers(rows: Sequence[StoredScan]) -> list[wire.Scan]:
    """The stored rows as the API shows them, by one query however many they are; without those just deleted."""
    owners = patients_of_scans(storage, [row.id for row in rows])
    return [_answer(row, owners[row.id]) for row in rows if row.id in owners]


def _answer(row: StoredScan, owner: StoredPatient) -> wire.Scan:
    place, patient = f"/api/scans/{row.id}", owner.id
    links = wire.ScanLinks.at(
        place,
        patient=f"/api/patients/{patient}",
        plan=f"/api/patients/{patient}/plan",
        volume=f"{place}/volume" if row.facts.get("image") else None,
    )
    shown = {name: fact for name, fact in row.facts.items() if name != "orientation"}  # that is for our own workers
    facts = shown | cut_facts(row) | {"patient_code": owner.code, "sha256": row.sha256}
    model = service.models.name_of(row.facts)
    facts |= {"model": model, "model_said": said_model(storage, owner.id, row.id) == model}
    return wire.Scan(id=row.id, patient=patient, created_at=row.created_at, links=links, **facts)

"""Scans: upload, look at, delete; and the landmarks picked on them."""

from collections.abc import Sequence
from pathlib import PurePosixPath
from typing import Any

from apiflask import APIBlueprint
from flask import Response

from breastrig.api.answers import BINARY, GLB, PERSONAL, PNG, browser_forgets, bytes_answer, file_of, in_memory
from breastrig.api.app_context import app_context
from breastrig.api.errors import refuse
from breastrig.api.place_checks import check_landmarks, given_picks, landmark_answer, picks_of_file, written_file
from breastrig.api.wire import common as wire
from breastrig.cases.case_folder import NO_SCAN
from breastrig.core.errors import NotFound
from breastrig.core.picks import Picks
from breastrig.core.proposed import why_not_proposed
from breastrig.scan.file_type import ENDINGS, UNKNOWN
from breastrig.scan.kept_image import read_image
from breastrig.scan.landmarks.landmark_files import LIMIT_BYTES
from breastrig.scan.volumes.answers import checked_answers, segments_of_json
from breastrig.storage.documents.patients import StoredPatient, patients_of_scans
from breastrig.storage.documents.scans import (
    Cuts,
    StoredScan,
    cut_facts,
    cuts_digest,
    get_cuts,
    get_landmarks,
    get_scan,
    picks_digest,
    put_cuts,
    put_landmarks,
    said_model,
    say_model,
    scans_page,
)
from breastrig.storage.files import MESH, THUMBNAIL, VOLUME, OpenedFile, scan_place
from breastrig.use.read_upload import segment_facts

TAG = {"name": "scans", "description": "Upload a scan, pick landmarks on it, delete it with everything made of it."}

scans = APIBlueprint("scans", __name__, url_prefix="/api/scans", tag=TAG)

CHANGED_CUTS = "Somebody has changed these cuts since you read them; read them again, and send them with yours."
CHANGED_LANDMARKS = (
    "Somebody has changed these landmarks since you read them; read them again, and send them with yours."
)
Landmarks = tuple[wire.LandmarkFile, int, dict[str, str]]


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
    row, labels = app_context().service.uploads.add(
        files_data.file.stream, file_type, files_data.units, patient, model, answers, files_data.again
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
    taken = app_context().service.uploads.add_lesions(scan_id, files_data.file.stream, answers)
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
    rows, more = scans_page(app_context().service.storage, query_data.limit, last)
    after = None if more is None else "~".join(more)
    return wire.ScanPage(scans=_answers(rows), next=query_data.next_page("/api/scans", after=after))


@scans.get("/<scan_id>")
@scans.output(wire.Scan)
@scans.doc(operation_id="getScan")
def show_scan(scan_id: str) -> wire.Scan:
    """The facts of a scan"""
    return scan_answer(get_scan(app_context().service.storage, scan_id))


@scans.delete("/<scan_id>")
@scans.output({}, status_code=204)
@scans.doc(operation_id="deleteScan", responses={500: "Deleted, but files are left; they are tried again"})
def remove_scan(scan_id: str) -> tuple[str, int]:
    """Delete a scan with its landmarks, fits, files and what was planned on it

    Running fits are stopped.  Deleting what is not there is no error.  204 says that all files are gone.
    """
    browser_forgets()
    app_context().service.delete_scan(scan_id)
    return "", 204


@scans.get("/<scan_id>/mesh.glb")
@scans.doc(operation_id="getScanMesh", responses={200: file_of(GLB, "The mesh, metres")})
def show_mesh(scan_id: str) -> Response:
    """The scan for display: glTF, metres, the scan's own axes"""
    return _file(scan_id, MESH, GLB, "This scan has no mesh; it may have been deleted.")


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
    storage = app_context().service.storage
    get_scan(storage, scan_id)
    file = storage.files.find(scan_place(scan_id), name)
    if file is None:
        raise NotFound(missing)
    return file


@scans.get("/<scan_id>/landmarks")
@scans.output(wire.LandmarkFile)
@scans.doc(operation_id="getLandmarks")
def show_landmarks(scan_id: str) -> Landmarks:
    """The landmarks picked so far, mm

    The ETag is what a change may name as If-Match.
    """
    storage = app_context().service.storage
    get_scan(storage, scan_id)
    stored = get_landmarks(storage, scan_id)
    return _landmarks_answer(stored)


@scans.put("/<scan_id>/landmarks")
@scans.input(wire.GivenLandmarkFile)
@scans.input(wire.LandmarksHeaders, location="headers")
@scans.output(wire.LandmarkFile)
@scans.doc(operation_id="putLandmarks", responses={412: "Changed by somebody else meanwhile"})
def replace_landmarks(
    scan_id: str, json_data: wire.GivenLandmarkFile, headers_data: wire.LandmarksHeaders
) -> Landmarks:
    """Replace the landmarks, in the unit that they name

    Names must be landmarks of the model; points must lie near the scan.  `certain` names those of them that a fit
    follows whatever all else says, `confidence` those that were proposed and only agreed to.  `marks` have any other
    names; without this field those stay that are stored.
    """
    context = app_context()
    row = get_scan(context.service.storage, scan_id)
    picks = given_picks(json_data, get_landmarks(context.service.storage, row.id))
    check_landmarks(picks, row, context.model_of(row.facts))
    picks = context.service.proposals.agreed(row.id, context.model_of(row.facts).rig.sha256, picks)
    if not put_landmarks(context.service.storage, scan_id, picks, _tag(headers_data.if_match)):
        now = picks_digest(get_landmarks(context.service.storage, scan_id))
        raise refuse(412, CHANGED_LANDMARKS, {"ETag": f'"{now}"'})
    return _landmarks_answer(picks)


@scans.post("/<scan_id>/landmarks/file")
@scans.input(wire.LandmarkUpload, location="files")
@scans.output(wire.LandmarkFile)
@scans.doc(operation_id="readLandmarkFile", responses={422: "Cannot be read"})
def read_landmark_file(scan_id: str, files_data: wire.LandmarkUpload) -> wire.LandmarkFile:
    """The landmarks of a file, mm

    As the command line reads it: any kind of file, in the scan's frame, under the model's names.  Nothing is kept; send
    them with PUT.
    """
    context = app_context()
    row = get_scan(context.service.storage, scan_id)
    found = picks_of_file(files_data.file.stream.read(LIMIT_BYTES + 1), row, context.model_of(row.facts))
    return landmark_answer(found)


@scans.post("/<scan_id>/landmarks/file/<kind>")
@scans.input(wire.GivenLandmarkFile)
@scans.doc(
    operation_id="writeLandmarkFile",
    responses={200: file_of(BINARY, "The file"), 422: "No kind of file"},
)
def write_landmark_file(scan_id: str, kind: str, json_data: wire.GivenLandmarkFile) -> Response:
    """These landmarks as a file: json (mm), or csv, pp or mrk.json in the scan's unit

    Nothing is kept.
    """
    unit = get_scan(app_context().service.storage, scan_id).facts["unit"]
    return bytes_answer(written_file(json_data, kind, unit), BINARY, PERSONAL)


@scans.get("/<scan_id>/cuts")
@scans.output(wire.Cuts)
@scans.doc(operation_id="getCuts")
def show_cuts(scan_id: str) -> wire.Cuts:
    """The cuts by hand of the scan"""
    storage = app_context().service.storage
    get_scan(storage, scan_id)
    return cuts_answer(get_cuts(storage, scan_id))


@scans.put("/<scan_id>/cuts")
@scans.input(wire.CutsFile)
@scans.input(wire.CutsHeaders, location="headers")
@scans.output(wire.Cuts)
@scans.doc(operation_id="putCuts", responses={412: "Changed by somebody else meanwhile"})
def replace_cuts(scan_id: str, json_data: wire.CutsFile, headers_data: wire.CutsHeaders) -> wire.Cuts:
    """Replace what is cut out of the scan

    The scan itself stays whole; fits and proposals that are asked for from now on do not see what is cut.
    """
    cuts = tuple(cut.model_dump() for cut in json_data.cuts)
    if not put_cuts(app_context().service.storage, scan_id, cuts, _tag(headers_data.if_match)):
        raise refuse(412, CHANGED_CUTS)
    return cuts_answer(cuts)


@scans.put("/<scan_id>/model")
@scans.input(wire.ScanModel)
@scans.output(wire.Scan)
@scans.doc(operation_id="putScanModel", responses={409: "The scan was uploaded for another model"})
def confirm_model(scan_id: str, json_data: wire.ScanModel) -> wire.Scan:
    """Say that the scan's model is the right one, kept as `model_said`"""
    service = app_context().service
    row = get_scan(service.storage, scan_id)
    say_model(service.storage, scan_id, json_data.model, service.models.name_of(row.facts))
    return scan_answer(row)


@scans.get("/<scan_id>/landmarks/proposed")
@scans.output(wire.ProposedLandmarks)
@scans.doc(
    operation_id="proposeLandmarks",
    responses={202: "Still being looked for; ask again after Retry-After seconds", 422: "None can be proposed"},
)
def propose_landmarks(scan_id: str) -> wire.ProposedLandmarks | Response:
    """Landmarks that the model proposes on this scan, mm; what the scan does not show is not proposed

    The first call answers once they are found, most often within a second; later calls answer at once.
    A large scan on a busy machine may take longer than a request should: then 202 comes first.  Proposals are for
    a person to check, and are not stored as the scan's landmarks.  A fit finds by itself what only the form of the body
    proposes: agreeing to it makes the fit no better, so that a landmark that stands where it was proposed keeps the
    proposal's error unless `confidence` says 1, which is for who has looked closely.
    """
    context = app_context()
    row = get_scan(context.service.storage, scan_id)
    found = context.service.proposals.of(row, context.model_of(row.facts).rig.sha256, context.config.proposal_wait_s)
    if found is None:
        return Response(status=202, headers={"Retry-After": "1"})
    return _proposed(found)


@scans.get("/<scan_id>/ink")
@scans.output(wire.Ink)
@scans.doc(
    operation_id="findInk",
    responses={
        202: "Still being looked for; ask again after Retry-After seconds",
        422: "The scan has no colours, or too coarse ones",
    },
)
def find_ink(scan_id: str) -> wire.Ink | Response:
    """Lines that were drawn on the skin, mm

    Read from the scan's colours. The first call answers once they are found, most often within two seconds; later
    calls answer at once. They are for a person to accept; only then are they lines of the plan.
    """
    context = app_context()
    row = get_scan(context.service.storage, scan_id)
    found = context.service.ink.found(row, context.config.proposal_wait_s)
    if found is None:
        return Response(status=202, headers={"Retry-After": "1"})
    return wire.Ink.model_validate(found)


@scans.patch("/<scan_id>/ink")
@scans.input(wire.InkChange)
@scans.output(wire.Ink)
@scans.doc(
    operation_id="dropInk", responses={409: "Not looked for yet", 422: "A name that none of the found lines has"}
)
def drop_ink(scan_id: str, json_data: wire.InkChange) -> wire.Ink:
    """Say which of the found lines are none of the plan

    They stay among the found lines, marked as dropped, until this is taken back.
    """
    return wire.Ink.model_validate(app_context().service.ink.mark_dropped(scan_id, json_data.dropped))


def _proposed(found: dict[str, Any]) -> wire.ProposedLandmarks:
    """The proposals without landmarks that the scan does not show."""
    landmarks, not_proposed = {}, {}
    for name, each in found.items():
        to_skin_mm = each.get("to_skin_mm", 0.0)  # earlier versions have not kept it
        why = why_not_proposed(1e-3 * to_skin_mm, None if each["error_mm"] is None else 1e-3 * each["error_mm"])
        if why is None:
            landmarks[name] = {key: value for key, value in each.items() if key != "to_skin_mm"}
        else:
            not_proposed[name] = why
    return wire.ProposedLandmarks.model_validate({"landmarks": landmarks, "not_proposed": not_proposed})


def _tag(if_match: str | None) -> str | None:
    """The text within the quotes of an If-Match header."""
    return None if if_match is None else if_match.strip().removeprefix("W/").strip('"')


def _landmarks_answer(picks: Picks) -> Landmarks:
    return landmark_answer(picks), 200, {"ETag": f'"{picks_digest(picks)}"', "Cache-Control": "no-store"}


def cuts_answer(cuts: Cuts) -> wire.Cuts:
    """The cuts as the API shows them."""
    return wire.Cuts.model_validate({"cuts": cuts, "digest": cuts_digest(cuts)})


def scan_answer(row: StoredScan) -> wire.Scan:
    """The stored row as the API shows it.  Raises NotFound when it was deleted meanwhile."""
    answers = _answers([row])
    if not answers:
        raise NotFound(NO_SCAN)
    return answers[0]


def _answers(rows: Sequence[StoredScan]) -> list[wire.Scan]:
    """The stored rows as the API shows them, by one query however many they are; without those just deleted."""
    owners = patients_of_scans(app_context().service.storage, [row.id for row in rows])
    return [_answer(row, owners[row.id]) for row in rows if row.id in owners]


def _answer(row: StoredScan, owner: StoredPatient) -> wire.Scan:
    place, patient = f"/api/scans/{row.id}", owner.id
    links = wire.ScanLinks(
        self=place,
        mesh=f"{place}/mesh.glb",
        landmarks=f"{place}/landmarks",
        proposed=f"{place}/landmarks/proposed",
        cuts=f"{place}/cuts",
        ink=f"{place}/ink",
        drawing=f"{place}/drawing",
        fits=f"{place}/fits",
        patient=f"/api/patients/{patient}",
        plan=f"/api/patients/{patient}/plan",
        volume=f"{place}/volume" if row.facts.get("image") else None,
    )
    shown = {name: fact for name, fact in row.facts.items() if name != "orientation"}  # that is for our own workers
    facts = shown | cut_facts(row) | {"patient_code": owner.code, "sha256": row.sha256}
    model = app_context().service.models.name_of(row.facts)
    facts |= {"model": model, "model_said": said_model(app_context().service.storage, owner.id, row.id) == model}
    return wire.Scan(id=row.id, patient=patient, created_at=row.created_at, links=links, **facts)

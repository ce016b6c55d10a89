"""What is kept of a scan: landmarks, cuts, its true size, what is found on it."""

from typing import Any

from apiflask import APIBlueprint
from flask import Response

from breastrig.api.answers import BINARY, PERSONAL, bytes_answer, file_of
from breastrig.api.app_context import app_context, config, service, storage
from breastrig.api.errors import refuse
from breastrig.api.place_checks import check_landmarks, given_picks, landmark_answer, picks_of_file, written_file
from breastrig.api.routes.scans.scans import TAG, scan_answer
from breastrig.api.wire import common as wire
from breastrig.core.picks import Picks
from breastrig.core.proposed import why_not_proposed
from breastrig.scan.landmarks.landmark_files import LIMIT_BYTES
from breastrig.storage.documents.scans import (
    Cuts,
    StoredScan,
    cuts_digest,
    get_cuts,
    get_landmarks,
    get_scan,
    picks_digest,
    put_cuts,
    put_landmarks,
)

of_scans = APIBlueprint("of_scans", __name__, url_prefix="/api/scans", tag=TAG)

CHANGED_CUTS = "Somebody has changed these cuts since you read them; read them again, and send them with yours."
CHANGED_LANDMARKS = (
    "Somebody has changed these landmarks since you read them; read them again, and send them with yours."
)
Landmarks = tuple[wire.LandmarkFile, int, dict[str, str]]


@of_scans.get("/<scan_id>/landmarks")
@of_scans.output(wire.LandmarkFile)
@of_scans.doc(operation_id="getLandmarks")
def show_landmarks(scan_id: str) -> Landmarks:
    """The landmarks picked so far, mm

    The ETag is what a change may name as If-Match.
    """
    row = get_scan(storage, scan_id)
    return _landmarks_answer(get_landmarks(storage, scan_id), row)


@of_scans.put("/<scan_id>/landmarks")
@of_scans.input(wire.GivenLandmarkFile)
@of_scans.input(wire.IfMatch, location="headers")
@of_scans.output(wire.LandmarkFile)
@of_scans.doc(operation_id="putLandmarks", responses={412: "Changed by somebody else meanwhile"})
def replace_landmarks(scan_id: str, json_data: wire.GivenLandmarkFile, headers_data: wire.IfMatch) -> Landmarks:
    """Replace the landmarks, in the unit that they name

    Names must be landmarks of the model; points must lie near the scan.  `certain` names those of them that a fit
    follows whatever all else says, `confidence` those that were proposed and only agreed to.  `marks` have any other
    names; without this field those stay that are stored.  Of a scan with a length, places are in the true size unless
    `scale` says another: the one in which they were read, 1 for places of the scan's own file.
    """
    context = app_context()
    row = get_scan(storage, scan_id)
    picks = given_picks(json_data, get_landmarks(storage, row.id), row)
    check_landmarks(picks, row, context.model_of(row.facts))
    picks = service.proposals.agreed(row.id, context.model_of(row.facts).rig.sha256, picks)
    if not put_landmarks(storage, scan_id, picks, headers_data.tag):
        now = picks_digest(get_landmarks(storage, scan_id))
        raise refuse(412, CHANGED_LANDMARKS, {"ETag": f'"{now}"'})
    return _landmarks_answer(picks, row)


@of_scans.post("/<scan_id>/landmarks/file")
@of_scans.input(wire.LandmarkUpload, location="files")
@of_scans.output(wire.LandmarkFile)
@of_scans.doc(operation_id="readLandmarkFile", responses={422: "Cannot be read"})
def read_landmark_file(scan_id: str, files_data: wire.LandmarkUpload) -> wire.LandmarkFile:
    """The landmarks of a file, mm

    As the command line reads it: any kind of file, in the scan's frame, under the model's names.  Nothing is kept; send
    them with PUT.  Of a scan with a length they are in the true size, as the answer's `scale` says, to which those of a
    file with a `scale` of its own are taken; PUT places that were picked on the scan's own file with `scale` 1.
    """
    context = app_context()
    row = get_scan(storage, scan_id)
    found = picks_of_file(files_data.file.stream.read(LIMIT_BYTES + 1), row, context.model_of(row.facts))
    return landmark_answer(found, row)


@of_scans.post("/<scan_id>/landmarks/file/<kind>")
@of_scans.input(wire.GivenLandmarkFile)
@of_scans.doc(
    operation_id="writeLandmarkFile",
    responses={200: file_of(BINARY, "The file"), 422: "No kind of file"},
)
def write_landmark_file(scan_id: str, kind: str, json_data: wire.GivenLandmarkFile) -> Response:
    """These landmarks as a file: json (mm), or csv, pp or mrk.json in the scan's unit

    Nothing is kept.
    """
    row = get_scan(storage, scan_id)
    return bytes_answer(written_file(json_data, kind, row), BINARY, PERSONAL)


@of_scans.get("/<scan_id>/cuts")
@of_scans.output(wire.Cuts)
@of_scans.doc(operation_id="getCuts")
def show_cuts(scan_id: str) -> wire.Cuts:
    """The cuts by hand of the scan"""
    get_scan(storage, scan_id)
    return cuts_answer(get_cuts(storage, scan_id))


@of_scans.put("/<scan_id>/cuts")
@of_scans.input(wire.CutsFile)
@of_scans.input(wire.IfMatch, location="headers")
@of_scans.output(wire.Cuts)
@of_scans.doc(operation_id="putCuts", responses={412: "Changed by somebody else meanwhile"})
def replace_cuts(scan_id: str, json_data: wire.CutsFile, headers_data: wire.IfMatch) -> wire.Cuts:
    """Replace what is cut out of the scan

    The scan itself stays whole; fits and proposals that are asked for from now on do not see what is cut.
    """
    cuts = tuple(cut.model_dump() for cut in json_data.cuts)
    if not put_cuts(storage, scan_id, cuts, headers_data.tag):
        raise refuse(412, CHANGED_CUTS)
    return cuts_answer(cuts)


@of_scans.put("/<scan_id>/length")
@of_scans.input(wire.GivenLength)
@of_scans.output(wire.Scan)
@of_scans.doc(operation_id="putLength", responses={409: "A fit of the scan waits or runs", 422: "Cannot be meant"})
def give_length(scan_id: str, json_data: wire.GivenLength) -> wire.Scan:
    """Give the scan its true size by a straight length that was measured on the patient, kept as its `scale`

    The scan and all that is kept of it (landmarks, marks, cuts, its items of the plan) are scaled about the origin of
    the scan's frame; from then on all that is asked for and answered is in the true size.  Fits that were asked for
    before are `cancelled`: fit again.  A factor under 0.8 or above 1.25 is a wrong unit, and refused.
    """
    service.put_length(scan_id, (json_data.start, json_data.end, json_data.length_mm))
    return scan_answer(get_scan(storage, scan_id))


@of_scans.delete("/<scan_id>/length")
@of_scans.output(wire.Scan)
@of_scans.doc(operation_id="deleteLength", responses={409: "A fit of the scan waits or runs"})
def take_length(scan_id: str) -> wire.Scan:
    """Give the scan the size of its file again; fits of that size count again, no others do"""
    service.put_length(scan_id, None)
    return scan_answer(get_scan(storage, scan_id))


@of_scans.get("/<scan_id>/landmarks/proposed")
@of_scans.output(wire.ProposedLandmarks)
@of_scans.doc(
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
    row = get_scan(storage, scan_id)
    found = service.proposals.of(row, context.model_of(row.facts).rig.sha256, config.proposal_wait_s)
    if found is None:
        return Response(status=202, headers={"Retry-After": "1"})
    return _proposed(found)


@of_scans.get("/<scan_id>/ink")
@of_scans.output(wire.Ink)
@of_scans.doc(
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
    row = get_scan(storage, scan_id)
    found = service.ink.found(row, config.proposal_wait_s)
    if found is None:
        return Response(status=202, headers={"Retry-After": "1"})
    return wire.Ink.model_validate(found)


@of_scans.patch("/<scan_id>/ink")
@of_scans.input(wire.InkChange)
@of_scans.output(wire.Ink)
@of_scans.doc(
    operation_id="dropInk", responses={409: "Not looked for yet", 422: "A name that none of the found lines has"}
)
def drop_ink(scan_id: str, json_data: wire.InkChange) -> wire.Ink:
    """Say which of the found lines are none of the plan

    They stay among the found lines, marked as dropped, until this is taken back.
    """
    return wire.Ink.model_validate(service.ink.mark_dropped(scan_id, json_data.dropped))


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


def _landmarks_answer(picks: Picks, row: StoredScan) -> Landmarks:
    return landmark_answer(picks, row), 200, {"ETag": f'"{picks_digest(picks)}"', "Cache-Control": "no-store"}


def cuts_answer(cuts: Cuts) -> wire.Cuts:
    """The cuts as the API shows them."""
    return wire.Cuts.model_validate({"cuts": cuts, "digest": cuts_digest(cuts)})

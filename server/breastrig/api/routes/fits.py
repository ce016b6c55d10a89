"""Fits: ask for one, look at it, cancel it, fetch what it made."""

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from apiflask import APIBlueprint
from flask import Response, request

from breastrig.api.answers import GLTF, PERSONAL, bytes_answer, file_of
from breastrig.api.app_context import app_context, service, storage
from breastrig.api.errors import refuse
from breastrig.api.place_checks import check_landmarks
from breastrig.api.trusted_proxy import client_of
from breastrig.api.wire import common as wire
from breastrig.cases.documents import FitDocument
from breastrig.core.errors import BadSettings, Conflict, NotFound, unknown_name
from breastrig.core.picks import Picks
from breastrig.drawings.patterns import asked_drawing
from breastrig.fitting.recipe import preset_names
from breastrig.index.questions import queue_positions
from breastrig.storage.documents.events import event_of_kind
from breastrig.storage.documents.fits import Once, StoredFit, fits_page, get_fit
from breastrig.storage.documents.scans import StoredScan, cuts_digest, get_cuts, get_landmarks, get_scan
from breastrig.storage.storage import Storage, utc_now
from breastrig.use.steps.events import Iterated

MOST_ITERATION = 2**31  # a larger number is no offset for every database
Accepted = tuple[wire.FitAccepted, int, dict[str, str]]
FITS_TAG = {"name": "fits", "description": "Fit the model to a scan, follow it live, fetch the results."}

fits = APIBlueprint("fits", __name__, url_prefix="/api/fits", tag=FITS_TAG)
fits_of_scans = APIBlueprint("fits_of_scans", __name__, url_prefix="/api/scans", tag=FITS_TAG)


@fits.post("")
@fits.input(wire.FitRequest)
@fits.input(wire.FitHeaders, location="headers")
@fits.output(wire.FitAccepted, status_code=202, description="The fit waits for a worker")
@fits.doc(operation_id="startFit", responses={404: "No such scan", 429: "Too many of yours are waiting"})
def start_fit(json_data: wire.FitRequest, headers_data: wire.FitHeaders) -> Accepted:
    """Fit the model to a scan

    With an `Idempotency-Key` the same request may be sent again: it is answered with the fit that it started
    first, as long as that fit is kept.  The same key with another request gives 422.

    With `start_from` a fit goes on from an earlier one of the same scan: for when a landmark was moved.
    """
    context = app_context()
    facts = get_scan(storage, json_data.scan).facts
    rig = context.model_of(facts).rig
    presets = preset_names()
    if json_data.preset not in presets:
        raise BadSettings(unknown_name("preset", json_data.preset, presets))
    if json_data.drawing is not None:
        asked_drawing(rig, json_data.drawing)
    if json_data.start_from is not None:
        _check_start(json_data, json_data.start_from)
    fit_id = service.add_fit(
        json_data.scan,
        _asked(json_data),
        _once(headers_data.idempotency_key, json_data),
        client=client_of(request.remote_addr),
    )
    return _accepted(fit_id)


def _accepted(fit_id: str) -> Accepted:
    cuts = cuts_digest(get_fit(storage, fit_id).cuts)
    answer = wire.FitAccepted(id=fit_id, links=wire.FitLinks.at(f"/api/fits/{fit_id}"), cuts=cuts)
    return answer, 202, {"Location": answer.links.self}


def _check_start(asked: wire.FitRequest, start_from: str) -> None:
    earlier = get_fit(storage, start_from)
    if earlier.scan != asked.scan or earlier.predicted_from is not None:
        raise BadSettings("A fit goes on from a fit of the same scan; leave `start_from` out for another one.")
    if earlier.state != "done":
        raise Conflict(f"A fit goes on from one that is done; that one is {earlier.state}.")


def _asked(asked: wire.FitRequest) -> FitDocument:
    context = app_context()
    scan = get_scan(storage, asked.scan)
    picks = _picks(scan, asked)
    check_landmarks(picks, scan, context.model_of(scan.facts))
    return FitDocument(
        asked_at=utc_now(),
        stance=asked.stance,
        preset=asked.preset,
        drawing=asked.drawing,
        landmarks_mm=picks.points_mm,
        certain=list(picks.certain),
        confidence=picks.confidence,
        marks_mm=picks.marks_mm,
        cuts=list(get_cuts(storage, scan.id)),
        scale=scan.facts.get("scale", {}).get("factor", 1.0),
        refine=asked.refine,
        start_from=asked.start_from,
    )


def _picks(scan: StoredScan, asked: wire.FitRequest) -> Picks:
    """The landmarks of the request, else those stored with the scan."""
    context = app_context()
    said: dict[str, Any] = {} if asked.certain is None else {"certain": tuple(asked.certain)}
    said |= {} if asked.confidence is None else {"confidence": asked.confidence}
    brought = asked.landmarks is not None
    stored = get_landmarks(storage, scan.id)
    picks = Picks(asked.landmarks or {}, marks_mm=stored.marks_mm) if brought else stored
    said |= {} if asked.marks is None else {"marks_mm": asked.marks}
    return service.proposals.agreed(scan.id, context.model_of(scan.facts).rig.sha256, replace(picks, **said))


def _once(key: str | None, asked: wire.FitRequest) -> Once | None:
    if key is None:
        return None
    if not re.fullmatch(r"[\x21-\x7e]{1,255}", key):
        raise refuse(400, "An Idempotency-Key is 1 to 255 visible ASCII characters; a random UUID is a good one.")
    return Once.of(key, asked.model_dump_json())


@fits.post("/<fit_id>/predictions")
@fits.input(wire.PredictionRequest)
@fits.output(wire.FitAccepted, status_code=202, description="The prediction waits for a worker, or is there already")
@fits.doc(operation_id="predictStance", responses={409: "Not done", 429: "Too many of yours are waiting"})
def predict_stance(fit_id: str, json_data: wire.PredictionRequest) -> Accepted:
    """Predict how the patient lies in a stance that was not scanned

    It is a fit of the same scan, marked `predicted_from`, with the events, files, plan and report of one; its
    uncertainty says how far off it may be.  The same prediction is made once, however often it is asked for.
    """
    made = service.add_prediction(fit_id, json_data.stance, client_of(request.remote_addr))
    return _accepted(made)


@fits.get("")
@fits.input(wire.PageQuery, location="query")
@fits.output(wire.FitPage)
@fits.doc(operation_id="listFits")
def list_fits(query_data: wire.PageQuery) -> wire.FitPage:
    """The fits of all scans, the newest first"""
    return _page("/api/fits", query_data, None)


@fits_of_scans.get("/<scan_id>/fits")
@fits_of_scans.input(wire.PageQuery, location="query")
@fits_of_scans.output(wire.FitPage)
@fits_of_scans.doc(operation_id="listFitsOfScan")
def list_fits_of_scan(scan_id: str, query_data: wire.PageQuery) -> wire.FitPage:
    """The fits of a scan, the newest first"""
    get_scan(storage, scan_id)
    return _page(f"/api/scans/{scan_id}/fits", query_data, scan_id)


def _page(address: str, query: wire.PageQuery, scan_id: str | None) -> wire.FitPage:
    rows, before = fits_page(storage, query.limit, query.before, scan_id)
    more = query.next_page(address, before=before)
    return wire.FitPage(fits=_answers(rows), next=more)


@fits.get("/<fit_id>")
@fits.output(wire.Fit)
@fits.doc(operation_id="getFit")
def show_fit(fit_id: str) -> wire.Fit:
    """State and last numbers of a fit"""
    return fit_answer(get_fit(storage, fit_id))


@fits.post("/<fit_id>/cancel")
@fits.output(wire.Fit, status_code=202)
@fits.doc(operation_id="cancelFit", responses={409: "It has already ended otherwise"})
def cancel_fit(fit_id: str) -> tuple[wire.Fit, int]:
    """Stop a fit

    A fit that is already cancelled stays so; one that is done or failed gives 409.
    """
    return fit_answer(service.cancel_fit(fit_id)), 202


@fits.post("/<fit_id>/moved")
@fits.input(wire.MovedLandmarks)
@fits.output(wire.MovedModel, description="The model at these landmarks")
@fits.doc(operation_id="moveLandmarks", responses={409: "Not done", 429: "Too many fits are being moved"})
def move_landmarks(fit_id: str, json_data: wire.MovedLandmarks) -> wire.MovedModel:
    """The model's pose while landmarks are dragged

    An answer takes some hundredths of a second, the first one of a fit as long as reading its scan. It starts where the
    last answer ended and follows all picks as they are, and nothing of it is kept: send the newest picks only, and
    start a fit when the drag has ended.
    """
    context = app_context()
    scan = get_scan(storage, get_fit(storage, fit_id).scan)
    model = context.model_with(service.models.sha256_of(fit_id))
    check_landmarks(Picks(json_data.landmarks), scan, model)
    moved = service.moving.landmarks(fit_id, json_data.landmarks)
    return wire.MovedModel.model_validate(moved)


@fits.get("/<fit_id>/iterations/<int:iteration>.gltf")
@fits.doc(operation_id="getIteration", responses={200: file_of(GLTF, "One iteration, complete")})
def show_iteration(fit_id: str, iteration: int) -> Response:
    """Iteration K as a complete glTF with the drawing

    Its buffers are the model's immutable files.
    """
    from breastrig.gltf.iterate import iterate_gltf  # as in api/served_model.py
    from breastrig.gltf.pose_nodes import posed_by_nodes

    context = app_context()
    fit = get_fit(storage, fit_id)
    model = context.model_with(service.models.sha256_of(fit.id))
    found = _stored_iteration(storage, fit, iteration)
    x = posed_by_nodes(model.rig, [node.model_dump() for node in found.nodes], found.modes)
    shown = next((drawing for drawing in model.rig.drawings if drawing.name == fit.drawing), None)
    links = model.buffer_link, None if shown is None else model.drawing_link(shown.name)
    content = iterate_gltf(model.rig, x, shown, *links)
    return bytes_answer(content, GLTF, PERSONAL)


def fit_answer(row: StoredFit) -> wire.Fit:
    """The stored row as the API shows it."""
    return _answers([row])[0]


def _answers(rows: Sequence[StoredFit]) -> list[wire.Fit]:
    """The stored rows as the API shows them, by one query however many they are."""
    waiting = [row.id for row in rows if row.state == "queued"]
    positions = storage.index.asked(queue_positions, waiting) if waiting else {}
    return [
        wire.Fit.of(
            row,
            queue_position=positions.get(row.id),
            landmarks=row.landmarks_mm,
            marks=row.marks_mm,
            cuts=cuts_digest(row.cuts),
            links=wire.FitLinks.at(f"/api/fits/{row.id}"),
        )
        for row in rows
    ]


def _stored_iteration(storage: Storage, fit: StoredFit, iteration: int) -> Iterated:
    """The stored event of an iteration. Raises NotFound when the fit has no such iteration, or not yet."""
    found = event_of_kind(storage, fit.id, "iterated", iteration) if iteration < MOST_ITERATION else None
    event = None if found is None else Iterated.model_validate_json(found.json)
    if event is None or event.iteration != iteration:
        raise NotFound(f"This fit has no iteration {iteration}; it has {fit.iterations} so far, from 0.")
    return event

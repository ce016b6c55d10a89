"""Patients: the list to work through, whose scan a scan is, and the plan of each."""

import json
from collections import defaultdict
from datetime import datetime, timedelta
from typing import Any

from apiflask import APIBlueprint
from flask import Response

from breastrig.api.answers import JSON, PERSONAL, browser_forgets, bytes_answer
from breastrig.api.app_context import app_context, config, service, storage
from breastrig.api.errors import refuse
from breastrig.api.place_checks import check_near_scan, scale_of
from breastrig.api.routes.fits import FITS_TAG
from breastrig.api.whose import check_whose
from breastrig.api.wire import patients as wire
from breastrig.api.wire.common import IfMatch
from breastrig.cases.plans import times
from breastrig.cases.writing import Changed
from breastrig.core.errors import BadDrawing
from breastrig.drawings.patterns import drawing_with
from breastrig.drawings.plan_schema import Plan, PlanLesion, PlanLine, PlanNote, asked_of
from breastrig.index.questions import ListedCase, ListedScan
from breastrig.report.pages.printable import check_printable, checked_code
from breastrig.service.scans.skin_checks import shapes_of
from breastrig.storage.documents.patients import (
    PatientPlan,
    get_patient,
    get_plan,
    listed_page,
    listed_patient,
    move_scan,
    put_plan,
    rename_patient,
    scans_of_patient,
)
from breastrig.storage.documents.scans import get_scans
from breastrig.storage.storage import iso_utc
from breastrig.use.lines.plan_words import texts_of

TAG = {"name": "patients", "description": "Patients under codes, their scans, and what is planned on their skin."}
CHANGED = "Somebody has changed this plan since you read it; read it again, take the change over, and send it again."
UNSEEN = 'A plan is replaced only by who has seen it; send its ETag as If-Match, "0" for the first.'

patients = APIBlueprint("patients", __name__, url_prefix="/api/patients", tag=TAG)
owners = APIBlueprint("owners", __name__, url_prefix="/api/scans", tag=TAG)
plans_of_fits = APIBlueprint("plans_of_fits", __name__, url_prefix="/api/fits", tag=FITS_TAG)


@patients.get("")
@patients.input(wire.PatientQuery, location="query")
@patients.output(wire.PatientPage)
@patients.doc(operation_id="listPatients")
def list_patients(query_data: wire.PatientQuery) -> wire.PatientPage:
    """The patients, page by page"""
    asked = query_data
    last = None if asked.before is None else (asked.after, asked.before)
    rows, before = listed_page(storage, asked.limit, last, asked.search, asked.sort)
    after, number = before or (None, None)
    more = asked.next_page("/api/patients", after=after, before=number)
    return wire.PatientPage(patients=[_answer(row) for row in rows], next=more)


@patients.get("/<patient_id>")
@patients.output(wire.Patient)
@patients.doc(operation_id="getPatient")
def show_patient(patient_id: str) -> wire.Patient:
    """A patient with all scans"""
    return patient_answer(patient_id)


@patients.patch("/<patient_id>")
@patients.input(wire.PatientChange)
@patients.output(wire.Patient)
@patients.doc(operation_id="renamePatient")
def change_patient(patient_id: str, json_data: wire.PatientChange) -> wire.Patient:
    """Give a patient another code

    A code of your own, never a name: it is shown in the list and kept with the scans.
    """
    rename_patient(storage, patient_id, checked_code(json_data.code))
    return patient_answer(patient_id)


@patients.delete("/<patient_id>")
@patients.output({}, status_code=204)
@patients.doc(operation_id="deletePatient", responses={500: "Deleted, but files are left; they are tried again"})
def remove_patient(patient_id: str) -> tuple[str, int]:
    """Delete a patient: plan, scans, and everything made of them

    Deleting who is not there is no error.  204 says that all files are gone.
    """
    browser_forgets()
    service.delete_patient(patient_id)
    return "", 204


@owners.put("/<scan_id>/patient")
@owners.input(wire.ScanOwner)
@owners.output(wire.Patient)
@owners.doc(operation_id="putScanPatient", responses={409: "The same file is a scan of that patient already"})
def move(scan_id: str, json_data: wire.ScanOwner) -> wire.Patient:
    """Say whose scan it is

    What was planned on it goes with it; a patient without scans is not kept.  Of scans that do not look like one
    patient's, `same_as` answers the question, once and for all.
    """
    patient = move_scan(storage, scan_id, json_data.patient, json_data.again, json_data.same_as)
    return patient_answer(patient)


@patients.get("/<patient_id>/plan")
@patients.output(wire.StoredPlan)
@patients.doc(operation_id="getPlan")
def show_plan(patient_id: str) -> Response:
    """The patient's plan: lines, patterns, tumours, notes

    Points are mm in the frame of the scan that each item names.  The ETag is what a change has to name.
    """
    return _plan_answer(patient_id, get_plan(storage, patient_id))


@patients.get("/<patient_id>/plan/versions/<int:version>")
@patients.output(wire.StoredPlan)
@patients.doc(operation_id="getPlanVersion")
def show_version(patient_id: str, version: int) -> Response:
    """The plan as it was; the last fifty versions are kept"""
    return _plan_answer(patient_id, get_plan(storage, patient_id, version))


@patients.put("/<patient_id>/plan")
@patients.input(Plan)
@patients.input(IfMatch, location="headers")
@patients.input(wire.SamePatient, location="query")
@patients.output(wire.StoredPlan)
@patients.doc(
    operation_id="putPlan",
    responses={
        409: "Names another patient, or a scan deleted meanwhile",
        412: "Changed by somebody else meanwhile",
        413: "Too large",
        428: "If-Match is missing",
    },
)
def replace_plan(patient_id: str, json_data: Plan, headers_data: IfMatch, query_data: wire.SamePatient) -> Response:
    """Replace the plan

    At most 500 items, its lines with 50,000 points together; each item names one of the patient's scans.  Lines and
    places that are new lie within 10 mm of that scan's skin, but for points over a hole (`bridged`).  A plan that names
    another code and other scans is another patient's, unless `same_patient`.  Places on a scan with a length are in the
    true size, unless `scans` says another, as the plan that was read did.
    """
    if headers_data.tag is None:
        raise refuse(428, UNSEEN)
    check_whose(json_data.model_dump(mode="json"), [patient_id], query_data.same_patient)
    plan = _in_present_sizes(json_data, patient_id)
    _check(plan, patient_id)
    items = [item.model_dump(mode="json") for item in plan.items]
    try:
        return _plan_answer(patient_id, put_plan(storage, patient_id, items, headers_data.tag))
    except Changed as changed:
        raise refuse(412, CHANGED, {"ETag": f'"{changed.etag}"'}) from changed


@plans_of_fits.get("/<fit_id>/plan.json")
@plans_of_fits.output(wire.PlanOnScan, description="The whole plan on the fit's scan")
@plans_of_fits.doc(operation_id="getPlanOnFit", responses={409: "Not done"})
def show_plan_on_fit(fit_id: str) -> Response:
    """The patient's plan on the scan of this fit, in its frame and unit

    Items made on another scan of the patient are transferred from the newest fit of that scan, with the 90 % radius of
    each point.
    """
    response = bytes_answer(service.plans.on_fit(fit_id), JSON, PERSONAL)
    response.headers["Content-Disposition"] = f"attachment; filename={service.reports.file_name('plan.json', fit_id)}"
    return response


def _in_present_sizes(plan: Plan, patient_id: str) -> Plan:
    """With its places in the sizes that the scans have."""
    said = {scan.id: scan.scale for scan in plan.scans if scan.scale is not None}
    if not said:
        return plan
    now = {row.id: scale_of(row) for row in get_scans(storage, scans_of_patient(storage, patient_id))}
    factors = {scan: now[scan] / scale for scan, scale in said.items() if scan in now}
    return plan.model_copy(update={"items": [times(item, factors.get(item.scan, 1.0)) for item in plan.items]})


def _check(plan: Plan, patient_id: str) -> None:
    """Raises BadDrawing with a sentence, NotFound when the patient is gone."""
    check_printable(texts_of(plan.items))
    context = app_context()
    scans = {row.id: row for row in get_scans(storage, scans_of_patient(storage, patient_id))}
    placed: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for item in plan.items:
        scan = scans.get(item.scan)
        if scan is None:
            raise BadDrawing(f'The item "{item.id}" was made on a scan that is none of this patient; name one that is.')
        if isinstance(item, PlanLine | PlanNote):
            for shape in shapes_of(item.model_dump(mode="json")):
                check_near_scan(shape["name"], shape["points"], scan)
                placed[scan.id].append(shape)
        elif isinstance(item, PlanLesion):
            check_near_scan(item.name, [item.center], scan)
        else:
            drawing_with(context.model_of(scan.facts).rig, *asked_of(item))
    for name, shapes in placed.items():
        service.skin_checks.check(scans[name], shapes)


def _plan_answer(patient_id: str, plan: PatientPlan) -> Response:
    named = {item.get("scan") for item in plan.items}
    rows = get_scans(storage, [scan for scan in scans_of_patient(storage, patient_id) if scan in named])
    document = {
        "schema": "breastrig/plan@1",
        "unit": "mm",
        "patient": get_patient(storage, patient_id).code,
        "version": plan.version,
        "whole": plan.is_whole,
        "scans": [
            {"id": row.id, "stance": row.facts["stance"]["proposed"], "sha256": row.sha256}
            | ({} if scale_of(row) == 1.0 else {"scale": scale_of(row)})
            for row in rows
        ],
        "items": list(plan.items),
    }
    response = Response(json.dumps(document), mimetype=JSON, headers={"Cache-Control": "no-store"})
    response.set_etag(plan.etag)
    return response


def patient_answer(patient_id: str) -> wire.Patient:
    """The patient as the API shows it. Raises NotFound."""
    return _answer(listed_patient(storage, patient_id))


def _answer(row: ListedCase) -> wire.Patient:
    return wire.Patient.of(
        row,
        plan_version=row.plan,
        planned=wire.Planned(**json.loads(row.planned)),
        scans=[_scan(scan) for scan in row.scans],
        links=wire.PatientLinks.at(f"/api/patients/{row.id}"),
    )


def _scan(row: ListedScan) -> wire.PatientScan:
    days, fit = config.keep_days, row.fit
    until = None if days is None else datetime.fromisoformat(row.created_at) + timedelta(days=days)
    fitted = fit.stance if fit is not None and fit.state == "done" else None
    return wire.PatientScan.of(
        row,
        stance=fitted or row.stance,
        delete_at=None if until is None else iso_utc(until),
        thumbnail=f"/api/scans/{row.id}/thumbnail.png",
        fit=None if fit is None else wire.PatientFit.of(fit),
    )

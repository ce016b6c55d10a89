"""Visits: the day of each scan, and what changed between them."""

from apiflask import APIBlueprint
from flask import Response

from breastrig.api.answers import GLB, JSON, PERSONAL, PNG, bytes_answer, file_of
from breastrig.api.app_context import service, storage
from breastrig.api.language import current_language, in_language
from breastrig.api.routes.patients import TAG
from breastrig.api.wire import visits as wire
from breastrig.use.cases.visits import ScanVisit, say_visit, visit_of

visits = APIBlueprint("visits", __name__, url_prefix="/api/patients", tag=TAG)
visits_of_scans = APIBlueprint("visits_of_scans", __name__, url_prefix="/api/scans", tag=TAG)
SVG = "image/svg+xml"


@visits_of_scans.put("/<scan_id>/visit")
@visits_of_scans.input(wire.GivenVisit)
@visits_of_scans.output(wire.ScanVisit)
@visits_of_scans.doc(operation_id="putVisit")
def put_visit(scan_id: str, json_data: wire.GivenVisit) -> wire.ScanVisit:
    """Say on which day a scan was taken, and what the visit is called

    A day is never guessed from a file.  Null: not known.
    """
    case = storage.case_of_scan(scan_id)
    return _answer(scan_id, say_visit(case, scan_id, json_data.date, json_data.label))


@visits.get("/<patient_id>/visits")
@visits.output(wire.PatientVisits)
@visits.doc(operation_id="getVisits")
def show_visits(patient_id: str) -> wire.PatientVisits:
    """The day of each scan, as a person has said it"""
    case = storage.case(patient_id)
    return wire.PatientVisits(scans=[_answer(one.id, visit_of(case, one.id)) for one in case.scans()])


@visits.get("/<patient_id>/visits.json")
@visits.output(wire.VisitsFile, description="Measures at each visit, and their changes")
@visits.doc(operation_id="getVisitsDocument")
def show_document(patient_id: str) -> Response:
    """What the dated scans say over time

    Scans of one stance, by the newest fit of each; stances with fewer than two days are left out, and `asked` names the
    scans whose day is missing.
    """
    return bytes_answer(service.visits.document(patient_id), JSON, PERSONAL)


@visits.get("/<patient_id>/visits.svg")
@visits.input(wire.PlotQuery, location="query")
@visits.doc(operation_id="getVisitsPlots", responses={200: file_of(SVG, "A panel a measure")})
def show_plots(patient_id: str, query_data: wire.PlotQuery) -> Response:
    """Measures over the visits, SVG

    With 90 % bands, and published ranges in grey as context.
    """
    made = service.visits.plots(patient_id, query_data.stance, current_language())
    return in_language(bytes_answer(made, SVG, PERSONAL))


@visits.get("/<patient_id>/change.png")
@visits.input(wire.ChangeQuery, location="query")
@visits.doc(operation_id="getChangePicture", responses={200: file_of(PNG, "Three views over the colours' bar")})
def show_change(patient_id: str, query_data: wire.ChangeQuery) -> Response:
    """The signed change of the skin between two scans in one stance, as a picture

    On the scan of the earlier visit: blue in, orange out; pale within the band, grey where a scan shows no skin.
    """
    return _change(patient_id, query_data, "png", PNG)


@visits.get("/<patient_id>/change.glb")
@visits.input(wire.ChangeQuery, location="query")
@visits.doc(operation_id="getChange", responses={200: file_of(GLB, "Its extras have change and band, mm")})
def show_change_map(patient_id: str, query_data: wire.ChangeQuery) -> Response:
    """The same on the fitted skin, GLB, in the frame of the earlier scan"""
    return _change(patient_id, query_data, "glb", GLB)


def _change(patient_id: str, asked: wire.ChangeQuery, kind: str, media_type: str) -> Response:
    made = service.visits.change(patient_id, (asked.scan, asked.with_), kind)
    return bytes_answer(made, media_type, PERSONAL)


def _answer(scan_id: str, visit: ScanVisit) -> wire.ScanVisit:
    return wire.ScanVisit(scan=scan_id, date=visit.date, label=visit.label)

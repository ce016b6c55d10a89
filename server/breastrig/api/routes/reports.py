"""The report of a fit, as pages of PDF and as numbers; made when it is first asked for."""

import json
import re
from typing import Literal

from apiflask import APIBlueprint
from flask import Response
from pydantic import Field

from breastrig.api.answers import CSV, JSON, PDF, PERSONAL, PNG, STL, VTU, ZIP, bytes_answer, file_of, in_memory
from breastrig.api.app_context import app_context, config, service, storage
from breastrig.api.language import current_language
from breastrig.api.routes.fits import FITS_TAG
from breastrig.api.wire import files as wire_files
from breastrig.api.wire.common import Wire
from breastrig.core.errors import BadSettings, Conflict
from breastrig.core.stances import SIDES
from breastrig.languages.catalogue import Language
from breastrig.report.table import csv_bytes
from breastrig.storage.documents.fits import get_fit
from breastrig.use.guides.template import guide_said

reports = APIBlueprint("reports", __name__, url_prefix="/api/fits", tag=FITS_TAG)


class PagesQuery(Wire):
    """In which language pages are."""

    language: Language | None = Field(None, description="of the pages; without it that of the request")

    @property
    def chosen(self) -> str:
        return self.language or current_language()


class ReportQuery(PagesQuery):
    """The other stance that the report includes."""

    with_: str | None = Field(
        None, alias="with", max_length=64, description="id of a fit of the same patient in another stance"
    )


class PageQuery(ReportQuery):
    """Which page of which report."""

    page: int = Field(1, ge=1, le=99, description="counted from 1")


@reports.get("/<fit_id>/report.pdf")
@reports.input(ReportQuery, location="query")
@reports.doc(
    operation_id="getReport",
    responses={200: file_of(PDF, "Pictures, numbers, and a tape sheet of the drawing"), 409: "Not done"},
)
def show_report(fit_id: str, query_data: ReportQuery) -> Response:
    """Pictures, measures and settings, PDF

    With `with` both stances of one patient and the changes between them.
    """
    scans = _scans_of_done(fit_id, query_data.with_)
    content = service.reports.made("report.pdf", fit_id, query_data.with_, query_data.chosen)
    return _file(scans, content, PDF, "report.pdf", fit_id, query_data.with_)


@reports.get("/<fit_id>/report.png")
@reports.input(PageQuery, location="query")
@reports.doc(
    operation_id="getReportPage",
    responses={200: file_of(PNG, "One page; the header Page-Count says how many there are"), 409: "Not done"},
)
def show_report_page(fit_id: str, query_data: PageQuery) -> Response:
    """One page of the report, PNG

    The same pages as report.pdf, A4 at 144 pixels an inch.
    """
    _scans_of_done(fit_id, query_data.with_)
    content, count = service.reports.page(query_data.page, fit_id, query_data.with_, query_data.chosen)
    response = bytes_answer(content, PNG, PERSONAL)
    response.headers["Page-Count"] = str(count)
    return response


@reports.get("/<fit_id>/template.pdf")
@reports.input(PagesQuery, location="query")
@reports.doc(
    operation_id="getTemplate",
    responses={200: file_of(PDF, "Sheets of A4 to print at 100 %, and how far off each line is"), 409: "Not done"},
)
def show_template(fit_id: str, query_data: PagesQuery) -> Response:
    """The plan in true size, laid flat, PDF

    Skin around the planned lines of each side, to be cut out and laid on notch and nipple in the position of the scan.
    422 says why lines cannot be laid flat.
    """
    scans = _scans_of_done(fit_id)
    return _file(
        scans, service.reports.made("template.pdf", fit_id, None, query_data.chosen), PDF, "template.pdf", fit_id
    )


class GuideQuery(Wire):
    """Which side."""

    side: Literal["L", "R"] = Field(description="the patient's")


@reports.get("/<fit_id>/guide.stl")
@reports.input(GuideQuery, location="query")
@reports.doc(operation_id="getGuide", responses={200: file_of(STL, "A closed shell, mm"), 409: "Not done"})
def show_guide(fit_id: str, query_data: GuideQuery) -> Response:
    """A guide of one side to print in 3D, STL

    A shell of 2 mm on the skin of the scan's position, with slots along the planned lines, a hole for the nipple and an
    arrow to the notch; header and file name say how far its tip is from there.
    """
    scans, content = _scans_of_done(fit_id), service.reports.made(f"guide_{query_data.side}.stl", fit_id)
    far = re.findall(r"(\d+) mm", guide_said(content))[0]
    return _file(scans, content, STL, f"guide-{SIDES[query_data.side]}-notch-{far}mm.stl", fit_id)


@reports.get("/<fit_id>/dicom.zip")
@reports.doc(
    operation_id="getDicom",
    responses={200: file_of(ZIP, "report.dcm, measures.dcm, skin.dcm, scan.dcm"), 409: "Not done"},
)
def show_dicom(fit_id: str) -> Response:
    """The fit as DICOM objects of one study, zip

    Encapsulated PDF and STL, and a TID 1500 measurement report, with the patient's code as PatientID.
    """
    return _file(_scans_of_done(fit_id), service.reports.made("dicom.zip", fit_id), ZIP, "dicom.zip", fit_id)


class ToArchive(Wire):
    """Which archive."""

    archive: str = Field(max_length=100, description="one of `archives` of /api/meta")


class Archived(Wire):
    """The archive has stored all that it is to have."""

    notes: list[str] = Field(description="what it noted of them, a sentence each")


@reports.post("/<fit_id>/archive")
@reports.input(ToArchive)
@reports.output(Archived)
@reports.doc(operation_id="sendToArchive", responses={409: "Not done", 502: "What is stored, what is not, and why"})
def send_to_archive(fit_id: str, json_data: ToArchive) -> Archived:
    """Sends the same objects to an archive

    Only to those that the service's administrator has named, with the patient of the hospital's file where there is
    one; some seconds.
    """
    from breastrig.archive.send import send_zip  # the extra `pacs`; a service with archives has it

    _scans_of_done(fit_id)
    node = config.archives.get(json_data.archive)
    if node is None:
        raise BadSettings("This service sends to no archive of that name; its administrator names them.")
    if node.identities is None:
        content = service.reports.made("dicom.zip", fit_id)
    else:
        content = service.reports.dicom_for(fit_id, node.identities)
    return Archived(notes=list(send_zip(content, node)))


@reports.get("/<fit_id>/measures.json")
@reports.input(ReportQuery, location="query")
@reports.output(wire_files.MeasuresFile, description="Measures of one stance, or of two and their changes")
@reports.doc(operation_id="getMeasures", responses={409: "Not done"})
def show_measures(fit_id: str, query_data: ReportQuery) -> Response:
    """The report's numbers

    Lengths straight and along the skin, volumes and ratios of both breasts; with `with` of both stances of one patient,
    and the changes between them.
    """
    _scans_of_done(fit_id, query_data.with_)
    return bytes_answer(service.reports.made("measures.json", fit_id, query_data.with_), JSON, PERSONAL)


@reports.get("/<fit_id>/measures.csv")
@reports.input(ReportQuery, location="query")
@reports.doc(operation_id="getMeasuresTable", responses={200: file_of(CSV, "The same as a table"), 409: "Not done"})
def show_measures_table(fit_id: str, query_data: ReportQuery) -> Response:
    """The report's numbers as a table, CSV

    The columns of `breastrig report`'s measures.csv, every digit; each row has the verdict of its fit.
    """
    scans = _scans_of_done(fit_id, query_data.with_)
    found = json.loads(service.reports.made("measures.json", fit_id, query_data.with_))
    verdicts = {one["name"]: (one.get("verdict") or {}).get("level", "") for one in found["stances"]}
    return _file(scans, csv_bytes(found["measures"], verdicts), CSV, "measures.csv", fit_id, query_data.with_)


@reports.get("/<fit_id>/volume.vtu")
@reports.doc(
    operation_id="getVolume",
    responses={200: file_of(VTU, "Tetrahedra of the fitted body"), 409: "Not done"},
)
def show_volume(fit_id: str) -> Response:
    """The inside of the body, VTU

    Tetrahedra for finite elements, in the scan's unit and frame: regions skin, breast_L, breast_R, chest_wall, trunk;
    of each node the model's vertex, and whether it is fixed or slides.
    """
    return _file(_scans_of_done(fit_id), service.reports.made("volume.vtu", fit_id), VTU, "volume.vtu", fit_id)


def _scans_of_done(fit_id: str, other: str | None = None) -> list[str]:
    """The scans of fits that are done.  Raises NotFound, Conflict, or BadSettings for a fit compared with itself."""
    if other == fit_id:
        raise BadSettings("A report shows two different fits; leave `with` out to show one.")
    found = [get_fit(storage, known) for known in (fit_id, other) if known is not None]
    for fit in found:
        if fit.state != "done":
            raise Conflict(f"The fit {fit.id} is {fit.state}; a report needs fits that are done.")
    return [fit.scan for fit in found]


def _file(scans: list[str], content: bytes, media_type: str, name: str, *fits: str | None) -> Response:
    """To take away, under a name with what says whose it is."""
    named = service.reports.file_name(name, *filter(None, fits))
    return app_context().patients_file(scans, in_memory(content), media_type, named)

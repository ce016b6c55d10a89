"""The audit log, for administrators, and certificates of deletions, for whoever has deleted, too."""

from functools import partial
from itertools import islice

from apiflask import APIBlueprint
from flask import Response, render_template

from breastrig.api.access.audited import who_asks
from breastrig.api.access.person import Role, current_person
from breastrig.api.answers import PDF, PERSONAL, bytes_answer, file_of
from breastrig.api.app_context import service, storage
from breastrig.api.errors import refuse
from breastrig.api.language import current_language, in_language
from breastrig.api.wire import audit as wire
from breastrig.audit.certificate import certificate
from breastrig.audit.log import AuditLog, log_files
from breastrig.audit.read import check, deletions, lines_from, read_mark
from breastrig.languages.translation import said

LINES = "text/plain"

audit = APIBlueprint(
    "audit", __name__, url_prefix="/api/audit", tag={"name": "audit", "description": "Who did what; administrators."}
)


@audit.get("")
@audit.input(wire.AuditQuery, location="query")
@audit.output(wire.AuditPage)
@audit.doc(operation_id="listAudit", responses={403: "Not an administrator"})
def list_lines(query_data: wire.AuditQuery) -> wire.AuditPage:
    """The audit log, the newest line first"""
    lines, before = _page(query_data)
    more = query_data.next_page("/api/audit", before=before)
    return wire.AuditPage(lines=lines, next=more)


@audit.get("/page")
@audit.input(wire.AuditQuery, location="query")
@audit.doc(hide=True)
def show_page(query_data: wire.AuditQuery) -> Response:
    """The log as a plain page, without script"""
    lines, older = _page(query_data)
    root, asked = storage.root, query_data.id
    deleted = bool(asked) and next(deletions(root, asked), None) is not None
    language = current_language()
    shown = {"lines": lines, "older": older, "checked": check(root), "id": asked, "deleted": deleted}
    html = render_template("audit.html", **shown, language=language, t=partial(said, language=language))
    return in_language(Response(html, mimetype="text/html"))


def _log() -> AuditLog:
    """With all that was done."""
    service.audit.flush()
    return service.audit


def _page(asked: wire.AuditQuery) -> tuple[list[wire.AuditLine], int | None]:
    """Lines, and the number that the next page begins below; None after the last."""
    found = list(islice(lines_from(_log().root, asked.id, asked.since, asked.before), asked.limit + 1))
    before = found[asked.limit - 1]["n"] if len(found) > asked.limit else None
    known = wire.AuditLine.model_fields.keys()
    lines = [
        wire.AuditLine(ids=line.get("of", {}), **{name: line[name] for name in line if name in known})
        for line in found[: asked.limit]
    ]
    return lines, before


@audit.get("/check")
@audit.input(wire.AnchorQuery, location="query")
@audit.output(wire.AuditCheck)
@audit.doc(operation_id="checkAudit", responses={403: "Not an administrator"})
def check_lines(query_data: wire.AnchorQuery) -> wire.AuditCheck:
    """Whether all lines are as they were written"""
    found = check(_log().root, read_mark(query_data.anchor) if query_data.anchor else None)
    return wire.AuditCheck(lines=found.lines, end=str(found.end), fault=found.fault)


@audit.get("/log.jsonl")
@audit.doc(operation_id="getAuditLog", responses={200: file_of(LINES, "One line each"), 403: "Not an administrator"})
def show_log() -> Response:
    """The whole audit log as it is kept"""
    files = log_files(_log().folder)
    headers = {"Content-Disposition": "attachment; filename=audit.jsonl", "Cache-Control": "no-store"}
    return Response((file.read_bytes() for file in files), mimetype=LINES, headers=headers)


@audit.get("/deletions/<deleted_id>/certificate.pdf")
@audit.doc(
    operation_id="getDeletionCertificate",
    responses={
        200: file_of(PDF, "One A4 page"),
        403: "Neither an administrator nor who has deleted it",
        404: "No such deletion",
        409: "Not complete",
    },
)
def show_certificate(deleted_id: str) -> Response:
    """The certificate of a deletion: what was removed, when, by whom, and what it does not cover"""
    found = certificate(_log().root, deleted_id)
    if found.who != who_asks() and not current_person().role.includes(Role.ADMINISTER):
        raise refuse(403, "A certificate is given to administrators, and to whoever has deleted the patient.")
    response = in_language(bytes_answer(service.reports.certificate(found, current_language()), PDF, PERSONAL))
    response.headers["Content-Disposition"] = f"attachment; filename=deletion_{deleted_id}.pdf"
    return response

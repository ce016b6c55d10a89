"""What of the requests goes into the audit log: their kinds, and the hooks that write it.

A change or deletion is written before it is done, so none is done that is not written; a second line follows where it
was refused, or made something.  Openings, exports and refusals are written when they are answered; the same person
opening the same thing again within five minutes is one opening.
"""

import sqlite3
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from apiflask import APIFlask
from flask import Response, g, request
from limits import RateLimitItemPerMinute
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

from breastrig.api.access.person import HOLDER, VISITOR, Role, current_person
from breastrig.api.access.roles import LEAST, SAFE_METHODS
from breastrig.audit.deletions import Deletion
from breastrig.audit.log import AuditLog, Entry
from breastrig.cases import layout
from breastrig.index import questions
from breastrig.storage.storage import Storage

OPEN, CHANGE, EXPORT, LINK, DELETE = "open", "change", "export", "link", "delete"
BEFORE = (CHANGE, LINK, DELETE)  # written before it is done
SENDS = ("reports.send_to_archive",)  # exports that leave the house: written before, too
ONCE = RateLimitItemPerMinute(1, 5)  # openings of one thing by one person
NAME_CHARACTERS = 100

KINDS = {  # of calls whose kind does not follow from their method and role
    **dict.fromkeys(
        (
            "results.show_result_zip", "results.show_fitted_ply", "reports.show_report", "reports.show_measures_table",
            "reports.show_template", "reports.show_guide", "reports.show_volume", "of_scans.write_landmark_file",
            "shared.show_fitted_ply", "shared.show_report", "audit.show_log", "audit.show_certificate",
            "reports.show_dicom", "reports.send_to_archive",
        ),
        EXPORT,
    ),
    **dict.fromkeys(("shares.make_share", "shares.remove_share", "shares.refresh", "shares.unlock"), LINK),
    **dict.fromkeys(("patients.remove_patient", "scans.remove_scan"), DELETE),
    "shared.open_share": OPEN,
}  # fmt: skip
_MODEL = "The model and what is offered for all patients."
NOT_AUDITED = {  # calls and whole blueprints
    **dict.fromkeys(("page", "share_page", "docs"), "The page's own files, which hold nothing of a patient."),
    **dict.fromkeys(("models", "meta.about", "meta.list_examples", "meta.show_protocol"), _MODEL),
    "operations": "How the service is doing; says nothing about patients.",
    "sign_in": "Shows nothing of a patient; whatever is opened afterwards names who has signed in.",
    "scans.show_thumbnail": "A small picture without colours, part of the list, whose opening is written.",
    "persons.stay": "Keeps a session; shows nothing of a patient.",
    "shared.close_shared": "The end of a visit, whose beginning is written.",
}


IDS = {  # of addresses
    "patient_id": "patient", "scan_id": "scan", "fit_id": "fit", "share_id": "link", "deleted_id": "deleted",
}  # fmt: skip
IN_BODY = {"scan": "scan", "from_fit": "fit", "to_fit": "to_fit", "patient": "to_patient"}
NAMED_IN_BODY = ("fits.start_fit", "transfers.transfer_drawing", "transfers.propose_marks", "owners.move")
MAKES = {  # what the id of the answer is of
    "scans.upload_scan": "scan",
    "meta.open_example": "scan",
    "owners.move": "patient",
    "fits.start_fit": "fit",
    "fits.predict_stance": "fit",
    "shares.make_share": "link",
    "shared.open_share": "link",
}


def kind_of(endpoint: str, method: str) -> str | None:
    """The kind of a call; None for one that is not written."""
    if not endpoint or method == "OPTIONS" or not NOT_AUDITED.keys().isdisjoint((endpoint, endpoint.partition(".")[0])):
        return None
    looks = method in SAFE_METHODS or LEAST.get(endpoint) is Role.LOOK
    return KINDS.get(endpoint, OPEN if looks else CHANGE)


def register_audit(app: APIFlask, log: AuditLog, storage: Storage) -> None:
    """Adds the hooks; to be registered after the guards, which refuse before anything is written."""
    opened = MovingWindowRateLimiter(MemoryStorage())

    def is_new(made: Mapping[str, str]) -> bool:
        """Whether this person has not opened the same just now: the first id in the address, else the list at it."""
        return opened.hit(ONCE, who_asks(made), next(iter(_ids().values()), request.path))

    @app.before_request
    def begin() -> None:
        how = request.endpoint or ""
        kind = kind_of(how, request.method)
        if kind is None or (kind not in BEFORE and how not in SENDS):
            return
        of = _of(storage)
        if kind == DELETE:
            g.audited = Deletion(log, who_asks(), how, of, _name())
        else:
            g.audited = log.append(Entry(who_asks(), kind, how, of, _name()))[-1]

    @app.after_request
    def end(response: Response) -> Response:
        how, status, started = request.endpoint or "", response.status_code, g.get("audited")
        kind = kind_of(how, request.method)
        if isinstance(started, Deletion):
            started.ended()
        elif kind is not None:
            made = _made(response) if status < 400 else {}
            line: dict[str, object] = {} if started is None else {"line": started.line}
            if status == 403 or (status >= 400 and started is not None):
                log.later(Entry(who_asks(), "refused", how, _of(storage), line | {"status": status}))
            elif started is not None and made:
                log.later(Entry(who_asks(), "done", how, made, line))
            elif started is None and status < 400 and (kind == EXPORT or (kind == OPEN and is_new(made))):
                log.later(Entry(who_asks(made), kind, how, _of(storage) or _with_owner(storage, made), _name()))
        return response


def who_asks(made: Mapping[str, str] = MappingProxyType({})) -> str:
    """Who asks, as the log names them: the holder of the token, a person, or the visitor of a link (perhaps `made`)."""
    if (request.endpoint or "").startswith("shared."):
        return f"link:{made.get('link') or _ids().get('link', '')}"
    person = current_person()
    return person.id if person == HOLDER else f"person:{person.id}"


def _name() -> dict[str, object]:
    person = current_person()
    return {} if person in (HOLDER, VISITOR) else {"name": person.name[:NAME_CHARACTERS]}


def _ids() -> dict[str, str]:
    """The ids that the request names, by kind; nothing that has not their form."""
    given: dict[str, Any] = {IDS[name]: value for name, value in (request.view_args or {}).items() if name in IDS}
    if request.endpoint in NAMED_IN_BODY and request.is_json:
        body = request.get_json(silent=True)
        given |= {IN_BODY[name]: body[name] for name in IN_BODY if name in body} if isinstance(body, dict) else {}
    return {kind: value for kind, value in given.items() if isinstance(value, str) and layout.ID.fullmatch(value)}


def _of(storage: Storage) -> dict[str, str]:
    return _with_owner(storage, _ids())


def _with_owner(storage: Storage, ids: dict[str, str]) -> dict[str, str]:
    """With the patient, scan and fit that the ids belong to, as far as they are known."""

    def asked(rows: sqlite3.Connection) -> dict[str, str]:
        link, fit, scan = (ids.get(kind, "") for kind in ("link", "fit", "scan"))
        if link and (found := questions.fit_of_link(rows, link)):
            return dict(zip(("patient", "scan", "fit"), found, strict=True))
        if fit and (owner := questions.case_of_fit(rows, fit)):
            return dict(zip(("patient", "scan"), owner, strict=True))
        patient = questions.case_of_scan(rows, scan) if scan else None
        return {} if patient is None else {"patient": patient}

    return ({} if "patient" in ids else storage.index.asked(asked)) | ids if ids else {}


def _made(response: Response) -> dict[str, str]:
    """The ids of what the request has made."""
    kind = MAKES.get(request.endpoint or "")
    answer = response.get_json(silent=True) if kind is not None else None
    if kind is None or not isinstance(answer, dict):
        return {}
    return {kind: str(answer["id"])} | ({"patient": str(answer["patient"])} if "patient" in answer else {})

"""Share links, the visitor's side.  These are the only calls that a share's cookie is good for.

Every address but that of the opening holds the share's id, so that two links that are open in one browser have
nothing in common: no cookie, no cached answer, no address of the page.  What can be seen are the files of the share's
own snapshot (service/share_snapshots.py), whatever has become of plan and scan since.
"""

from apiflask import APIBlueprint
from flask import Response, render_template

from breastrig.api.answers import BINARY, CHECK_AGAIN, GLB, JSON, PDF, bytes_answer, file_of, media_type_of
from breastrig.api.app_context import app_context, config, storage
from breastrig.api.big_answers import big_answer
from breastrig.api.errors import refuse
from breastrig.api.routes.shares.share_credential import (
    begin_visit,
    check_passcode,
    close_visit,
    cookie_path,
    share_of_secret,
    visit_of,
)
from breastrig.api.routes.shares.shares import SHARES_TAG
from breastrig.api.wire import shares as wire_shares
from breastrig.api.wire.patients import PlanOnScan
from breastrig.core.assets import asset_folder
from breastrig.core.errors import NotFound
from breastrig.drawings.drawing_schema import DrawingFile
from breastrig.files.result import ResultFile
from breastrig.storage.documents.shares import StoredShare
from breastrig.storage.files import OpenedFile, share_place

shared = APIBlueprint("shared", __name__, url_prefix="/api/shared", tag=SHARES_TAG)
share_page = APIBlueprint("share_page", __name__, template_folder="templates", enable_openapi=False)

NO_STORE = "no-store"
# The header is about all of this service's pages in the browser.  So not "cookies", which would sign the owner out, nor
# "storage", which holds what the owner's page has not saved yet; the shared page itself stores nothing there.
CLEAR_CACHE = '"cache"'
NOT_OPEN = "The link is not open in this browser"
ENDED = "Expired or revoked"
OF_THE_SCAN = ("distances.bin", "report.pdf", "mesh.glb")


@shared.after_request
def keep_apart(response: Response) -> Response:
    """Sets headers that stop caches from answering one visitor with another one's content."""
    response.headers["Cache-Control"] = NO_STORE
    response.vary.add("Cookie")
    return response


@shared.post("/open")
@shared.input(wire_shares.ShareOpening)
@shared.output(wire_shares.SharedResult)
@shared.doc(
    operation_id="openShare",
    responses={
        403: "The passcode is wrong or missing",
        404: "No such link",
        410: ENDED,
        423: "Locked by wrong passcodes, until the owner unlocks it",
        429: "Too many",
    },
)
def open_share(json_data: wire_shares.ShareOpening) -> Response:
    """Open a share link

    Takes the secret after # and sets the cookie that the other calls need; its path is theirs.  The time of the opening
    is noted for the owner, nothing else.
    """
    app_context().rates.check("share")
    share = share_of_secret(json_data.token)
    check_passcode(share, json_data.passcode)
    response = Response(_result(share).model_dump_json(), mimetype=JSON)
    begin_visit(response, share)
    return response


@shared.post("/<share_id>/close")
@shared.output({}, status_code=204)
@shared.doc(operation_id="closeShared", responses={401: NOT_OPEN})
def close_shared(share_id: str) -> Response:
    """Close the link in this browser

    The cookie is taken back, and copies of it open nothing any more.
    """
    response = Response(status=204, headers={"Clear-Site-Data": CLEAR_CACHE})
    close_visit(response, share_id)
    return response


@shared.get("/<share_id>")
@shared.output(wire_shares.SharedResult)
@shared.doc(operation_id="getShared", responses={401: NOT_OPEN, 410: ENDED})
def show_shared(share_id: str) -> wire_shares.SharedResult:
    """The content of the opened link"""
    return _result(visit_of(share_id).share)


@shared.get("/<share_id>/result.json")
@shared.output(ResultFile, description="Numbers and parameters")
@shared.doc(operation_id="getSharedResult", responses={401: NOT_OPEN, 410: ENDED})
def show_result(share_id: str) -> Response:
    """The shared fit's result.json"""
    return _file(share_id, "result.json")


@shared.get("/<share_id>/fitted.glb")
@shared.doc(operation_id="getSharedGlb", responses={200: file_of(GLB, "The posed rig"), 410: ENDED})
def show_fitted_glb(share_id: str) -> Response:
    """The shared fit's posed rig, with what is drawn"""
    return _file(share_id, "fitted.glb")


@shared.get("/<share_id>/fitted.ply")
@shared.doc(operation_id="getSharedPly", responses={200: file_of(BINARY, "The posed surface"), 410: ENDED})
def show_fitted_ply(share_id: str) -> Response:
    """The shared fit's posed surface"""
    return _file(share_id, "fitted.ply")


@shared.get("/<share_id>/drawing.json")
@shared.output(DrawingFile, description="Polylines on the scan, or on the model where the link does not show the scan")
@shared.doc(operation_id="getSharedDrawing", responses={401: NOT_OPEN, 410: ENDED})
def show_drawing(share_id: str) -> Response:
    """The drawing on the shared fit's scan: the plan, or the fit's own drawing where there is none"""
    return _file(share_id, "drawing.json")


@shared.get("/<share_id>/plan.json")
@shared.output(PlanOnScan, description="The whole plan, likewise")
@shared.doc(operation_id="getSharedPlan", responses={401: NOT_OPEN, 410: ENDED})
def show_plan(share_id: str) -> Response:
    """The plan on the patient's skin; with its notes where the owner allowed it"""
    return _file(share_id, "plan.json")


@shared.get("/<share_id>/distances.bin")
@shared.doc(
    operation_id="getSharedDistances",
    responses={
        200: file_of(BINARY, "float32 for each vertex of the model, mm"),
        403: "The link does not show the scan, which they would tell",
        410: ENDED,
    },
)
def show_distances(share_id: str) -> Response:
    """The distance of each model vertex to the scan, when the link shows the scan"""
    return _file(share_id, "distances.bin")


@shared.get("/<share_id>/report.pdf")
@shared.doc(
    operation_id="getSharedReport",
    responses={
        200: file_of(PDF, "Pictures, numbers, and a tape sheet of the drawing"),
        403: "The link does not show the scan, which the report pictures",
        410: ENDED,
    },
)
def show_report(share_id: str) -> Response:
    """The shared fit's report, when the link shows the scan"""
    return _file(share_id, "report.pdf")


@shared.get("/<share_id>/mesh.glb")
@shared.doc(
    operation_id="getSharedMesh",
    responses={
        200: file_of(GLB, "The scan, metres"),
        403: "The link does not show it",
        410: ENDED,
        503: "Too many large files are being sent; ask again after Retry-After seconds",
    },
)
def show_mesh(share_id: str) -> Response:
    """The scan, when the link shows it; without what was cut away, and without colours unless the owner chose `full`"""
    return _file(share_id, "mesh.glb", "scan.glb")


@share_page.get("/s")
@share_page.get("/s/<share_id>")
def page(share_id: str = "") -> Response:
    """The read-only page; it holds nothing until its script has opened the link, or found it open in this browser.

    Where the page is built it shows the body; else numbers and files, which need no script but a small one.
    """
    built = (config.web or asset_folder("web")) / "index.html"
    html = built.read_text(encoding="utf-8") if built.is_file() else render_template("share.html")
    return Response(html, mimetype="text/html", headers={"Cache-Control": NO_STORE})


@share_page.get("/s/share.js")
def script() -> Response:
    return bytes_answer(render_template("share.js").encode(), "text/javascript", CHECK_AGAIN)


def _file(share_id: str, name: str, download_as: str | None = None) -> Response:
    """One of the files that the link shows.  Raises 403 for one that it does not show, NotFound for one it has not."""
    visit = visit_of(share_id)
    if visit.share.scan == "none" and name in OF_THE_SCAN:
        raise refuse(403, "This link does not show the scan, and this file would.")
    file = _found(visit.share, name)
    if file is None:
        raise NotFound(f"This result has no {name}.")
    return big_answer(
        app_context().big_answers,
        file,
        media_type_of(name),
        visit.is_open,
        share_id=share_id,
        download_as=download_as or name,
    )


def _found(share: StoredShare, name: str) -> OpenedFile | None:
    return storage.files.find(share_place(share.snapshot or ""), name)


def _result(share: StoredShare) -> wire_shares.SharedResult:
    place = cookie_path(share.id)
    shown = {name: f"{place}/{name}" if _found(share, name) else None for name in OF_THE_SCAN}
    return wire_shares.SharedResult(
        id=share.id,
        expires_at=share.expires_at,
        shown_at=share.snapshot_at,
        links=wire_shares.SharedLinks.at(
            place, distances=shown["distances.bin"], report=shown["report.pdf"], mesh=shown["mesh.glb"]
        ),
    )

"""Share links, the visitor's side.  These are the only calls that a share's cookie is good for.

What can be seen is decided by the share's own row: one fit, and its scan only when the owner said so.
"""

from apiflask import APIBlueprint
from flask import Response, render_template
from werkzeug.security import check_password_hash

from breastrig.api import wire_files, wire_shares
from breastrig.api.answers import BINARY, CHECK_AGAIN, GLB, JSON, PDF, bytes_answer, file_answer, file_of
from breastrig.api.current import behind
from breastrig.api.scans import mesh_file
from breastrig.api.security import refuse
from breastrig.api.share_credential import hand_out, share_behind, visited_share
from breastrig.api.shares import SHARES_TAG
from breastrig.core.assets import asset_folder
from breastrig.core.errors import NotFound
from breastrig.gltf.plain_mesh import plain_mesh
from breastrig.storage.files import fit_place
from breastrig.storage.fits import get_fit
from breastrig.storage.shares import ShareRow, note_opening
from breastrig.storage.storage import utc_now

shared = APIBlueprint("shared", __name__, url_prefix="/api/shared", tag=SHARES_TAG)
share_page = APIBlueprint("share_page", __name__, template_folder="templates", enable_openapi=False)

NO_STORE = "no-store"
MEDIA_TYPES = {
    "result.json": JSON,
    "fitted.glb": GLB,
    "fitted.ply": BINARY,
    "drawing.json": JSON,
    "distances.bin": BINARY,
}


@shared.post("/open")
@shared.input(wire_shares.ShareOpening)
@shared.output(wire_shares.SharedResult)
@shared.doc(
    operation_id="openShare",
    responses={
        403: "The passcode is wrong or missing",
        404: "No such link",
        410: "Expired or revoked",
        429: "Too many",
    },
)
def open_share(json_data: wire_shares.ShareOpening) -> Response:
    """Open a share link

    Takes the secret after # and sets the cookie that the other calls need.  The time of the opening is noted for
    the owner, nothing else.
    """
    here = behind()
    here.rates.check("share")
    share = share_behind(json_data.token)
    if share.passcode_hash is not None:
        if json_data.passcode is None:
            raise refuse(403, "This link needs a passcode; ask the person who sent it.")
        here.rates.check("passcode", share.id)
        if not check_password_hash(share.passcode_hash, json_data.passcode):
            raise refuse(403, "This is not the link's passcode; ask the person who sent it.")
    note_opening(here.service.storage, share.id, utc_now())
    response = Response(_result(share).model_dump_json(), mimetype=JSON)
    hand_out(response, share, json_data.token)
    return response


@shared.get("")
@shared.output(wire_shares.SharedResult)
@shared.doc(operation_id="getShared", responses={401: "No link was opened", 410: "Expired or revoked"})
def show_shared() -> wire_shares.SharedResult:
    """What the opened link shows"""
    return _result(visited_share())


@shared.get("/result.json")
@shared.output(wire_files.ResultFile, description="Numbers and parameters")
@shared.doc(operation_id="getSharedResult", responses={401: "No link was opened", 410: "Expired or revoked"})
def show_result() -> Response:
    """The shared fit's result.json"""
    return _file("result.json")


@shared.get("/fitted.glb")
@shared.doc(operation_id="getSharedGlb", responses={200: file_of(GLB, "The posed rig"), 410: "Expired or revoked"})
def show_fitted_glb() -> Response:
    """The shared fit's posed rig"""
    return _file("fitted.glb")


@shared.get("/fitted.ply")
@shared.doc(
    operation_id="getSharedPly", responses={200: file_of(BINARY, "The posed surface"), 410: "Expired or revoked"}
)
def show_fitted_ply() -> Response:
    """The shared fit's posed surface"""
    return _file("fitted.ply")


@shared.get("/drawing.json")
@shared.output(wire_files.DrawingFile, description="Polylines on the scan")
@shared.doc(operation_id="getSharedDrawing", responses={401: "No link was opened", 410: "Expired or revoked"})
def show_drawing() -> Response:
    """The shared fit's drawing"""
    return _file("drawing.json")


@shared.get("/distances.bin")
@shared.doc(
    operation_id="getSharedDistances",
    responses={200: file_of(BINARY, "float32 for each vertex of the model, mm"), 410: "Expired or revoked"},
)
def show_distances() -> Response:
    """The distance of each model vertex to the scan"""
    return _file("distances.bin")


@shared.get("/report.pdf")
@shared.doc(
    operation_id="getSharedReport",
    responses={
        200: file_of(PDF, "Two pages: pictures, then numbers"),
        403: "The link does not show the scan, which the report pictures",
        410: "Expired or revoked",
    },
)
def show_report() -> Response:
    """The shared fit's report, when the link shows the scan"""
    share = visited_share()
    if share.scan == "none":
        raise refuse(403, "This link does not show the scan, and the report has pictures of it.")
    response = bytes_answer(behind().service.reports.pdf(share.fit, None), PDF, NO_STORE)
    response.headers["Content-Disposition"] = "attachment; filename=report.pdf"
    return response


@shared.get("/mesh.glb")
@shared.doc(
    operation_id="getSharedMesh",
    responses={200: file_of(GLB, "The scan, metres"), 403: "The link does not show it", 410: "Expired or revoked"},
)
def show_mesh() -> Response:
    """The scan, when the link shows it; without colours unless the owner chose `full`"""
    share = visited_share()
    if share.scan == "none":
        raise refuse(403, "This link does not show the scan.")
    storage = behind().service.storage
    mesh = mesh_file(storage, get_fit(storage, share.fit).scan)
    if share.scan == "full":
        return file_answer(mesh, GLB, NO_STORE)
    with mesh.open() as file:
        return bytes_answer(plain_mesh(file.read()), GLB, NO_STORE)


@share_page.get("/s")
def page() -> Response:
    """The read-only page; it holds nothing until its script has opened the link.

    Where the page is built it shows the body; else numbers and files, which need no script but a small one.
    """
    built = (behind().config.web or asset_folder("web")) / "index.html"
    html = built.read_text(encoding="utf-8") if built.is_file() else render_template("share.html")
    return Response(html, mimetype="text/html", headers={"Cache-Control": NO_STORE})


@share_page.get("/s/share.js")
def script() -> Response:
    return bytes_answer(render_template("share.js").encode(), "text/javascript", CHECK_AGAIN)


def _file(name: str) -> Response:
    share = visited_share()
    file = behind().service.storage.files.find(fit_place(share.fit), name)
    if file is None:
        raise NotFound(f"This result has no {name}.")
    return file_answer(file, MEDIA_TYPES[name], NO_STORE, download_as=name)


def _result(share: ShareRow) -> wire_shares.SharedResult:
    return wire_shares.SharedResult(
        expires_at=share.expires_at,
        links=wire_shares.SharedLinks(
            result="/api/shared/result.json",
            fitted_glb="/api/shared/fitted.glb",
            fitted_ply="/api/shared/fitted.ply",
            drawing="/api/shared/drawing.json",
            distances="/api/shared/distances.bin",
            report=None if share.scan == "none" else "/api/shared/report.pdf",
            mesh=None if share.scan == "none" else "/api/shared/mesh.glb",
        ),
    )

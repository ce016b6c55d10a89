"""The files of a fit: each alone, and all of them in one."""

import hashlib
import shutil
import tempfile
import zipfile
from contextlib import ExitStack
from typing import IO, Any

from apiflask import APIBlueprint
from flask import Response

from breastrig.api.answers import BINARY, GLB, ZIP, file_of, in_memory, media_type_of, opened
from breastrig.api.app_context import app_context, service, storage
from breastrig.api.routes.fits import FITS_TAG
from breastrig.api.wire import checks as wire
from breastrig.core.errors import Conflict, NotFound
from breastrig.drawings.drawing_schema import DrawingFile
from breastrig.files.result import FIT_FILES, ResultFile
from breastrig.service.kept_models import LONG_AGO
from breastrig.storage.documents.fits import StoredFit, get_fit
from breastrig.storage.files import OpenedFile, fit_place

results = APIBlueprint("results", __name__, url_prefix="/api/fits", tag=FITS_TAG)


@results.get("/<fit_id>/result.json")
@results.output(ResultFile, description="Numbers and parameters")
@results.doc(operation_id="getResult", responses={409: "Not done"})
def show_result(fit_id: str) -> Response:
    """result.json, as the command line writes it"""
    return _result_file(fit_id, "result.json")


@results.get("/<fit_id>/fitted.glb")
@results.doc(operation_id="getFittedGlb", responses={200: file_of(GLB, "The posed rig"), 409: "Not done"})
def show_fitted_glb(fit_id: str) -> Response:
    """The posed rig with the plan or the fit's own drawing, and replay, glTF"""
    return _result_file(fit_id, "fitted.glb")


@results.get("/<fit_id>/fitted.ply")
@results.doc(operation_id="getFittedPly", responses={200: file_of(BINARY, "The posed surface"), 409: "Not done"})
def show_fitted_ply(fit_id: str) -> Response:
    """The posed model in the scan's frame and unit, PLY"""
    return _result_file(fit_id, "fitted.ply")


@results.get("/<fit_id>/drawing.json")
@results.output(DrawingFile, description="Polylines on the scan")
@results.doc(operation_id="getDrawing", responses={409: "Not done"})
def show_drawing(fit_id: str) -> Response:
    """The drawing on the scan's surface, in the scan's frame and unit"""
    return _result_file(fit_id, "drawing.json")


@results.get("/<fit_id>/distances.bin")
@results.doc(
    operation_id="getDistances",
    responses={
        200: file_of(
            BINARY,
            "float32, little-endian, one number for each vertex of the model in its order: signed distance to the "
            "scan in millimetres, above zero where the model lies outside the skin, nan where no pair was accepted",
        ),
        404: "A fit of an older version has none",
        409: "Not done",
    },
)
def show_distances(fit_id: str) -> Response:
    """The distance of each model vertex to the scan, mm, to colour the model by

    The absolute values are those that `surface_distance_mm` of result.json summarises.
    """
    return _result_file(fit_id, "distances.bin")


@results.get("/<fit_id>/uncertainty.bin")
@results.doc(
    operation_id="getUncertainty",
    responses={
        200: file_of(
            BINARY,
            "float32, little-endian, one number for each vertex of the model in its order: the radius in millimetres "
            "that holds its true place with 90 %, nan where nothing is known",
        ),
        404: "A fit of an older version has none",
        409: "Not done",
    },
)
def show_uncertainty(fit_id: str) -> Response:
    """The 90 % radius of each model vertex, mm"""
    return _result_file(fit_id, "uncertainty.bin")


@results.get("/<fit_id>/checks")
@results.output(wire.LineChecks)
@results.doc(operation_id="getChecks", responses={409: "Not done"})
def show_checks(fit_id: str) -> dict[str, Any]:
    """The landmarks to check: those whose true place makes the lines surest

    At most three that the scan shows and nobody has placed, chosen one after another from the fit's posterior, for the
    patient's plan on this scan, else the fit's own drawing, else lines on the breasts. A landmark that was looked at is
    given to the next fit with a `confidence` of 1: otherwise one at its proposed place counts as only agreed to.
    """
    return service.line_checks.on_fit(_done(fit_id).id)


@results.get("/<fit_id>/result.zip")
@results.doc(operation_id="getResultZip", responses={200: file_of(ZIP, "The files, not compressed"), 409: "Not done"})
def show_result_zip(fit_id: str) -> Response:
    """All files of a fit in one, zip

    What `breastrig fit` writes into a folder, so that `breastrig report` and `transfer` can read it, and `plan.json`.
    Each file is as its own address answers it: `fitted.glb` shows the plan.
    """
    context, fit = app_context(), _done(fit_id)
    found = {name: _file(fit, name) for name in FIT_FILES}
    files = {name: file for name, file in found.items() if file is not None}
    files["plan.json"] = in_memory(service.plans.on_fit(fit_id))
    packed, size = _packed(files)
    etag = hashlib.sha256(repr([(name, file.etag) for name, file in files.items()]).encode()).hexdigest()[:32]
    whole = OpenedFile(None, size, etag, lambda: packed)
    response = context.patients_file([fit.scan], whole, ZIP, service.reports.file_name("result.zip", fit_id))
    response.call_on_close(packed.close)
    return response


def _packed(files: dict[str, OpenedFile]) -> tuple[IO[bytes], int]:
    """The files as one file without a name, which ends with this process, and its size; deterministic.

    Raises NotFound when one of them was deleted meanwhile.
    """
    with ExitStack() as stack:
        target = stack.enter_context(tempfile.TemporaryFile())
        archive = stack.enter_context(zipfile.ZipFile(target, "w"))
        for name, file in files.items():
            entry = zipfile.ZipInfo(name, LONG_AGO)
            entry.file_size = file.size
            with opened(file) as source, archive.open(entry, "w") as place:
                shutil.copyfileobj(source, place)
        archive.close()
        size = target.tell()
        target.seek(0)
        stack.pop_all()
        return target, size


def _result_file(fit_id: str, name: str) -> Response:
    context, fit = app_context(), _done(fit_id)
    file = _file(fit, name)
    if file is None:
        raise NotFound(f"This fit has no {name}.")
    download_as = service.reports.file_name(name, fit_id)
    return context.patients_file([fit.scan], file, media_type_of(name), download_as)


def _done(fit_id: str) -> StoredFit:
    """The finished fit. Raises NotFound, or Conflict when it has no results."""
    fit = get_fit(storage, fit_id)
    if fit.state != "done":
        raise Conflict(
            f"This fit has no results: it is {fit.state}."
            if fit.ended
            else f"This fit is still {fit.state}; its results come when it is done."
        )
    return fit


def _file(fit: StoredFit, name: str) -> OpenedFile | None:
    """One of the fit's files; the rig with the plan where there is one."""
    planned = service.plans.fitted_glb(fit.id) if name == "fitted.glb" else None
    return storage.files.find(fit_place(fit.id), name) if planned is None else in_memory(planned)

"""Transfers: a drawing made on one scan, shown on another.  Nothing is stored; the drawing is the answer."""

from apiflask import APIBlueprint

from breastrig.api.app_context import app_context
from breastrig.api.whose import check_whose
from breastrig.api.wire import transfers as wire_transfers
from breastrig.core.errors import Conflict
from breastrig.storage.documents.fits import get_fit
from breastrig.storage.documents.patients import patient_of_scan

transfers = APIBlueprint(
    "transfers",
    __name__,
    url_prefix="/api/transfers",
    tag={"name": "transfers", "description": "Show a drawing of one scan on another."},
)


@transfers.post("")
@transfers.input(wire_transfers.TransferRequest)
@transfers.output(wire_transfers.CarriedDrawing, status_code=201, description="The drawing on the target scan")
@transfers.doc(
    operation_id="transferDrawing",
    responses={404: "No such fit", 409: "A fit is not done, or drawing or bodies look like another patient's"},
)
def transfer_drawing(json_data: wire_transfers.TransferRequest) -> tuple[wire_transfers.CarriedDrawing, int]:
    """Show a drawing of one scan on another

    Both fits must be done.  Between two stances of one patient the skin is followed; with `other_patient` the same
    place of the model is shown.  Scans that do not look like one patient's are asked about.  Every point lies on the
    target's skin or is marked as bridged.
    """
    service = app_context().service
    for fit_id in (json_data.from_fit, json_data.to_fit):
        fit = get_fit(service.storage, fit_id)
        if fit.state != "done":
            raise Conflict(f"The fit {fit.id} is {fit.state}; a drawing can be carried between fits that are done.")
    drawing = json_data.drawing
    if drawing is not None:
        scans = [get_fit(service.storage, each).scan for each in (json_data.from_fit, json_data.to_fit)]
        patients = [patient_of_scan(service.storage, scan) for scan in scans]
        check_whose(drawing.model_dump(mode="json"), patients, json_data.same_patient)
    carried = service.transfer(
        json_data.from_fit,
        json_data.to_fit,
        None if drawing is None else drawing.model_dump(mode="json", by_alias=True, exclude_none=True),
        json_data.other_patient,
        json_data.same_patient,
    )
    return wire_transfers.CarriedDrawing.model_validate(carried), 201

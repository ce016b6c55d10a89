"""Transfers: a drawing made on one scan, shown on another.  Nothing is stored; the drawing is the answer."""

from collections.abc import Iterable

from apiflask import APIBlueprint

from breastrig.api.app_context import service, storage
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
    _check_done((json_data.from_fit, json_data.to_fit), "a drawing can be carried")
    drawing = json_data.drawing
    if drawing is not None:
        scans = [get_fit(storage, each).scan for each in (json_data.from_fit, json_data.to_fit)]
        patients = [patient_of_scan(storage, scan) for scan in scans]
        check_whose(drawing.model_dump(mode="json"), patients, json_data.same_patient)
    carried = service.transfer(
        json_data.from_fit,
        json_data.to_fit,
        None if drawing is None else drawing.model_dump(mode="json", by_alias=True, exclude_none=True),
        json_data.other_patient,
        json_data.same_patient,
    )
    return wire_transfers.CarriedDrawing.model_validate(carried), 201


@transfers.post("/marks")
@transfers.input(wire_transfers.MarksRequest)
@transfers.output(wire_transfers.ProposedMarks, description="The pairs, surest first; perhaps none")
@transfers.doc(
    operation_id="proposeMarks",
    responses={
        404: "No such fit",
        409: "A fit is not done, or the bodies look like another patient's",
        422: "A scan has no colours, or too coarse ones",
    },
)
def propose_marks(json_data: wire_transfers.MarksRequest) -> wire_transfers.ProposedMarks:
    """Pairs of dots, crosses and moles that the colours of two scans of one patient show

    They are for a person to accept: nothing follows them until they are among the marks of both scans
    (`PUT /api/scans/ID/landmarks`).  Some seconds.
    """
    _check_done((json_data.from_fit, json_data.to_fit), "marks can be proposed")
    found = service.propose_marks(json_data.from_fit, json_data.to_fit, json_data.same_patient)
    return wire_transfers.ProposedMarks.model_validate(found)


def _check_done(fits: Iterable[str], what: str) -> None:
    for fit_id in fits:
        fit = get_fit(storage, fit_id)
        if fit.state != "done":
            raise Conflict(f"The fit {fit.id} is {fit.state}; {what} between fits that are done.")

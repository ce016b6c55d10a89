"""The surgeon's own lines on one scan, as a drawing file: those items of the patient's plan that are lines on it."""

from apiflask import APIBlueprint

from breastrig.api.app_context import service, storage
from breastrig.api.place_checks import check_near_scan
from breastrig.api.routes.scans.scans import TAG
from breastrig.api.whose import check_whose
from breastrig.api.wire.patients import SamePatient
from breastrig.drawings.drawing_schema import OwnDrawing
from breastrig.drawings.plan_schema import line_item
from breastrig.storage.documents.patients import get_plan, patient_of_scan, put_items_of_scan
from breastrig.storage.documents.scans import get_scan

drawings = APIBlueprint("drawings", __name__, url_prefix="/api/scans", tag=TAG)


@drawings.get("/<scan_id>/drawing")
@drawings.output(OwnDrawing)
@drawings.doc(operation_id="getOwnDrawing")
def show_drawing(scan_id: str) -> OwnDrawing:
    """The lines drawn on the scan, mm

    No shapes when nothing was drawn yet.
    """
    return OwnDrawing.model_validate({"shapes": _lines_on(scan_id)})


@drawings.put("/<scan_id>/drawing")
@drawings.input(OwnDrawing)
@drawings.input(SamePatient, location="query")
@drawings.output(OwnDrawing)
@drawings.doc(operation_id="putOwnDrawing", responses={409: "Names another patient", 413: "Too large"})
def replace_drawing(scan_id: str, json_data: OwnDrawing, query_data: SamePatient) -> OwnDrawing:
    """Replace the lines on the scan, mm

    At most 500 shapes with 50,000 points together, each shape with a name of its own; new ones lie within 10 mm
    of the scan's skin, but for points over a hole (`bridged`).  They become items of the patient's plan, whose other
    items stay; a line that keeps its name keeps its id.
    """
    scan = get_scan(storage, scan_id)
    patient = patient_of_scan(storage, scan_id)
    check_whose(json_data.model_dump(mode="json"), [patient], query_data.same_patient)
    for shape in json_data.shapes:
        check_near_scan(shape.name, shape.points, scan)
    service.skin_checks.check(scan, [shape.model_dump(mode="json") for shape in json_data.shapes])
    ids = {line["name"]: line["id"] for line in _lines_on(scan_id)}
    items = [
        line_item(shape.model_dump(), ids.get(shape.name, f"line-{place}"), scan_id)
        for place, shape in enumerate(json_data.shapes, 1)
    ]
    kept = [item.model_dump(mode="json") for item in items]
    put_items_of_scan(storage, scan_id, "line", kept)
    return OwnDrawing.model_validate({"shapes": kept})


def _lines_on(scan_id: str) -> list[dict[str, str]]:
    plan = get_plan(storage, patient_of_scan(storage, scan_id))
    return [item for item in plan.items if item["kind"] == "line" and item.get("scan") == scan_id]

"""The surgeon's own drawing on a scan: kept with the scan, to be carried to another stance by a transfer."""

from apiflask import APIBlueprint

from breastrig.api.app_context import app_context
from breastrig.api.routes.scans import TAG
from breastrig.core.errors import BadDrawing
from breastrig.drawings.drawing_schema import OwnDrawing
from breastrig.storage.rows.drawings import get_drawing, put_drawing
from breastrig.storage.rows.scans import ScanRow, get_scan

REACH_M = 0.05  # beyond the scan's bounds: a line may cross a hole at the rim, further out it is of another scan

drawings = APIBlueprint("drawings", __name__, url_prefix="/api/scans", tag=TAG)


@drawings.get("/<scan_id>/drawing")
@drawings.output(OwnDrawing)
@drawings.doc(operation_id="getOwnDrawing")
def show_drawing(scan_id: str) -> OwnDrawing:
    """What was drawn on the scan, mm

    No shapes when nothing was drawn yet.
    """
    storage = app_context().service.storage
    get_scan(storage, scan_id)
    return OwnDrawing.model_validate(get_drawing(storage, scan_id) or {"shapes": []})


@drawings.put("/<scan_id>/drawing")
@drawings.input(OwnDrawing)
@drawings.output(OwnDrawing)
@drawings.doc(operation_id="putOwnDrawing", responses={413: "Too large"})
def replace_drawing(scan_id: str, json_data: OwnDrawing) -> OwnDrawing:
    """Replace the drawing on the scan, mm

    At most 500 shapes with 50,000 points together, each shape with a name of its own; points must lie near the scan.
    """
    storage = app_context().service.storage
    _check(json_data, get_scan(storage, scan_id))
    on_skin = [shape.model_copy(update={"bridged": None}) for shape in json_data.shapes]  # own lines are drawn there
    kept = json_data.model_copy(update={"shapes": on_skin})
    put_drawing(storage, scan_id, kept.model_dump(mode="json", by_alias=True))
    return kept


def _check(drawing: OwnDrawing, scan: ScanRow) -> None:
    """Raises BadDrawing with a sentence."""
    low, high = scan.facts["bounds_m"]["min"], scan.facts["bounds_m"]["max"]
    for shape in drawing.shapes:
        for point in shape.points:
            outside = max(max(a - x / 1000, x / 1000 - b) for x, a, b in zip(point, low, high, strict=True))
            if outside > REACH_M:
                raise BadDrawing(
                    f'A point of "{shape.name}" lies {outside:.2f} m outside of the scan; drawings are millimetres in '
                    f"the scan's own frame, and this scan was read in {scan.facts['unit']}."
                )

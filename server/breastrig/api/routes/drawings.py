"""The surgeon's own drawing on a scan: kept with the scan, to be carried to another stance by a transfer."""

from apiflask import APIBlueprint
from flask import request

from breastrig.api.app_context import app_context
from breastrig.api.routes.scans import TAG
from breastrig.api.wire import drawings as wire_drawings
from breastrig.core.errors import BadDrawing, TooLarge
from breastrig.storage.rows.drawings import get_drawing, put_drawing
from breastrig.storage.rows.scans import ScanRow, get_scan

REACH_M = 0.05  # beyond the scan's bounds: a line may cross a hole at the rim, further out it is of another scan

drawings = APIBlueprint("drawings", __name__, url_prefix="/api/scans", tag=TAG)


@drawings.before_request
def limit_body() -> None:
    request.max_content_length = wire_drawings.BYTES
    if (request.content_length or 0) > wire_drawings.BYTES:
        raise TooLarge(f"The drawing is larger than {wire_drawings.BYTES // 1000} kB; draw with fewer points.")


@drawings.get("/<scan_id>/drawing")
@drawings.output(wire_drawings.OwnDrawing)
@drawings.doc(operation_id="getOwnDrawing")
def show_drawing(scan_id: str) -> wire_drawings.OwnDrawing:
    """What was drawn on the scan, mm

    No shapes when nothing was drawn yet.
    """
    storage = app_context().service.storage
    get_scan(storage, scan_id)
    return wire_drawings.OwnDrawing.model_validate(get_drawing(storage, scan_id) or {"shapes": []})


@drawings.put("/<scan_id>/drawing")
@drawings.input(wire_drawings.OwnDrawing)
@drawings.output(wire_drawings.OwnDrawing)
@drawings.doc(operation_id="putOwnDrawing", responses={413: "Larger than 200 kB"})
def replace_drawing(scan_id: str, json_data: wire_drawings.OwnDrawing) -> wire_drawings.OwnDrawing:
    """Replace the drawing on the scan, mm

    At most 200 shapes with 20,000 points together, each shape with a name of its own; points must lie near the scan.
    """
    storage = app_context().service.storage
    _check(json_data, get_scan(storage, scan_id))
    put_drawing(storage, scan_id, json_data.model_dump(mode="json", by_alias=True))
    return json_data


def _check(drawing: wire_drawings.OwnDrawing, scan: ScanRow) -> None:
    """Raises BadDrawing with a sentence."""
    count = sum(len(shape.points) for shape in drawing.shapes)
    if count > wire_drawings.POINTS:
        raise BadDrawing(f"This drawing has {count} points; at most {wire_drawings.POINTS} are kept.")
    names = [shape.name for shape in drawing.shapes]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise BadDrawing(f'Two shapes of this drawing are called "{twice}"; give each a name of its own.')
    low, high = scan.facts["bounds_m"]["min"], scan.facts["bounds_m"]["max"]
    for shape in drawing.shapes:
        for point in shape.points:
            outside = max(max(a - x / 1000, x / 1000 - b) for x, a, b in zip(point, low, high, strict=True))
            if outside > REACH_M:
                raise BadDrawing(
                    f'A point of "{shape.name}" lies {outside:.2f} m outside of the scan; drawings are millimetres in '
                    f"the scan's own frame, and this scan was read in {scan.facts['unit']}."
                )

"""Patterns that follow a hand: asked for again and again while a handle is dragged, never stored."""

from apiflask import APIBlueprint

from breastrig.api.app_context import service, storage
from breastrig.api.place_checks import check_near_scan
from breastrig.api.routes.fits import FITS_TAG
from breastrig.api.wire import patterns as wire
from breastrig.drawings.patterns import pattern_of
from breastrig.storage.documents.fits import get_fit
from breastrig.storage.documents.scans import get_scan
from breastrig.use.moving.live_pattern import LengthsQuestion, LiveQuestion

patterns = APIBlueprint("patterns", __name__, url_prefix="/api/fits", tag=FITS_TAG)


@patterns.post("/<fit_id>/pattern")
@patterns.input(wire.PatternQuestion)
@patterns.output(wire.PatternOnScan, description="The pattern on the fit's scan")
@patterns.doc(operation_id="drawPattern", responses={409: "Not done", 429: "Asked for by too many at once"})
def draw_pattern(fit_id: str, json_data: wire.PatternQuestion) -> wire.PatternOnScan:
    """Draw a pattern on the fit's scan, as it is or as a dragged handle makes it

    Nothing is stored: to keep it, write its parameters into the plan.  The first answer takes a second, the next ones
    a tenth of it.  A handle stands for one parameter (a tumour's centre for hour and distance); where that ends, the
    drag ends, and `limit` says so.
    """
    fit = get_fit(storage, fit_id)
    pattern_of(json_data.name, json_data.parameters)
    drag = json_data.drag
    if drag is not None:
        check_near_scan(drag.handle, [drag.to], get_scan(storage, fit.scan))
    x, y, z = (0.0, 0.0, 0.0) if drag is None else drag.to
    question = LiveQuestion(
        json_data.name, json_data.parameters, json_data.side, None if drag is None else drag.handle, (x, y, z)
    )
    return wire.PatternOnScan.model_validate(service.moving.pattern(fit_id, question))


@patterns.post("/<fit_id>/lengths")
@patterns.input(wire.LengthsQuestion)
@patterns.output(wire.Lengths)
@patterns.doc(operation_id="measureLengths", responses={409: "Not done", 429: "Asked for by too many at once"})
def measure_lengths(fit_id: str, json_data: wire.LengthsQuestion) -> wire.Lengths:
    """Lengths along the skin, from place to place

    On the fitted skin and by the shortest path, as measures and tape sheet have them.  Nothing is stored.
    """
    fit = get_fit(storage, fit_id)
    check_near_scan("tape", json_data.places, get_scan(storage, fit.scan))
    x_y_z = ((float(x), float(y), float(z)) for x, y, z in json_data.places)
    return wire.Lengths.model_validate(service.moving.pattern(fit_id, LengthsQuestion(tuple(x_y_z))))

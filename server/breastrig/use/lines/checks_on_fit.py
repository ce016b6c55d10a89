"""Which landmarks to check for the plan on a fit's scan: from a folder and a document to a document."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from breastrig.core.arrays import Array
from breastrig.core.errors import BadInput
from breastrig.drawings.drawing_file import drawing_document, lines_on_scan, planned_on_scan
from breastrig.drawings.line_error import fingers
from breastrig.files.result import DRAWING
from breastrig.geometry.polyline import Polyline
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.hand_cuts import are_cut
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of
from breastrig.use.lines.line_checks import LineChecks, line_checks
from breastrig.use.lines.plan_on_fit import PlanLines


@dataclass(frozen=True)
class ChecksJob:
    """A fit whose landmarks may be checked."""

    fit: Path  # folder of a fit
    plan: PlanLines | None = None  # its lines, and whether they are all that is wanted; None: the fit's own drawing
    model: Path | None = None  # None: the torso of the package
    cuts: tuple[dict[str, Any], ...] = ()  # by hand, see scan/hand_cuts.py: what is not shown any more


def checks_on_fit(job: ChecksJob) -> dict[str, Any]:
    """The answer of api/wire/checks.py, places in mm.  Raises BadInput for what is no fit."""
    fit = _without_cuts(fit_folder_of(job.fit, read_rig(job.model or default_rig_path())), job.cuts)
    own: Sequence[Polyline] = ()
    with suppress(BadInput):
        own = lines_on_scan(drawing_document(job.fit / DRAWING), fit.unit)
    if job.plan is None:
        return _document(fit, line_checks(fit, own))
    document, is_whole = job.plan
    planned = planned_on_scan(document)
    carried = [bool(shape.get("carried")) for shape in document["shapes"] if shape["points"]]
    beside = () if is_whole else own
    found = line_checks(fit, (*planned, *beside), (*carried, *(False for _ in beside)))
    return _document(fit, replace(found, lines="plan") if planned and found.lines == "drawing" else found)


def _without_cuts(fit: FitFolder, cuts: Sequence[Mapping[str, Any]]) -> FitFolder:
    """The fit without checks of landmarks that were cut away by hand, perhaps after it was made."""
    if fit.checks is None:
        return fit
    known = fit.checks.observable
    left = replace(known, open=known.open & ~are_cut(fit.checks.places.points, cuts))
    return replace(fit, checks=replace(fit.checks, observable=left))


def _document(fit: FitFolder, found: LineChecks) -> dict[str, Any]:
    def numbers(values: Array, digits: int) -> list[float]:
        return [round(float(value), digits) for value in values]

    checks = [
        {name: value for name, value in asdict(each).items() if name not in ("face", "barycentric")}
        | {
            "place": numbers(1e3 * fit.metres_per_unit * each.place, 3),
            "normal": numbers(each.normal, 6),
            "point": {"face": each.face, "barycentric": numbers(each.barycentric, 9)},
            "fingers": fingers(1e-3 * each.line_error_mm),
        }
        for each in found.checks
    ]
    now, expected = found.line_error_mm, found.expected_line_error_mm
    return {
        "lines": found.lines,
        "line_error_mm": now,
        "fingers": None if now is None else fingers(1e-3 * now),
        "expected_line_error_mm": expected,
        "expected_fingers": None if expected is None else fingers(1e-3 * expected),
        "worth_it": found.worth_it,
        "checks": checks,
        "reason": found.reason,
    }

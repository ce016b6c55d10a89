"""Which landmarks of a fit a person should check, for the lines that lie on its scan."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from breastrig.core.arrays import Array, frozen
from breastrig.core.stances import split_side
from breastrig.drawings.drawing_file import rounded_mm
from breastrig.drawings.line_error import drawn_error, with_errors
from breastrig.drawings.skin_maps.scan_errors import radii_at
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.fitting.checks.basis import CheckBasis, on_vertices
from breastrig.fitting.checks.choose import Check, ModelLine, asked_checks, next_checks
from breastrig.fitting.uncertainty.radii import line_error, planned_on
from breastrig.geometry.polyline import Polyline
from breastrig.rig.known import NOT_CALIBRATED
from breastrig.rig.state import BodyState
from breastrig.use.folder.fit_folder import FitFolder

PREDICTED = "No scan shows this predicted body; check landmarks on the scan that it was predicted from."
UNUSABLE = "This fit cannot be used: {}"
UNKNOWN = f"{NOT_CALIBRATED}: how much a check would bring is not known."
EARLIER = "An earlier version made this fit; fit the scan again to see which landmarks to check."
NONE_LEFT = "Every landmark that this scan shows has been placed."
NO_GAIN = "No landmark that is left would make the lines noticeably surer."

Lines = Literal["plan", "drawing", "breasts"]


@dataclass(frozen=True, eq=False, repr=False)
class LandmarkCheck:
    """A landmark to look at, in the scan's unit and frame."""

    name: str
    label: str
    side: str | None  # L, R; None on the midline
    place: Array  # (3,) on the scan's skin, where it is expected
    normal: Array  # (3,) unit, out of the skin there
    radius_mm: float  # holds its true place with 90 %
    face: int  # of the model, where its landmark lies
    barycentric: Array  # (3,) there
    line_error_mm: float  # of the lines, expected after this check and those before

    def __repr__(self) -> str:
        return f"<LandmarkCheck {self.label}: then lines ± {self.line_error_mm:.1f} mm>"


@dataclass(frozen=True, eq=False)
class LineChecks:
    """How sure lines on a scan are, and the landmarks whose check makes them surer."""

    lines: Lines  # whose error it is: of the plan, of the fit's own drawing, or of any on the breasts
    line_error_mm: float | None  # 90 %, across, the largest of the lines; None: not known
    checks: tuple[LandmarkCheck, ...] = ()  # in the order in which to look at them
    worth_it: bool = False  # they make the lines surer by at least one finger (20 mm across)
    reason: str | None = None  # why there are no checks, a sentence

    @property
    def expected_line_error_mm(self) -> float | None:
        """The lines' error that is expected after all checks; None without any."""
        return self.checks[-1].line_error_mm if self.checks else None


def line_checks(fit: FitFolder, lines: Sequence[Polyline] = (), carried: Sequence[bool] | None = None) -> LineChecks:
    """The checks for lines on the fit's scan, some of which were `carried` there from another one.

    Without any whose errors are known, for lines on its breasts. Lines that were made on it have the fit's errors.
    """
    carried = carried or [False] * len(lines)
    lines = [
        with_errors(fit.rig, fit.fitted_scan.search(fit.rig), fit.radii, [line])[0]
        if line.error is None and not is_carried
        else line
        for line, is_carried in zip(lines, carried, strict=True)
    ]
    drawn, basis, result = drawn_error(lines), fit.checks, fit.result
    of: Lines = "breasts" if drawn is None else "drawing"
    known = result.line_error_mm if drawn is None else rounded_mm(drawn)
    if result.predicted:
        return LineChecks(of, known, reason=PREDICTED)
    if result.verdict is not None and result.verdict.level == "unusable":
        return LineChecks(of, known, reason=UNUSABLE.format(" ".join(result.verdict.reasons[:1])))
    if fit.radii is None:
        return LineChecks(of, known, reason=UNKNOWN)
    if basis is None:
        return LineChecks(of, known, reason=EARLIER)
    if not basis.observable.open.any():
        return LineChecks(of, known, reason=NONE_LEFT)
    where = _on_model(fit, fit.radii, lines, carried) or [on_vertices(part) for part in planned_on(fit.rig, basis.seen)]
    vertices, widths = basis.widths(where)
    now = line_error(fit.rig, fit.radii, basis.seen) if drawn is None else drawn
    before = basis.gaussian(BodyState(fit.rig, fit.parameters), vertices)
    found = asked_checks(now, next_checks(before, basis.observable, widths))
    asked = tuple(_landmark(fit, basis, check) for check in found.asked)
    return LineChecks(of, known, asked, found.worth_it, None if asked else NO_GAIN)


def _on_model(fit: FitFolder, radii: Array, lines: Sequence[Polyline], carried: Sequence[bool]) -> list[ModelLine]:
    """The places of lines whose errors are known; `radii`: (V,) m of the model's vertices.

    No check narrows what errors have beyond the model's, from the scan that a line was transferred from.
    """
    search, share, found = fit.fitted_scan.search(fit.rig), skin_map_settings(fit.rig).error_share, []
    for line, is_carried in zip(lines, carried, strict=True):
        if line.error is None or not np.isfinite(line.error).any():
            continue
        is_known = np.isfinite(line.error)
        points, error = line.points[is_known], line.error[is_known]
        nearest = search.query(points)
        times = share if is_carried and share is not None else 1.0
        beyond = np.maximum(error**2 - (times * radii_at(fit.rig, search, radii, points)) ** 2, 0.0)
        found.append(ModelLine(fit.rig.faces[nearest.faces], nearest.barycentric, times, beyond))
    return found


def _landmark(fit: FitFolder, basis: CheckBasis, check: Check) -> LandmarkCheck:
    landmark, places = fit.rig.landmarks[check.index], basis.places
    return LandmarkCheck(
        name=landmark.name,
        label=landmark.label,
        side=split_side(landmark.name)[1] or None,
        place=frozen(places.points[check.index] / fit.metres_per_unit),
        normal=frozen(places.normals[check.index]),
        radius_mm=round(1e3 * float(places.radii[check.index]), 1),
        face=landmark.face,
        barycentric=landmark.barycentric,
        line_error_mm=round(1e3 * check.width, 1),
    )

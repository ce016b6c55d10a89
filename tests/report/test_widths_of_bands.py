"""What bands are made of: squares of both ends' errors, each measure by its own places, the outline by its mean."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from breastrig.geometry.polyline import resampled
from breastrig.report.bands import OF_RATIO, Points, half_width, ratio_half_width
from breastrig.report.body_frame import body_frame
from breastrig.report.calibration import Spread, measure_calibration
from breastrig.report.measures import measures
from breastrig.report.stance import Stance
from breastrig.report.table import Row
from breastrig.report.volume import SPACING, breast_outline, breast_volume, vertices_within
from breastrig.rig.model import Rig


def stance(rig: Rig, **changes: Any) -> Stance:
    """Her left breast is larger; what is known of her grows upwards."""
    vertices = rig.template.copy()
    left = rig.regions["breast_L"]
    vertices[left] += np.array([0.012, -0.015, 0.01]) * np.hanning(len(left))[:, None]
    radii = 0.004 + 0.01 * (rig.template[:, 1] - rig.template[:, 1].min())
    names = dict.fromkeys(rig.landmark_names, 0.006)
    found = Stance(rig, vertices, vertices, rig.faces, "standing", landmark_radii=names, radii=radii)
    return replace(found, **changes)


def ratios(found: Stance) -> dict[str, Row]:
    return {row.measure: row for row in measures(found) if row.kind == "ratio"}


def margin(row: Row) -> float:
    """Downwards, where no ratio's end is in the way."""
    return row.value.value - row.value.low


def test_an_end_that_is_not_known_makes_no_band() -> None:
    assert half_width([0.003, 0.004]) == pytest.approx(0.005)
    assert half_width([0.003, None]) is None
    assert half_width([]) is None


@pytest.mark.parametrize("correlation", [0.0, 0.6, 1.0])
def test_nine_of_ten_ratios_are_held(correlation: float) -> None:
    """Of two lengths whose ends are wrong by Gaussians, more or less alike."""
    rng, (one, other), halves = np.random.default_rng(1), (80.0, 100.0), (4.0, 6.0)
    spread = np.outer(halves, halves) * np.array([[1.0, correlation], [correlation, 1.0]]) / 1.645**2
    a, b = rng.multivariate_normal([one, other], spread, 100_000).T
    found = ratio_half_width((one, other), ((), ()), Points(halves, correlation), None, 1.0)
    assert np.mean(np.abs(a / b - one / other) <= found) == pytest.approx(0.9, abs=0.01)
    turned = ratio_half_width((other, one), ((), ()), Points(halves[::-1], correlation), None, 1.0)
    assert turned == pytest.approx(found)
    assert ratio_half_width((one, other), ((), ()), Points((4.0, None)), None) is None


def test_each_ratio_is_as_wide_as_its_own_places_say(rig: Rig) -> None:
    found, known = stance(rig), measure_calibration(rig)
    assert known is not None
    shown, frame = ratios(found), body_frame(rig, found.vertices)
    names = ("nipple_L", "nipple_R")
    nipples = rig.landmark_points(names).positions(found.vertices, rig.faces)
    notch = rig.landmark_points(("suprasternal_notch",)).positions(found.vertices, rig.faces)[0]
    skin = [found.vertices[vertices_within(rig, side)] for side in "LR"]
    low = [part[frame.height(part).argmin()] for part in skin]
    far = [part[np.abs(frame.lateral(part)).argmax()] for part in skin]
    at_low, at_far = (
        [error.of(found.radius_at(point[None]) or 0.0) for point in ends]
        for error, ends in ((known.ends.lowest, low), (known.ends.lateral, far))
    )
    apart = float(np.abs(np.diff(frame.lateral(nipples)))[0])

    def ratio(lengths: list[float], halves: list[float], shared: float = 0.0) -> float:
        small, large = sorted(lengths)
        a, b = halves[0] / lengths[0], halves[1] / lengths[1]
        return small / large * float(np.sqrt(a * a + b * b - 2.0 * shared * a * b))

    def both(lengths: list[float], halves: list[float], shared: float) -> float:
        """A nipple's radius at the other end, which is shared with nothing."""
        return float(np.hypot(ratio(lengths, [0.006, 0.006]), ratio(lengths, halves, shared)))

    up, across = frame.height, lambda point: float(abs(frame.lateral(point)))
    pairs = list(zip(nipples, low, far, strict=True))
    drops = [float(up(notch) - up(v)) for _, v, _ in pairs]
    of_notch = min(drops) / max(drops) * (1.0 / min(drops) - 1.0 / max(drops))  # both sides have the same one
    wanted = {
        "M1": OF_RATIO * np.hypot(0.006, 0.006) / apart,
        "M2": both([float(up(n) - up(v)) for n, v, _ in pairs], at_low, known.sides.lowest),
        "M3": ratio([across(n) for n, _, _ in pairs], [OF_RATIO * 0.006] * 2),
        "M4": both([across(e) - across(n) for n, _, e in pairs], at_far, known.sides.lateral),
        "M5": float(np.hypot(ratio(drops, at_low, known.sides.lowest), OF_RATIO * 0.006 * of_notch)),
        "M6": ratio([across(e) for _, _, e in pairs], at_far, known.sides.lateral),
    }
    for name, half in wanted.items():
        row = shown.get(name)
        if row is not None and row.value is not None and row.value.low:
            assert margin(row) == pytest.approx(half, rel=1e-6), name
    assert {name for name in wanted if name in shown and shown[name].value is not None} >= {"M1", "M3", "M5", "M6"}


def test_nipples_that_rise_together_keep_their_difference_in_height(rig: Rig) -> None:
    names, size = tuple(rig.landmark_names), 3 * len(rig.landmark_names)
    together, alone = np.zeros((size, size)), np.zeros((size, size))
    for one in range(1, size, 3):
        alone[one, one] = together[one, one] = 0.01**2
        together[one, 1::3] = 0.01**2
    shared, own = (ratios(stance(rig, joint=(names, each)))["M1"] for each in (together, alone))
    frame = body_frame(rig, stance(rig).vertices)
    assert margin(shared) < 0.05 * margin(own)  # her axes are not quite the scan's
    nipples = rig.landmark_points(("nipple_L", "nipple_R")).positions(stance(rig).vertices, rig.faces)
    apart = float(np.abs(np.diff(frame.lateral(nipples)))[0])
    known = measure_calibration(rig)
    share = known.sides.apart["standing"]
    assert margin(own) == pytest.approx(share * 1.645 * 0.01 * np.sqrt(2.0) * frame.axes[1, 1] / apart, rel=1e-3)


def test_the_least_sure_of_several_places_counts(rig: Rig) -> None:
    found = stance(rig)
    places = found.vertices[[100, 900, 2000]]
    each = [found.radius_at(place[None]) for place in places]
    assert found.radius_at(places) == max(each)
    assert replace(found, radii=None).radius_at(places) is None


def test_an_error_grows_with_the_radius_from_its_least_on_and_lying_breasts_have_their_own(rig: Rig) -> None:
    spread = Spread(least=0.003, share=0.5)
    assert [spread.of(radius) for radius in (0.0, 0.008)] == pytest.approx([0.003, 0.005])
    known = measure_calibration(rig)
    assert known.outline("supine") == known.supine != known.standing
    assert known.outline("standing") == known.outline("prone") == known.standing


def test_a_volume_is_off_by_its_outline_and_by_the_skin_between(rig: Rig) -> None:
    """The outline's error is that of the mean radius along it; skin off by 2 mm is off by that over the whole area."""
    found = stance(rig)
    whole = breast_volume(found, "L")
    off = found.vertices + 0.002 * np.array([0.0, 0.0, 1.0])
    gap = breast_volume(replace(found, scan_vertices=off), "L")
    assert gap.value == pytest.approx(whole.value)
    inside = vertices_within(rig, "L")
    hidden = gap.area * abs(float(np.nanmean(replace(found, scan_vertices=off).distances[inside])))
    for ends in (("low", -1.0), ("high", 1.0)):
        name, sign = ends
        wide, narrow = sign * (getattr(gap, name) - gap.value), sign * (getattr(whole, name) - whole.value)
        assert wide == pytest.approx(np.hypot(narrow, hidden), rel=1e-3)
    assert found.radii is not None
    uneven = np.random.default_rng(1).uniform(0.002, 0.018, len(found.radii))
    near = breast_volume(replace(found, radii=uneven), "L")
    outline = breast_outline(rig, "L")
    line = resampled(outline.points.positions(found.vertices, rig.faces), SPACING, closed=True)
    mean = float(found.on_model(line).positions(uneven[:, None], rig.faces).mean())
    even = breast_volume(replace(found, radii=np.full(len(uneven), mean)), "L")
    most = breast_volume(replace(found, radii=np.full(len(uneven), 0.018)), "L")
    assert near.high == pytest.approx(even.high, rel=1e-6)
    assert most.high - most.value > 1.3 * (near.high - near.value)

"""The radii at the points of a line: from the fitted model under it, or from both fits between which it was carried."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.drawing_file import shape_document
from breastrig.drawings.line_error import across, carried_errors, drawn_error, with_errors
from breastrig.drawings.plan_on_scan import PlannedScan, plan_on_scan
from breastrig.drawings.plan_schema import PlanLine, PlanTumour
from breastrig.drawings.skin_maps.scan_errors import radii_at
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.drawings.transfer import transferred
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.polyline import Polyline
from breastrig.rig.model import Rig
from breastrig.volume.predicted import predicted


@pytest.fixture(scope="module")
def fitted(torso: Rig) -> ClosestPointSearch:
    return ClosestPointSearch(torso.template, torso.faces)


def test_a_point_over_a_vertex_has_its_radius(torso: Rig, fitted: ClosestPointSearch) -> None:
    radii = np.random.default_rng(1).uniform(0.002, 0.02, len(torso.template))
    chosen = np.arange(0, len(radii), 50)
    np.testing.assert_allclose(radii_at(torso, fitted, radii, torso.template[chosen]), radii[chosen], atol=1e-9)


def test_lines_without_known_radii_stay_as_they_are(torso: Rig, fitted: ClosestPointSearch) -> None:
    line = Polyline("a", False, "#101010", torso.template[:4], np.zeros(4, dtype=bool))
    assert with_errors(torso, fitted, None, [line]) == (line,)
    (known,) = with_errors(torso, fitted, np.full(len(torso.template), 0.004), [line])
    assert known.error == pytest.approx(np.full(4, 0.004))


def test_a_carried_point_adds_what_both_fits_and_the_skin_are_off(torso: Rig) -> None:
    settings = skin_map_settings(torso)
    target = ScanTarget(torso.template, torso.faces)
    a = FittedScan(target, torso.template, {}, "standing", np.full(len(torso.template), 0.01))
    b = replace(a, radii=np.full(len(torso.template), 0.02))
    points = torso.template[::100]
    errors = carried_errors(torso, a, b, points, points)
    expected = np.sqrt(settings.error_skin**2 + settings.error_share**2 * (0.01**2 + 0.02**2))
    assert errors is not None
    assert errors == pytest.approx(np.full(len(points), expected))
    assert carried_errors(torso, replace(a, radii=None), b, points, points) is None
    assert carried_errors(replace(torso, known={}), a, b, points, points) is None


def test_each_end_of_the_way_has_its_own_radius_and_a_predicted_one_counts_in_full(torso: Rig) -> None:
    """Radii that grow to her left on A and upwards on B, and points that lie elsewhere on B."""
    settings = skin_map_settings(torso)
    assert settings.error_share < 1.0
    target, share = ScanTarget(torso.template, torso.faces), settings.error_share
    of_a, of_b = 0.02 + 0.05 * torso.template[:, 0], 0.02 + 0.02 * torso.template[:, 1]
    a = FittedScan(target, torso.template, {}, "standing", of_a)
    b = FittedScan(target, torso.template, {}, "supine", of_b)
    on_a, on_b = np.arange(0, 2000, 50), np.arange(10, 2010, 50)
    for from_a, to_b, (first, second) in (
        (a, b, (share, share)),
        (a, replace(b, predicted=True), (share, 1.0)),
        (replace(a, predicted=True), b, (1.0, share)),
    ):
        errors = carried_errors(torso, from_a, to_b, torso.template[on_a], torso.template[on_b])
        wanted = np.sqrt(settings.error_skin**2 + (first * of_a[on_a]) ** 2 + (second * of_b[on_b]) ** 2)
        assert errors == pytest.approx(wanted, rel=1e-6)


def test_lines_between_a_hanging_and_another_breast_are_less_sure(torso: Rig) -> None:
    """Of points carried to and from prone scans of 26 known bodies 75 % are held without it, 89 % with it."""
    settings = skin_map_settings(torso)
    target, points = ScanTarget(torso.template, torso.faces), torso.template[::100]
    stances = {
        name: FittedScan(target, torso.template, {}, name, np.full(len(torso.template), 0.01))
        for name in ("standing", "supine", "prone")
    }

    def error(a: FittedScan, b: FittedScan) -> float:
        found = carried_errors(torso, a, b, points, points)
        return float(found[0])

    usual = error(stances["standing"], stances["supine"])
    assert error(stances["prone"], stances["prone"]) == pytest.approx(usual)
    for a, b in (("prone", "standing"), ("supine", "prone")):
        assert error(stances[a], stances[b]) == pytest.approx(np.hypot(usual, settings.error_hanging))
    assert 0.01 < settings.error_hanging < 0.02
    inside = carried_errors(torso, stances["prone"], stances["supine"], points, points, on_skin=False)
    assert inside == pytest.approx(np.full(len(points), usual))


@pytest.mark.parametrize(("stance", "goal"), [("standing", "supine"), ("standing", "prone"), ("prone", "supine")])
def test_a_prediction_is_said_to_be_less_sure_than_a_scan_wherever_it_is_off_farther(
    stance: str, goal: str, torso: Rig
) -> None:
    """Lines of one fit, carried to a scan of the other stance or predicted there: known bodies are twice as far off."""
    radii = np.full(len(torso.template), 0.01)
    a = FittedScan(ScanTarget(torso.template, torso.faces), torso.template, {}, stance, radii)
    breast = torso.regions["breast_L"]
    points = torso.template[breast]
    scanned = carried_errors(torso, a, replace(a, stance=goal), points, points)
    found = predicted(torso, torso.template, stance, goal)
    assert scanned is not None
    assert across(np.hypot(found.radii, radii)[breast]) > 1.1 * across(scanned)


def test_what_is_drawn_is_as_sure_as_the_line_of_which_least_is_known() -> None:
    line = Polyline(
        "a", False, "#101010", np.zeros((3, 3)), np.zeros(3, dtype=bool), error=np.array([3.0, np.nan, 4.0])
    )
    surer, unknown = replace(line, error=np.full(3, 2.0)), replace(line, error=None)
    assert drawn_error([surer, line, unknown]) == pytest.approx(0.71 * np.sqrt(12.5))
    assert drawn_error([unknown, replace(line, error=np.full(3, np.nan))]) is None
    assert shape_document(replace(line, error=1e-3 * np.array([3.0, np.nan, 4.0])), 1.0)["line_error_mm"] == 2.5
    assert "line_error_mm" not in shape_document(unknown, 1.0)


def test_each_line_has_the_radii_under_it(torso: Rig, fitted: ClosestPointSearch) -> None:
    radii = np.random.default_rng(2).uniform(0.002, 0.02, len(torso.template))
    parts = (np.arange(0, 40), np.arange(900, 907))
    lines = [
        Polyline(str(k), False, "#101010", torso.template[part], np.zeros(len(part), dtype=bool))
        for k, part in enumerate(parts)
    ]
    for line, part in zip(with_errors(torso, fitted, radii, lines), parts, strict=True):
        assert line.error == pytest.approx(radii[part], abs=1e-9)


def test_a_line_is_carried_with_the_radii_of_both_its_ends(torso: Rig) -> None:
    """B stands 0.5 m beside A: each fit is asked where it is."""
    settings, beside = skin_map_settings(torso), np.array([0.5, 0.0, 0.0])
    assert settings.error_share is not None
    assert settings.error_skin is not None
    of_a, of_b = 0.02 + 0.05 * torso.template[:, 0], 0.02 + 0.02 * torso.template[:, 1]
    places = dict(
        zip(torso.landmark_names, torso.landmark_points().positions(torso.template, torso.faces), strict=True)
    )
    moved = {name: place + beside for name, place in places.items()}
    a = FittedScan(ScanTarget(torso.template, torso.faces), torso.template, places, "standing", of_a)
    b = FittedScan(ScanTarget(torso.template + beside, torso.faces), torso.template + beside, moved, "standing", of_b)
    some = torso.regions["chest"][:12]
    line = Polyline("a", False, "#101010", torso.template[some], np.zeros(len(some), dtype=bool))
    (found,) = transferred(torso, a, b, [line], other_patient=True)
    wanted = carried_errors(torso, a, b, found.line.points - beside, found.line.points)
    assert found.line.points[:1] == pytest.approx(torso.template[some[:1]] + beside, abs=2e-3)
    assert found.line.error == pytest.approx(wanted, rel=0.02)


def test_a_plans_own_lines_keep_their_errors_and_patterns_have_the_fits(torso: Rig) -> None:
    places = dict(
        zip(torso.landmark_names, torso.landmark_points().positions(torso.template, torso.faces), strict=True)
    )
    radii = np.random.default_rng(3).uniform(0.004, 0.02, len(torso.template))
    scan = FittedScan(ScanTarget(torso.template, torso.faces), torso.template, places, "standing", radii)
    line = PlanLine(id="l", name="l", points=(1e3 * torso.template[:2]).tolist(), error_mm=[2.5, None])
    hour = {"kind": "tumour", "id": "t", "side": "L", "clock": 10.0, "distance_mm": 30.0, "radius_mm": 10.0}
    items = [line, PlanTumour.model_validate(hour)]
    own, circle = (each.line for each in plan_on_scan(torso, PlannedScan("standing", scan, items), []).lines)
    np.testing.assert_allclose(own.error, [0.0025, np.nan])
    assert circle.error == pytest.approx(radii_at(torso, scan.search(torso), radii, circle.points))

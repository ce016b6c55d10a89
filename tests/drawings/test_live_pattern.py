"""Patterns that follow a hand: the same lines as for a fit, handles that mean one parameter, and where drags end."""

from pathlib import Path

import numpy as np
import pytest
from helpers.example_fits import write_example_fits

from breastrig.core.errors import BadDrawing
from breastrig.core.stances import OUTWARDS
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.clock import FittedSkin, angle_of, clock_place, on_clock
from breastrig.drawings.handles.handle import nearest_on_way
from breastrig.drawings.handles.live_pattern import Drag, HandleOnScan, LivePattern, LiveSkin, Parameters
from breastrig.drawings.line_error import with_errors
from breastrig.drawings.patterns import asked_drawing
from breastrig.drawings.project_drawing import on_scan
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.geometry.polyline import Polyline
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import shaped
from breastrig.use.folder.fit_folder import fit_folder_of

pytestmark = pytest.mark.long

TUMOUR: Parameters = {"side": "L", "clock": 10.0, "distance_mm": 45.0, "radius_mm": 12.0}
PATTERNS: dict[str, Parameters] = {
    "reduction": {"limb_mm": 30.0, "areola_mm": 36.0},  # which leaves room to drag on this breast
    "vertical": {},
    "periareolar": {},
    "ellipse": {},
    "tumour": TUMOUR,
}
HANDLES = {
    "reduction": {"new_nipple", "areola", "limb_first", "limb_second", "angle_first", "angle_second"}
    | {"opening_first", "opening_second", "fold"},
    "vertical": {"new_nipple", "areola", "end", "width_first", "width_second"},
    "periareolar": {"areola", "outer", "outer_below", "lift"},
    "ellipse": {"length_lateral", "length_medial", "width_upper", "width_lower", "axis"},
    "tumour": {"centre", "radius"},
}


@pytest.fixture(scope="module")
def scans(rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> dict[str, FittedScan]:
    folder = tmp_path_factory.mktemp("fits")
    write_example_fits(folder)
    found = {}
    for stance in ("standing", "supine"):
        fit = fit_folder_of(Path(folder / stance), rig)
        found[stance] = fit.fitted_scan
    return found


@pytest.fixture(scope="module")
def live(rig: Rig, scans: dict[str, FittedScan]) -> LiveSkin:
    """Asked by all tests, so that whatever it remembers of one is there in the next."""
    return LiveSkin(rig, scans["standing"])


def ordinary(rig: Rig, scan: FittedScan, name: str, parameters: Parameters) -> dict[str, Polyline]:
    """As a plan or a fit draws it, on a skin that nobody has measured before."""
    text = f"{name}:{','.join(f'{key}={value}' for key, value in parameters.items())}" if parameters else name
    drawing = asked_drawing(rig, text).on_model(rig, scan.vertices, scan.known)
    found = on_scan(rig, scan.vertices, drawing, scan.target)
    return {line.name: line for line in with_errors(rig, scan.search(rig), scan.radii, found)}


def assert_same(found: LivePattern, expected: dict[str, Polyline]) -> None:
    for line, label in found.lines:
        other = expected[line.name]
        assert label
        assert line.points == pytest.approx(other.points, abs=1e-12)  # m: 1e-9 mm
        assert line.bridged.tolist() == other.bridged.tolist()
        assert line.corners == other.corners
        assert line.error == pytest.approx(other.error, abs=1e-9)


def handle(found: LivePattern, name: str) -> HandleOnScan:
    return next(each for each in found.handles if each.handle.name == name)


@pytest.mark.parametrize(("name", "stance"), [("vertical", "standing"), ("tumour", "supine")])
def test_the_lines_are_those_of_a_plan_to_a_billionth_of_a_millimetre_also_after_others_were_drawn(
    rig: Rig, scans: dict[str, FittedScan], name: str, stance: str
) -> None:
    skin, parameters = LiveSkin(rig, scans[stance]), PATTERNS[name]
    expected = ordinary(rig, scans[stance], name, parameters)
    first = skin.drawn(name, parameters)
    assert {line.name for line, _ in first.lines} == {*expected}
    assert_same(first, expected)
    for each in first.handles[:3]:
        skin.drawn(name, parameters, drag=Drag(each.handle.name, tuple(each.at + 0.004 * each.handle.grows)))
    assert_same(skin.drawn(name, parameters), expected)
    one = skin.drawn(name, parameters, side="L")
    assert {line.name for line, _ in one.lines} == {each for each in expected if each.endswith("_L")}
    assert_same(one, expected)


@pytest.mark.parametrize("name", ["vertical", "tumour"])
def test_what_a_drag_draws_is_what_its_parameters_draw(
    rig: Rig, scans: dict[str, FittedScan], live: LiveSkin, name: str
) -> None:
    for each in live.drawn(name, PATTERNS[name], side="L").handles:
        to = each.at + 0.003 * (each.handle.grows if each.handle.grows.any() else np.array([0.0, 1.0, 0.0]))
        dragged = live.drawn(name, PATTERNS[name], drag=Drag(each.handle.name, tuple(to)))
        expected = ordinary(rig, scans["standing"], name, {**dragged.parameters, "side": "L"})
        assert {line.name for line, _ in dragged.lines} == {*expected}
        assert_same(dragged, expected)


@pytest.mark.parametrize("name", ["reduction", "periareolar", "tumour"])
def test_a_handle_stands_for_its_parameters_and_changes_no_other(live: LiveSkin, name: str) -> None:
    parameters = PATTERNS[name]
    found = live.drawn(name, parameters)
    sides = "L" if name == "tumour" else "LR"
    assert {each.handle.name for each in found.handles} == {f"{one}_{side}" for one in HANDLES[name] for side in sides}
    for each in found.handles:
        if each.handle.side == "R":
            continue
        still = live.drawn(name, parameters, drag=Drag(each.handle.name, tuple(each.at)))
        assert still.parameters.keys() - parameters.keys() <= each.handle.values.keys()
        for number in each.numbers:
            assert still.parameters.get(number.parameter, 0.0) == pytest.approx(
                number.value, abs=0.6 if number.unit == "mm" else 0.51
            )
        if not each.handle.grows.any():
            continue
        number = each.numbers[0]
        values = []
        for away in (-0.003, 0.003):
            to = tuple(each.at + away * each.handle.grows)
            dragged = live.drawn(name, parameters, drag=Drag(each.handle.name, to))
            others = {key: value for key, value in dragged.parameters.items() if key != number.parameter}
            assert others == {key: value for key, value in parameters.items() if key != number.parameter}
            values.append(dragged.parameters[number.parameter])
        assert values[0] < values[1], each.handle.name


def test_a_dragged_handle_comes_to_where_it_is_dragged(scans: dict[str, FittedScan], live: LiveSkin) -> None:
    search = scans["standing"].target.search
    for name, one, within_mm in (
        ("ellipse", "length_lateral_L", 1.0),
        ("periareolar", "outer_L", 1.0),
        ("tumour", "centre_L", 1.0),
        ("tumour", "radius_L", 1.0),
        ("periareolar", "lift_L", 1.0),
        ("reduction", "limb_first_L", 1.0),
        ("reduction", "fold_L", 2.0),  # the skin next to a place below a crease lies aside
    ):
        start = handle(live.drawn(name, PATTERNS[name]), one)
        way = start.handle.grows if start.handle.grows.any() else np.array([0.0, 1.0, 0.0])
        asked = search.query((start.at + 0.003 * way)[None]).points[0]
        found = handle(live.drawn(name, PATTERNS[name], drag=Drag(one, tuple(asked))), one)
        assert 1e3 * np.linalg.norm(found.at - asked) < within_mm, one
        assert np.linalg.norm(found.at - start.at) > 0.0015, one


def test_a_drag_ends_at_the_parameters_limit_and_says_so(live: LiveSkin) -> None:
    areola = handle(live.drawn("periareolar", {}), "areola_L")
    found = live.drawn("periareolar", {}, drag=Drag("areola_L", tuple(areola.at + 0.03 * areola.handle.grows)))
    assert found.parameters["areola_mm"] == 55.0
    assert found.limit == "New areola stops at 55 mm."


def test_a_drag_ends_where_the_pattern_no_longer_fits_and_says_why(live: LiveSkin) -> None:
    limb = handle(live.drawn("reduction", {"limb_mm": 30.0}), "limb_first_R")
    found = live.drawn(
        "reduction", {"limb_mm": 30.0}, drag=Drag("limb_first_R", tuple(limb.at + 0.02 * limb.handle.grows))
    )
    assert 30.0 < float(found.parameters["limb_mm"]) < 40.0
    assert "reach the fold" in found.limit
    assert found.lines


def test_the_new_nipple_goes_up_and_down_the_meridian_of_a_sagging_breast(rig: Rig) -> None:
    weights = rest_parameters(rig).weights.copy()
    for shape, weight in (("ptosis", 1.8), ("volume_large", 1.5), ("nipple_vertical", -1.4)):
        for side in ("_L", "_R"):
            weights[rig.shape_names.index(shape + side)] = weight
    body = 1.15 * shaped(rig, weights)
    skin = LiveSkin(rig, FittedScan(ScanTarget(body, rig.faces), body, {}, "standing"))
    for name in ("reduction", "vertical"):
        start = handle(skin.drawn(name, {}), "new_nipple_L")
        now = start.numbers[0].value  # the nipple itself: its height over the fold
        assert 20.0 < now < 30.0
        up = skin.drawn(name, {}, drag=Drag("new_nipple_L", tuple(start.at + 0.010 * start.handle.grows)))
        raised = float(up.parameters["nipple_above_fold_mm"])
        assert raised - now == pytest.approx(10.0, abs=4.0)  # the place lies off the skin, which is not upright
        assert handle(up, "new_nipple_L").numbers[0].value == pytest.approx(raised, abs=0.1)
        assert up.limit == ""
        at = handle(up, "new_nipple_L")
        down = skin.drawn(
            name, up.parameters, drag=Drag("new_nipple_L", tuple(at.at - 0.004 * at.handle.grows))
        ).parameters["nipple_above_fold_mm"]
        assert float(down) - raised == pytest.approx(-4.0, abs=2.0)


def test_the_new_nipple_leaves_the_meridian_when_it_is_pulled_aside_and_comes_back(
    scans: dict[str, FittedScan], live: LiveSkin
) -> None:
    name, side = "vertical", "R"
    search, parameters = scans["standing"].target.search, PATTERNS[name]
    start = handle(live.drawn(name, parameters, side), f"new_nipple_{side}")
    outward = FittedSkin(live._rig, scans["standing"].vertices).axes[:, 0] * OUTWARDS[side]
    for away_mm in (12.0, -12.0):
        asked = search.query((start.at + 1e-3 * away_mm * outward)[None]).points[0]
        found = live.drawn(name, parameters, drag=Drag(f"new_nipple_{side}", tuple(asked)))
        assert 0.4 < float(found.parameters["nipple_outward_mm"]) / away_mm < 1.1
        aside = handle(found, f"new_nipple_{side}")
        assert 1e3 * np.linalg.norm(aside.at - asked) < 2.0
        assert "beside the meridian" in aside.numbers[1].label
        back = live.drawn(name, found.parameters, drag=Drag(f"new_nipple_{side}", tuple(start.at)))
        assert abs(float(back.parameters["nipple_outward_mm"])) < 2.5
    below = search.query((start.at - 0.012 * outward - 0.008 * start.handle.grows)[None]).points[0]
    found = live.drawn(name, parameters, drag=Drag(f"new_nipple_{side}", tuple(below)))
    assert -14.0 < float(found.parameters["nipple_outward_mm"]) < -8.0
    trembling = search.query((start.at + 0.002 * outward)[None]).points[0]
    found = live.drawn(name, parameters, drag=Drag(f"new_nipple_{side}", tuple(trembling)))
    assert "nipple_outward_mm" not in found.parameters


@pytest.mark.parametrize("hour", [0.5, 7.25, 11.9])
def test_hour_and_distance_of_a_place_are_those_it_was_found_by(
    rig: Rig, scans: dict[str, FittedScan], hour: float
) -> None:
    skin = FittedSkin(rig, scans["standing"].vertices)
    nipple = skin.landmark("nipple_R")
    distance, angle = clock_place(skin, nipple, on_clock(skin, nipple, 0.045, np.array([angle_of(hour)])))
    assert 1e3 * distance == pytest.approx(45.0, abs=0.2)  # the rim's chords lie under the circle
    assert np.degrees(angle) / 30.0 % 12.0 == pytest.approx(hour, abs=0.02)


def test_the_new_nipple_never_comes_below_the_nipple(live: LiveSkin) -> None:
    start = handle(live.drawn("vertical", {}), "new_nipple_L")
    found = live.drawn("vertical", {}, drag=Drag("new_nipple_L", tuple(start.at - 0.02 * start.handle.grows)))
    assert "stops at" in found.limit
    assert handle(found, "new_nipple_L").at == pytest.approx(start.at, abs=0.003)


@pytest.mark.parametrize(
    ("name", "drag", "sentence"),
    [
        ("ellipse", Drag("nose_L", (0.0, 0.0, 0.0)), '"nose_L" is not a handle of ellipse'),
        ("ellipse", Drag("", (0.0, 0.0, 0.0)), "is no handle"),
        ("ellipse", Drag("axis_L", (5.0, 5.0, 5.0)), "off the fitted skin"),
        ("tumour", Drag("radius_R", (0.0, 0.0, 0.0)), "left side only"),
        ("circle", None, "circle"),
    ],
)
def test_what_cannot_be_dragged_is_refused_with_a_sentence(
    live: LiveSkin, name: str, drag: Drag | None, sentence: str
) -> None:
    with pytest.raises(BadDrawing) as refused:
        live.drawn(name, PATTERNS.get(name, {}), drag=drag)
    assert sentence in str(refused.value)


@pytest.fixture(scope="module")
def symmetric(rig: Rig) -> LiveSkin:
    return LiveSkin(rig, FittedScan(ScanTarget(rig.template, rig.faces), rig.template, {}, "standing"))


OTHERS = {"first": "second", "second": "first"}  # what the observer sees on his left comes first


@pytest.mark.parametrize("name", ["vertical", "ellipse", "tumour"])
def test_handles_of_the_right_breast_are_those_of_the_left_in_a_mirror_and_so_are_their_drags(
    symmetric: LiveSkin, name: str
) -> None:
    mirror = np.array([-1.0, 1.0, 1.0])
    left, right = dict(PATTERNS[name]), dict(PATTERNS[name])
    if name == "tumour":
        right |= {"side": "R", "clock": 12.0 - float(left["clock"])}
    ones = symmetric.drawn(name, left, side="L").handles
    others = {each.handle.name: each for each in symmetric.drawn(name, right, side="R").handles}
    partners = {
        each.handle.name: "_".join(OTHERS.get(word, word) for word in each.handle.name[:-1].split("_")) + "R"
        for each in ones
    }
    assert {*partners.values()} == {*others}
    for each in ones:
        handle, other = each.handle, others[partners[each.handle.name]]
        assert other.at == pytest.approx(mirror * each.at, abs=1.5e-3), handle.name
        assert other.handle.grows == pytest.approx(mirror * handle.grows, abs=0.1), handle.name
        way = handle.grows if handle.grows.any() else np.array([0.8, 0.6, 0.0])
        to = each.at + 0.006 * way + np.array([0.001, 0.0, 0.0])
        dragged = symmetric.drawn(name, left, drag=Drag(handle.name, tuple(to)))
        here, first = dragged.parameters, each.numbers[0]
        assert dragged.limit or not handle.grows.any() or float(here[first.parameter]) > first.value, handle.name
        there = symmetric.drawn(name, right, drag=Drag(other.handle.name, tuple(mirror * to))).parameters
        for number in each.numbers:
            one, two = (float(found.get(number.parameter, 0.0)) for found in (here, there))
            two = 12.0 - two if number.parameter == "clock" else two
            assert two == pytest.approx(one, abs={"mm": 1.0, "deg": 2.0, "h": 0.1}[number.unit]), handle.name


@pytest.mark.parametrize("name", [*PATTERNS])
def test_a_handle_stands_on_what_it_changes(symmetric: LiveSkin, name: str) -> None:
    apart = ("new_nipple", "width", "centre")  # in the middle of a circle, or beside a limb
    found = symmetric.drawn(name, PATTERNS[name])
    for each in found.handles:
        if each.handle.name.startswith(apart):
            continue
        read = each.handle.values_at(symmetric._skin.nearest(each.handle.at[None]))
        for number in each.numbers:
            near = {"mm": 2.0, "deg": 2.0, "h": 0.1}[number.unit]
            assert read[number.parameter] == pytest.approx(number.value, abs=near), each.handle.name
        lines = [line for line, _ in found.lines if line.name.endswith(each.handle.side)]
        rims = [np.concatenate([line.points, line.points[:1]]) if line.closed else line.points for line in lines]
        nearest = min(float(np.linalg.norm(nearest_on_way(rim, each.at)[0] - each.at)) for rim in rims)
        assert nearest < 1e-3, each.handle.name


@pytest.mark.parametrize("name", [*PATTERNS])
def test_handles_lie_where_their_names_say(symmetric: LiveSkin, rig: Rig, name: str) -> None:
    """On the left; the right is its mirror, see above."""
    at = {each.handle.name[:-2]: each.at for each in symmetric.drawn(name, PATTERNS[name], side="L").handles}
    nipple = rig.landmark_points(("nipple_L",)).positions(rig.template, rig.faces)[0]
    pairs = {each: each.replace("first", "second") for each in at if each.endswith("first")}
    assert all(at[first][0] < at[second][0] for first, second in pairs.items())  # to the observer's left is her right
    out = {place: OUTWARDS["L"] * float((each - nipple)[0]) for place, each in at.items()}
    up = {place: float((each - nipple)[1]) for place, each in at.items()}
    assert all(out[place] > 0.01 for place in ("areola", "outer", "length_lateral", "axis") if place in out)
    assert name != "tumour" or out["radius"] > out["centre"] + 0.003
    assert all(out[place] < -0.01 for place in ("length_medial",) if place in out)
    assert all(up[place] > 0.01 for place in ("lift", "width_upper", "axis") if place in up)
    assert all(up[place] < -0.01 for place in ("outer_below", "width_lower", "fold", "end") if place in up)


def test_a_tumour_above_the_nipple_is_at_twelve_and_not_at_zero(symmetric: LiveSkin) -> None:
    asked = TUMOUR | {"clock": 12.0}
    start = handle(symmetric.drawn("tumour", asked), "centre_L")
    for aside, hour in ((0.0, 12.0), (0.006, 12.25), (-0.006, 11.75), (0.02, 0.85)):  # her left is after twelve
        to = start.at + np.array([aside, 0.0, 0.0])
        found = symmetric.drawn("tumour", asked, drag=Drag("centre_L", tuple(to))).parameters
        assert float(found["clock"]) == pytest.approx(hour, abs=0.15)

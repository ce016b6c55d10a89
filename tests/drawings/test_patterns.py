"""Patterns in the patient's millimetres: hours of the clock, true circles, the Wise pattern; and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from breastrig.core.errors import BadDrawing
from breastrig.drawings.clock import FittedSkin, angle_of, on_clock
from breastrig.drawings.constructions.reduction import Reduction, ends
from breastrig.drawings.constructions.tumour import Tumour
from breastrig.drawings.patterns import asked_drawing, known_drawings, offered_patterns, pattern_help, tumour_text
from breastrig.geometry.polyline import length
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import DrawnShape, Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import shaped


@pytest.fixture(scope="module")
def sagging(torso: Rig) -> np.ndarray:
    """(V, 3) m: a larger body with sagging breasts."""
    weights = rest_parameters(torso).weights.copy()
    for name, weight in (("ptosis", 1.8), ("volume_large", 1.5), ("nipple_vertical", -1.4)):
        for side in ("_L", "_R"):
            weights[torso.shape_names.index(name + side)] = weight
    return 1.15 * shaped(torso, weights)


def drawn(rig: Rig, vertices: np.ndarray, text: str) -> dict[str, DrawnShape]:
    return {shape.name: shape for shape in asked_drawing(rig, text).on_model(rig, vertices).shapes}


def one(points: SurfacePoints, k: int) -> SurfacePoints:
    return SurfacePoints(points.faces[[k]], points.barycentric[[k]])


@pytest.mark.parametrize("side", ["L", "R"])
def test_three_oclock_is_towards_her_left_on_both_breasts(torso: Rig, side: str) -> None:
    skin = FittedSkin(torso, torso.template)
    nipple = skin.landmark(f"nipple_{side}")
    three, six, nine, twelve = (
        skin.at(on_clock(skin, nipple, 0.03, np.array([angle_of(hour)])))[0] - skin.at(nipple)[0]
        for hour in (3, 6, 9, 12)
    )
    assert three[0] > 0.01  # +X is the patient's left
    assert nine[0] < -0.01
    assert twelve[1] > 0.02
    assert six[1] < -0.02
    assert abs(three[1]) < 0.01


def test_patterns_start_from_where_a_landmark_is_seen_not_from_where_the_model_has_it(torso: Rig) -> None:
    own = FittedSkin(torso, torso.template)
    place = own.at(own.landmark("nipple_L"))[0] + np.array([0.006, 0.004, 0.0])
    skin = FittedSkin(torso, torso.template, {"nipple_L": place})
    assert np.linalg.norm(skin.at(skin.landmark("nipple_L"))[0] - place) < 0.005
    asked = asked_drawing(torso, "tumour:side=L,clock=10,distance_mm=45,radius_mm=12")
    for start, known in ((own, None), (skin, {"nipple_L": place})):
        circle = own.at(asked.on_model(torso, torso.template, known).shapes[0].points)
        middle = own.nearest(circle.mean(axis=0, keepdims=True))
        assert own.geodesics.distance(start.landmark("nipple_L"), middle) == pytest.approx(0.045, abs=0.0015)
    np.testing.assert_array_equal(own.at(own.landmark("nipple_R")), skin.at(skin.landmark("nipple_R")))


def test_half_hours_lie_between(torso: Rig) -> None:
    skin = FittedSkin(torso, torso.template)
    angles = np.radians(30.0 * np.arange(0.5, 12.1, 0.5))
    arms = skin.at(on_clock(skin, skin.landmark("nipple_L"), 0.04, angles)) - skin.at(skin.landmark("nipple_L"))
    facing = np.cross(arms, np.roll(arms, -1, axis=0))
    assert (facing @ facing.sum(axis=0) > 0.0).all()  # once around, one way


@pytest.mark.parametrize("side", ["L", "R"])
def test_a_tumour_is_a_true_circle_at_its_true_distance(torso: Rig, sagging: np.ndarray, side: str) -> None:
    text = f"tumour:side={side},clock=10.5,distance_mm=45,radius_mm=12"
    circle = drawn(torso, sagging, text)[f"tumour_{side}"]
    skin = FittedSkin(torso, sagging)
    centre = on_clock(skin, skin.landmark(f"nipple_{side}"), 0.045, np.array([angle_of(10.5)]))
    away = skin.geodesics.path(skin.landmark(f"nipple_{side}"), centre)
    assert length(away) == pytest.approx(0.045, abs=1e-4)  # a chord of the rim that carries it
    radii = [length(skin.geodesics.path(centre, one(circle.points, k))) for k in range(0, len(circle.points), 6)]
    np.testing.assert_allclose(radii, 0.012, atol=2e-5)
    assert circle.closed
    assert len(circle.points) > 40


def test_a_pattern_is_the_same_skin_wherever_the_patient_stands(torso: Rig) -> None:
    text = "tumour:side=R,clock=2,distance_mm=40,radius_mm=10"
    turn = Rotation.from_rotvec([0.4, -1.9, 0.7])
    here = drawn(torso, torso.template, text)["tumour_R"].points.positions(torso.template, torso.faces)
    away = np.array([0.3, -2.0, 1.0])
    moved = turn.apply(torso.template.copy()) + away
    there = drawn(torso, moved, text)["tumour_R"].points.positions(moved, torso.faces)
    np.testing.assert_allclose(there, turn.apply(here) + away, atol=1e-6)


def picked(rig: Rig, place: np.ndarray, radius_mm: float = 20.0) -> DrawnShape:
    text = tumour_text("at:{},{},{},{}".format(*(1e3 * place), radius_mm))
    (shape,) = asked_drawing(rig, text).on_model(rig, rig.template).shapes
    return shape


@pytest.mark.parametrize("side", ["L", "R"])
def test_a_tumour_around_a_picked_place(torso: Rig, side: str) -> None:
    """The pick is 4 mm before the skin."""
    skin = FittedSkin(torso, torso.template)
    nipple, front = skin.at(skin.landmark(f"nipple_{side}"))[0], np.array([0.0, 0.0, 1.0])
    shape = picked(torso, nipple + 0.004 * front, 20.0)
    assert shape.name == f"tumour_{side}"
    centre = skin.nearest(nipple[None] + 0.004 * front)
    radii = [length(skin.geodesics.path(centre, one(shape.points, k))) for k in range(0, len(shape.points), 6)]
    np.testing.assert_allclose(radii, 0.02, atol=2e-5)


def test_a_picked_place_off_the_skin_is_refused(torso: Rig) -> None:
    place = np.array([0.0, 0.3, 0.5])
    with pytest.raises(BadDrawing, match=r"centre is \d+ mm off the skin; check its frame and unit"):
        picked(torso, place)


def test_a_circle_that_runs_over_the_end_of_the_model_is_refused(torso: Rig) -> None:
    arm = torso.template[torso.regions["arm_L"]].mean(axis=0)
    edge = torso.template[np.linalg.norm(torso.template - arm, axis=1).argmin()]
    with pytest.raises(BadDrawing, match="A circle of 80 mm on the skin does not close here: the surface ends before"):
        picked(torso, edge, 80.0)


def test_two_tumours_of_a_side_have_two_names(torso: Rig) -> None:
    text = "+".join(["lumpectomy", *(tumour_text(short) for short in ("L:10,45,12", "L:3,20,8", "R:6,30,5"))])
    names = set(drawn(torso, torso.template, text))
    assert names == {"sternum_upper", "sternum_lower", "breast_L", "breast_R", "tumour_L", "tumour_2_L", "tumour_R"}


@pytest.mark.parametrize("body", ["template", "sagging"])
def test_the_limbs_are_true_millimetres_on_every_body(torso: Rig, sagging: np.ndarray, body: str) -> None:
    vertices = torso.template if body == "template" else sagging
    shapes = drawn(torso, vertices, "reduction:limb_mm=38,areola_mm=40")
    skin = FittedSkin(torso, vertices)
    for side in ("L", "R"):
        wise = shapes[f"wise_{side}"]
        line, (lower, upper, other_upper, other_lower) = skin.at(wise.points), wise.corners
        limbs = [line[lower : upper + 1], line[other_upper : other_lower + 1]]
        np.testing.assert_allclose([length(limb) for limb in limbs], 0.038, atol=2e-4)
        centre = skin.landmark(f"nipple_{side}")
        areola = shapes[f"areola_{side}"].points
        radii = [length(skin.geodesics.path(centre, one(areola, k))) for k in range(0, len(areola), 6)]
        np.testing.assert_allclose(radii, 0.020, atol=2e-5)
        keyhole = length(line[upper : other_upper + 1])
        assert keyhole == pytest.approx(np.pi * 0.040, abs=5e-4)  # they are sewn together
        fold = skin.at(shapes[f"wise_fold_{side}"].points)
        ends = np.linalg.norm(line[[0, -1]][:, None] - fold[[0, -1]], axis=2)
        assert ends.min(axis=1).max() < 1e-9


def test_both_sides_of_a_symmetric_body_mirror_each_other(torso: Rig) -> None:
    shapes = drawn(torso, torso.template, "reduction")
    for name in ("wise", "areola", "new_nipple"):
        left, right = (shapes[f"{name}_{side}"].points.positions(torso.template, torso.faces) for side in "LR")
        gaps = np.linalg.norm(left[:, None] * [-1.0, 1.0, 1.0] - right, axis=2)
        assert max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) < 2.5e-3  # points lie at different steps


def test_the_new_nipple_lies_on_the_meridian_at_the_folds_height(torso: Rig, sagging: np.ndarray) -> None:
    skin = FittedSkin(torso, sagging)
    up = skin.axes[:, 1]
    for side in ("L", "R"):
        fold = skin.at(skin.landmark(f"inframammary_fold_{side}"))[0] @ up
        assert skin.at(skin.landmark(f"nipple_{side}"))[0] @ up < fold + 0.036  # what follows raises it
        for above in (37.0, 40.0):
            mark = drawn(torso, sagging, f"reduction:side={side},nipple_above_fold_mm={above}")[f"new_nipple_{side}"]
            middle = skin.at(mark.points).mean(axis=0)
            assert middle @ up == pytest.approx(fold + 1e-3 * above, abs=5e-4)
            meridian = skin.geodesics.path(skin.landmark(f"midclavicle_{side}"), skin.landmark(f"nipple_{side}"))
            assert np.linalg.norm(meridian[:, None] - skin.at(mark.points), axis=2).min() < 0.0045


def test_without_ptosis_the_nipple_stays(torso: Rig) -> None:
    mark = drawn(torso, torso.template, "reduction:side=L")["new_nipple_L"]
    skin = FittedSkin(torso, torso.template)
    nipple = skin.landmark("nipple_L")
    radii = [length(skin.geodesics.path(nipple, one(mark.points, k))) for k in range(0, len(mark.points), 6)]
    np.testing.assert_allclose(radii, 0.003, atol=2e-5)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("wise", '"wise" is not a drawing of this model; known are: lumpectomy, anatomy,'),
        ("", '"" is not a drawing'),
        ("lumpectomy:limb_mm=3", 'The drawing "lumpectomy" is a fixed one of the model and has no parameters.'),
        ("reduction:limbs=50", '"limbs" is not a parameter of reduction; known are: side, areola_mm, limb_mm,'),
        ("reduction:limb_mm", '"limb_mm" is not a parameter of reduction; write name=value, for instance areola_mm=42'),
        ("reduction:limb_mm=50,limb_mm=40", "The parameter limb_mm of reduction is given twice."),
        ("reduction:limb_mm=500", "limb_mm of reduction cannot be 500: input should be less than or equal to 80"),
        ("reduction:limb_mm=nan", "limb_mm of reduction cannot be nan: "),
        ("reduction:limb_mm=long", "limb_mm of reduction cannot be long: write a number, for instance 4.5 or 4,5."),
        ("reduction:limb_mm=1,234", "limb_mm of reduction cannot be 1,234: it can be read in two ways;"),
        ("reduction:limb_mm=1.2,3", "limb_mm of reduction cannot be 1.2,3: it can be read in two ways;"),
        ("tumour:side=L,clock=10:75,distance_mm=4,radius_mm=3", "write an hour, for instance 10:30 or 10.5."),
        ("tumour:side=L,clock=0:10,distance_mm=10:30,radius_mm=3", "distance_mm of tumour cannot be 10:30: write a"),
        (
            "tumour:L,10,5,45,12",
            "write name=value, for instance side=L (decimals with a point).",
        ),
        ("reduction:side=M", "side of reduction cannot be M: input should be 'both', 'L' or 'R'"),
        ("tumour", "The drawing tumour also needs side, clock, distance_mm, radius_mm."),
        (
            "tumour:side=L,clock=13,distance_mm=40,radius_mm=9",
            "clock of tumour cannot be 13: an hour of the clock",
        ),
        ("tumour:side=L,clock=nan,distance_mm=40,radius_mm=9", "clock of tumour cannot be nan: "),
        ("tumour:side=L,clock=3,distance_mm=40,radius_mm=0", "radius_mm of tumour cannot be 0: input should be"),
        ("tumour:side=L,clock=3,distance_mm=40,radius_mm=300", "radius_mm of tumour cannot be 300: input should be"),
        ("tumour:side=L,clock=3,distance_mm=-4,radius_mm=3", "distance_mm of tumour cannot be -4: input should be"),
    ],
)
def test_a_wish_that_cannot_be_is_refused_before_the_fit(torso: Rig, text: str, words: str) -> None:
    with pytest.raises(BadDrawing) as refused:
        asked_drawing(torso, text)
    assert words in str(refused.value)
    assert str(refused.value).endswith(".")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("tumour:side=L,clock=10:30,distance_mm=4,5,radius_mm=12", (10.5, 4.5, 12.0)),
        (tumour_text("L:10:30,43.5,12"), (10.5, 43.5, 12.0)),
        ("tumour:side=R,radius_mm=12,5 mm,distance_mm=45mm,clock=10½", (10.5, 45.0, 12.5)),
        ("tumour:side=R,clock=12:20,distance_mm=12,345,radius_mm=1", None),
        ("tumour:side=R,clock=10,5,distance_mm=12.345,radius_mm=1,5", (10.5, 12.345, 1.5)),
    ],
)
def test_numbers_are_read_as_people_write_them(
    torso: Rig, text: str, values: tuple[float, float, float] | None
) -> None:
    if values is None:
        with pytest.raises(BadDrawing, match="two ways"):
            asked_drawing(torso, text)
        return
    [(_, tumour)] = asked_drawing(torso, text).patterns
    assert isinstance(tumour, Tumour)
    assert (tumour.clock, tumour.distance_mm, tumour.radius_mm) == values


@pytest.mark.parametrize("short", ["L", "L:10", "L:10,45", "L:10,45,12,3", "10,45,12", "at:1,2,3"])
def test_a_short_tumour_that_is_none(short: str) -> None:
    with pytest.raises(BadDrawing, match="is not a tumour; write SIDE:HOUR,DISTANCE_MM,RADIUS_MM"):
        tumour_text(short)


def test_a_tumour_beside_the_breast_is_refused(torso: Rig) -> None:
    text = tumour_text("L:3,180,10")
    with pytest.raises(BadDrawing, match=r"180 mm from the nipple, would lie \d+ mm beside the left breast"):
        drawn(torso, torso.template, text)


def test_limbs_that_reach_the_fold_are_refused_when_asked_for_and_shortened_when_not(torso: Rig) -> None:
    with pytest.raises(BadDrawing, match=r"No room on the left: limbs of 75 mm reach the fold\. Choose shorter limbs"):
        drawn(torso, torso.template, "reduction:limb_mm=75")
    shortened = drawn(torso, torso.template, "reduction")["wise_L"]
    assert shortened.label == "left keyhole and short limbs of 37.5 mm"  # and the drawing says how long they became


SIZES = {  # what differs from the mean body, and whether a Wise pattern fits on it
    "flat": ({"volume_small": 2.0}, False),
    "small and hanging": ({"volume_large": -1.0, "ptosis": 1.2}, False),
    "mean": ({}, True),
    "hanging": ({"volume_large": 1.5, "ptosis": 1.5, "nipple_vertical": -1.2}, True),
}


@pytest.mark.parametrize(("size", "side"), [*zip(SIZES, "LRLR", strict=True)])
def test_a_wise_pattern_looks_like_one_or_says_that_the_breast_is_too_small(torso: Rig, size: str, side: str) -> None:
    shapes, fits = SIZES[size]
    weights = rest_parameters(torso).weights.copy()
    for name, weight in shapes.items():
        weights[[torso.shape_names.index(f"{name}_{each}") for each in "LR"]] = weight
    skin = FittedSkin(torso, shaped(torso, weights))
    pattern = Reduction(side=side)
    if not fits:
        word = {"L": "left", "R": "right"}[side]
        with pytest.raises(BadDrawing, match=f"^No room for a Wise pattern on the {word}: .*vertical"):
            pattern.constructed(skin)
        return
    breast = pattern.constructed(skin)[side]
    radius = skin.geodesics.distance(breast.new, one(breast.arc, 0))  # of the keyhole
    limbs = [length(limb) for limb in breast.limbs]
    assert min(limbs) > radius
    assert min(limbs) > 0.03 - 1e-4
    first, last = skin.at(breast.lower)
    assert np.linalg.norm(first - last) > np.linalg.norm(np.diff(skin.at(ends(breast.arc)), axis=0))  # they diverge
    assert min(map(length, breast.outer)) > radius  # and the horizontal limbs are no stubs


def test_another_rig_without_the_needed_marks_says_which(toy_rig: Rig) -> None:
    assert {"reduction", "tumour"} <= set(known_drawings(toy_rig))
    bare = replace(toy_rig, landmarks=())
    with pytest.raises(BadDrawing, match="starts from the landmark nipple_L, which this model does not have"):
        drawn(bare, bare.template, "reduction")


@pytest.mark.parametrize(("side", "below"), [("R", -8.0)])
def test_a_new_fold_lies_below_her_own_by_a_tapes_length_and_the_limbs_end_on_it(
    torso: Rig, side: str, below: float
) -> None:
    skin = FittedSkin(torso, torso.template)
    own = drawn(torso, torso.template, f"reduction:side={side},limb_mm=30")
    new = drawn(torso, torso.template, f"reduction:side={side},limb_mm=30,fold_below_mm={below}")
    before, after = (shapes[f"wise_fold_{side}"].points for shapes in (own, new))
    assert len(before) == len(after)
    tapes = [1e3 * skin.geodesics.distance(one(before, k), one(after, k)) for k in range(0, len(before), 5)]
    assert tapes == pytest.approx([abs(below)] * len(tapes), abs=1.0)
    down = (skin.at(before) - skin.at(after)) @ skin.axes[:, 1]
    assert (np.sign(down) == np.sign(below)).all()
    ends = skin.at(new[f"wise_{side}"].points)[[0, -1]]
    folds = skin.at(after)[[0, -1]]
    gaps = np.linalg.norm(ends[:, None] - folds, axis=2).min(axis=1)
    assert gaps.max() < 1e-3
    for name in (f"areola_{side}", f"new_nipple_{side}"):
        assert np.array_equal(own[name].points.faces, new[name].points.faces)


def test_only_a_rig_with_breasts_and_folds_is_offered_the_wise_pattern(torso: Rig, toy_rig: Rig) -> None:
    names = ["reduction", "vertical", "periareolar", "ellipse"]
    assert [name for name, _ in offered_patterns(torso)] == names
    assert [name for name, _ in offered_patterns(toy_rig)] == names[2:]
    assert offered_patterns(torso)[0] == ("reduction", "Reduction (Wise pattern)")


def test_names_may_be_left_out_where_all_parameters_are_needed(torso: Rig) -> None:
    named = drawn(torso, torso.template, "tumour:side=R,clock=2,distance_mm=40,radius_mm=10")["tumour_R"].points
    short = drawn(torso, torso.template, "tumour:R,2,40,10")["tumour_R"].points
    np.testing.assert_array_equal(short.faces, named.faces)
    np.testing.assert_array_equal(short.barycentric, named.barycentric)


def test_the_help_names_every_parameter() -> None:
    for word in ("reduction", "areola_mm", "limb_mm", "limb_angle_deg", "tumour", "clock", "radius_mm"):
        assert word in pattern_help()


def test_a_new_nipple_comes_to_the_height_of_the_fold_that_was_picked_however_near_the_fitted_skin_is(
    torso: Rig, sagging: np.ndarray
) -> None:
    own = FittedSkin(torso, sagging)
    fold = own.at(own.landmark("inframammary_fold_L"))[0]
    for beside in (np.array([0.0, up, out]) for up, out in ((0.034, 0.0), (0.038, -0.012), (0.04, 0.006))):  # m
        known = {"inframammary_fold_L": fold + own.axes @ beside}
        asked = asked_drawing(torso, "reduction:side=L,limb_mm=30")
        shapes = {shape.name: shape for shape in asked.on_model(torso, sagging, known).shapes}
        mark = own.at(shapes["new_nipple_L"].points)
        middle = 0.5 * (mark @ own.axes[:, 1]).min() + 0.5 * (mark @ own.axes[:, 1]).max()
        assert middle == pytest.approx(float((fold + own.axes @ beside) @ own.axes[:, 1]), abs=0.0006)

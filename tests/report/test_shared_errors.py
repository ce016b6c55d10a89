"""Lengths and differences leave open what their ends do not share; a band that says nothing is no number."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.core.stances import SIDES
from breastrig.report.bands import KNOWN_MM, OF_90, between_sides, without_unknown
from breastrig.report.body_frame import body_frame
from breastrig.report.calibration import Spread, measure_calibration
from breastrig.report.measures import measures
from breastrig.report.stance import Stance, places
from breastrig.report.table import Row, Value, changes, csv_bytes, flat_rows, with_vague
from breastrig.rig.model import Rig

RADIUS = 1.5  # times the deviation over all three axes


def covariance(rig: Rig, seed: int) -> Array:
    """(3 L, 3 L) m²: all landmarks move together by 20 mm, and each by a few for itself."""
    rng, size = np.random.default_rng(seed), 3 * len(rig.landmark_names)
    together = np.tile(np.eye(3), (len(rig.landmark_names), 1)) * 0.02
    own = np.diag(rng.uniform(0.001, 0.004, size))
    return np.asarray(together @ together.T + own @ own)


def stance(rig: Rig, joint: Array | None, **changes: object) -> Stance:
    spread = covariance(rig, 1) if joint is None else joint
    radii = RADIUS * np.sqrt(np.diag(spread).reshape(-1, 3).sum(axis=1))
    names = tuple(rig.landmark_names)
    found = Stance(
        rig,
        rig.template,
        rig.template,
        rig.faces,
        "standing",
        landmark_radii=dict(zip(names, radii.tolist(), strict=True)),
        radii=np.full(len(rig.template), 0.004),
        joint=None if joint is None else (names, joint),
    )
    return replace(found, **changes)


def between(rig: Rig, joint: Array) -> Array:
    """(3 L, 3 L) m², of which differences of the two sides are drawn."""
    known = measure_calibration(rig)
    shared = between_sides(
        (tuple(rig.landmark_names), joint), body_frame(rig, rig.template), known.sides.apart["standing"]
    )
    return shared[1]


def draws(rig: Rig, joint: Array) -> Array:
    """(20,000, L, 3) m."""
    found = np.random.default_rng(2).multivariate_normal(np.zeros(len(joint)), joint, 20_000)
    return np.asarray(found.reshape(-1, len(rig.landmark_names), 3))


def straight(found: Stance) -> dict[str, Row]:
    return {row.measure: row for row in measures(found) if row.kind == "straight"}


@pytest.mark.parametrize("name", ["midclavicle_nipple", "nipple_fold"])
def test_nine_of_ten_true_lengths_and_differences_are_held(name: str, rig: Rig) -> None:
    """True places drawn with the model's own covariance, differences with that of sides; what is shared cancels."""
    joint = covariance(rig, 1)
    row, asked = straight(stance(rig, joint))[name], next(each for each in rig.lengths if each.name == name)
    at = {place.name: place.point for place in places(stance(rig, joint)).values()}
    names = list(rig.landmark_names)

    def lengths(drawn: Array) -> list[Array]:
        ends = [[end if end in at else f"{end}_{side}" for end in (asked.start, asked.end)] for side in SIDES]
        places = [[at[end] + drawn[:, names.index(end)] for end in each] for each in ends]
        return [np.asarray(np.linalg.norm(b - a, axis=1)) for a, b in places]

    assert row.left is not None
    assert row.difference is not None
    left, apart = lengths(draws(rig, joint))[0], np.subtract(*lengths(draws(rig, between(rig, joint))))
    for true, value in ((1e3 * left, row.left), (1e3 * apart, row.difference)):
        assert np.mean((true >= value.low) & (true <= value.high)) == pytest.approx(0.9, abs=0.02)
    alone = straight(stance(rig, None))[name]
    assert row.difference.margin < 0.3 * alone.between


@pytest.mark.parametrize("seed", [5])
def test_nine_of_ten_differences_of_the_distances_to_the_midline_are_held(seed: int, rig: Rig) -> None:
    """The plane goes with the model's landmarks on it, so that what moves all of them is no difference."""
    joint = covariance(rig, seed)
    found = stance(rig, joint)
    row, alone = straight(found)["nipple_midline"], straight(stance(rig, None))["nipple_midline"]
    names, across = list(rig.landmark_names), body_frame(rig, rig.template).axes[:, 0]

    def outwards(covariance: Array) -> list[Array]:
        off = draws(rig, covariance) @ across
        plane = off[:, [k for k, name in enumerate(names) if not name.endswith(("_L", "_R"))]].mean(axis=1)
        return [off[:, names.index(name)] - plane for name in ("nipple_L", "nipple_R")]

    for true, value in ((outwards(joint)[0], row.left), (sum(outwards(between(rig, joint))), row.difference)):
        assert np.mean(np.abs(1e3 * true) <= value.margin) == pytest.approx(0.9, abs=0.02)
    assert alone.not_known == ("difference",)
    assert row.difference.margin < 0.3 * (alone.left.margin or 0.0)


@pytest.mark.parametrize("apart", [1.0, 0.3])
def test_sides_are_off_alike_more_and_unlike_less_than_a_fit_says(apart: float, rig: Rig) -> None:
    """Each landmark alone stays as sure where both parts are as large, and all of it remains a covariance."""
    names, frame = tuple(rig.landmark_names), body_frame(rig, rig.template)
    rng = np.random.default_rng(4)
    left, across = 0.01 * rng.normal(size=3), frame.axes[:, 0]
    mirrored = left - 2.0 * (left @ across) * across
    one, other = names.index("nipple_L"), names.index("nipple_R")

    def spread(sign: float) -> Array:
        """Both nipples' errors, mirrored (1) or the opposite (-1)."""
        way = np.zeros((len(names), 3))
        way[one], way[other] = left, sign * mirrored
        return np.outer(way, way)

    def found(covariance: Array) -> Array:
        return between_sides((names, covariance), frame, apart)[1]

    assert found(spread(-1.0)) == pytest.approx(apart**2 * spread(-1.0), abs=1e-12)
    assert found(spread(1.0)) == pytest.approx((2.0 - apart**2) * spread(1.0), abs=1e-12)
    assert np.diag(found(spread(1.0) + spread(-1.0))) == pytest.approx(np.diag(spread(1.0) + spread(-1.0)))
    moved = np.zeros((len(names), 3))
    moved[:] = frame.axes[:, 1]  # all of it up: no length changes
    assert found(np.outer(moved, moved)) == pytest.approx((2.0 - apart**2) * np.outer(moved, moved))
    assert np.linalg.eigvalsh(found(covariance(rig, 3))).min() > 0.0


def test_what_is_no_landmark_is_off_alike_on_both_sides(rig: Rig) -> None:
    """M6 has no landmark at all: its ends are off by what was measured, most of it on both sides."""
    found, known, frame = stance(rig, covariance(rig, 1)), measure_calibration(rig), body_frame(rig, rig.template)
    assert 0.6 < known.sides.lowest < 0.9
    assert 0.6 < known.sides.lateral < 0.9
    (row,) = (row for row in measures(found) if row.measure == "M6")
    lengths = [abs(float(frame.lateral(row.paths[side][0]))) for side in ("left", "right")]
    half, shared = known.ends.lateral.of(0.004), known.sides.lateral
    drawn = np.random.default_rng(3).multivariate_normal([0.0, 0.0], [[1.0, shared], [shared, 1.0]], 50_000)
    true = np.asarray(lengths) + half / OF_90 * drawn
    ratio = true[:, 0] / true[:, 1] if lengths[0] <= lengths[1] else true[:, 1] / true[:, 0]
    assert np.mean(np.abs(ratio - row.value.value) <= (row.value.margin or 0.0)) == pytest.approx(0.9, abs=0.01)


@pytest.mark.parametrize(("name", "correlation"), [("base_width", "base_width")])
def test_differences_of_what_the_outline_measures_take_what_both_sides_share(
    name: str, correlation: str, rig: Rig
) -> None:
    row = next(row for row in measures(stance(rig, covariance(rig, 1))) if row.measure == name)
    known = measure_calibration(rig)
    shared = getattr(known.sides, correlation)
    assert 0.4 < shared < 0.7
    a, b = row.left.margin or 0.0, row.right.margin or 0.0
    pair = np.random.default_rng(3).multivariate_normal([0.0, 0.0], [[1.0, shared], [shared, 1.0]], 50_000) / 1.645
    assert np.mean(np.abs(pair @ [a, -b]) <= row.between) == pytest.approx(0.9, abs=0.01)


def test_a_change_of_which_nothing_is_known_is_no_number(rig: Rig) -> None:
    wide, sure = row_of(63.0, 50.0), row_of(63.0, 5.0)
    (change,) = changes([wide], [wide])
    assert (change.left, change.difference) == (None, None)
    assert change.not_known == ("left", "right", "difference")
    (change,) = changes([sure], [sure])
    assert change.not_known == ()
    assert change.left is not None
    (change,) = changes([row_of(-5.0, 20.0, "in height")], [row_of(2.0, 20.0, "in height")])
    assert change.left is not None


def test_of_picked_ends_the_one_that_both_sides_share_counts_by_what_it_changes(rig: Rig) -> None:
    at = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))
    found = stance(rig, covariance(rig, 1), picked=at, landmark_radii=dict.fromkeys(at, 0.005))
    row = straight(found)["notch_nipple"]
    ways = {side: at[f"nipple_{side}"] - at["suprasternal_notch"] for side in SIDES}
    left, right = (ways[side] / np.linalg.norm(ways[side]) for side in SIDES)
    wanted = 5.0 * np.sqrt(2.0 + float((left - right) @ (left - right)))
    assert row.difference.margin == pytest.approx(wanted, rel=1e-6)
    assert row.difference.margin < np.hypot(5.0 * np.sqrt(2.0), 5.0 * np.sqrt(2.0))


def changed(rig: Rig, name: str, **more: object) -> tuple[Row, Row, Row]:
    """A row of two stances, of which the second is half as sure, and its change."""
    rows = [measures(stance(rig, size * covariance(rig, 1), **more)) for size in (0.01, 0.04)]
    one, two = (next(row for row in each if row.key == (name, "straight")) for each in rows)
    (change,) = (row for row in changes(*rows) if row.key == one.key)
    return one, two, change


def halves(*rows: Row, of: str) -> tuple[float, ...]:
    values = [getattr(row, of) for row in rows]
    assert all(value is not None and value.margin is not None for value in values)
    return tuple(value.margin for value in values)


def test_two_fits_without_picks_are_off_alike_in_a_length(rig: Rig) -> None:
    known = measure_calibration(rig)
    shared = known.stances.lengths
    assert 0.3 < shared < 0.7
    one, two, change = changed(rig, "notch_nipple")
    for side in ("left", "right"):
        a, b, found = halves(one, two, change, of=side)
        pair = np.random.default_rng(3).multivariate_normal([0.0, 0.0], [[1.0, shared], [shared, 1.0]], 50_000) / OF_90
        assert np.mean(np.abs(pair @ [a, -b]) <= found) == pytest.approx(0.9, abs=0.01)
    a, b, found = halves(one, two, change, of="difference")
    assert b == pytest.approx(2.0 * a)
    assert found == pytest.approx(np.hypot(a, b))  # of what the sides differ by they share little


def test_two_fits_are_wrong_independently_across_and_where_an_end_was_picked_or_seen(rig: Rig) -> None:
    at = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))
    known = [{where: {end: at[end]}} for where, end in (("picked", "suprasternal_notch"), ("seen", "nipple_L"))]
    for name, more in [("nipple_midline", {}), *(("notch_nipple", each) for each in known)]:
        one, two, change = changed(rig, name, **more)
        for side in ("left", "right"):
            a, b, found = halves(one, two, change, of=side)
            assert found == pytest.approx(np.hypot(a, b))
    rows = [measures(stance(rig, 0.01 * covariance(rig, 1), **more)) for more in ({}, known[0])]
    one, two = (next(row for row in each if row.key == ("notch_nipple", "straight")) for each in rows)
    (change,) = (row for row in changes(*rows) if row.key == one.key)
    a, b, found = halves(one, two, change, of="right")
    assert found == pytest.approx(np.hypot(a, b))  # picked on one of the two scans


def row_of(value: float, half: float, kind: str = "straight", unit: str = "mm") -> Row:
    least, most = (0.0, 1.0) if unit == "1" else (-np.inf, np.inf) if kind == "in height" else (0.0, np.inf)
    number = Value(value, max(value - half, least), min(value + half, most))
    return Row("a", "A", kind, unit, number, number, None, (), "")


@pytest.mark.parametrize(
    ("row", "gone"),
    [
        (row_of(63.0, 63.0), ("left", "right", "difference")),  # 0 to 126
        (row_of(63.0, 62.0), ("difference",)),  # 1 to 125; their difference 0 ± 88
        (row_of(63.0, 20.0), ()),
        (row_of(290.0, 280.0, "volume", "ml"), ("difference",)),
        (row_of(290.0, 300.0, "volume", "ml"), ("left", "right", "difference")),
        (row_of(0.4, 0.7, "ratio", "1"), ("left", "right", "difference")),
        (row_of(0.9, 0.05, "ratio", "1"), ()),
        (row_of(-5.0, 20.0, "in height"), ()),
        (row_of(-5.0, KNOWN_MM + 1.0, "in height"), ("left", "right", "difference")),
    ],
)
def test_a_band_that_says_nothing_is_no_number_anywhere(row: Row, gone: tuple[str, ...]) -> None:
    found = without_unknown(row)
    assert found.not_known == gone
    assert (found.left is None) == ("left" in gone)
    assert (found.difference is None) == ("difference" in gone)
    (flat,) = flat_rows([("standing", [found])])
    assert flat["not_known"] == "; ".join(gone)
    assert (flat["left"] is None, flat["left_low"] is None) == ("left" in gone, "left" in gone)
    assert (flat["difference"] is None, flat["difference_high"] is None) == ("difference" in gone, "difference" in gone)
    head, line = csv_bytes([flat], {}).decode().strip().splitlines()
    assert dict(zip(head.split(","), line.split(","), strict=True))["left_high"] == (
        "" if "left" in gone else str(flat["left_high"])
    )


@pytest.mark.parametrize(
    ("row", "vague"),
    [
        (row_of(200.0, 20.0), ()),
        (row_of(200.0, 20.1), ("left", "right", "difference")),
        (row_of(290.0, 40.0, "volume", "ml"), ("left", "right", "difference")),
        (replace(row_of(200.0, 10.0), left=Value(50.0, 44.0, 56.0)), ("left", "difference")),
        (replace(row_of(200.0, 10.0), left=None, right=None, value=Value(50.0, 44.0, 56.0)), ("value",)),
        (row_of(-5.0, 4.0, "in height"), ("left", "right", "difference")),
        (row_of(0.4, 0.1, "ratio", "1"), ()),
        (replace(row_of(50.0, 0.0), left=Value(50.0)), ()),
    ],
)
def test_a_measure_less_sure_than_a_tenth_of_itself_is_said_to_be_so_in_file_and_change(
    row: Row, vague: tuple[str, ...]
) -> None:
    found = with_vague(row)
    assert found.vague == vague
    sure = with_vague(row_of(200.0, 1.0, row.kind, row.unit))
    for before, after in ((found, sure), (sure, found)):
        first, second, *change = flat_rows([("standing", [before]), ("supine", [after])])
        assert {first["vague"], second["vague"]} == {"; ".join(vague), ""}
        for each in change:  # as sure as what it is made of
            there = [name for name in ("left", "right", "value", "difference") if each[name] is not None]
            assert each["vague"] == ("; ".join(there) if vague else "")
    assert csv_bytes(flat_rows([("standing", [found])]), {}).decode().split("\n")[0].count(",vague,") == 1


def moved_alike(rig: Rig) -> Array:
    """(3 L, 3 L) m²: all landmarks move up together, and those of both sides outwards alike, by 20 mm each."""
    axes = body_frame(rig, rig.template).axes
    sides = [1.0 if name.endswith("_L") else -1.0 if name.endswith("_R") else 0.0 for name in rig.landmark_names]
    up = np.tile(axes[:, 1], len(sides))
    outwards = np.concatenate([side * axes[:, 0] for side in sides])
    return np.asarray(0.02**2 * (np.outer(up, up) + np.outer(outwards, outwards)))


def sure_skin(rig: Rig, joint: Array | None, **more: object) -> dict[str, Row]:
    """Of a body whose landmarks alone are not known exactly."""
    rows = measures(stance(rig, joint, radii=np.zeros(len(rig.template)), **more))
    return {row.measure: row for row in rows if row.kind in ("ratio", "in height")}


@pytest.mark.parametrize("name", ["M2", "M4"])
def test_ratios_are_sure_of_what_moves_both_sides_alike(name: str, rig: Rig) -> None:
    joint = moved_alike(rig)
    row, alone = (
        sure_skin(rig, joint)[name],
        sure_skin(rig, None, landmark_radii=stance(rig, joint).landmark_radii)[name],
    )
    exact = sure_skin(rig, np.zeros_like(joint))[name].value
    assert row.value.margin == pytest.approx(exact.margin, abs=2e-3)  # of the ends that are no landmarks, if it has any
    assert name == "M5" or alone.value is None or (alone.value.margin or 0.0) > 0.05


@pytest.mark.parametrize("name", ["M2", "M3", "M4"])
def test_nine_of_ten_true_ratios_are_held(name: str, rig: Rig) -> None:
    joint = covariance(rig, 1) / 400.0  # small enough for a band to first order
    value = sure_skin(rig, joint)[name].value
    assert value is not None
    names, axes = list(rig.landmark_names), body_frame(rig, rig.template).axes
    drawn, known = draws(rig, between(rig, joint)), measure_calibration(rig)
    error, shared = {
        "M2": (known.ends.lowest, known.sides.lowest),
        "M4": (known.ends.lateral, known.sides.lateral),
    }.get(name, (Spread(least=0.0, share=0.0), 0.0))
    ends = (
        error.least / OF_90 * np.random.default_rng(3).multivariate_normal([0, 0], [[1, shared], [shared, 1]], 20_000)
    )
    off = dict(zip(names, (drawn @ axes).transpose(1, 2, 0), strict=True))  # to the left, up, forwards
    plane = np.mean([off[each][0] for each in names if not each.endswith(("_L", "_R"))], axis=0)
    lengths = []
    for side, paths, sign, end in zip(SIDES, ("left", "right"), (1.0, -1.0), ends.T, strict=True):
        a, b = sure_skin(rig, joint)[name].paths[paths]
        nipple = off[f"nipple_{side}"]
        left, up, _ = axes.T @ (a - b)
        lengths.append(
            {
                "M2": up + nipple[1] - end,
                "M3": sign * (left + nipple[0] - plane),
                "M4": sign * (-left - nipple[0]) + end,
            }[name]
        )
    true = np.min(lengths, axis=0) / np.max(lengths, axis=0)
    assert np.mean(np.abs(true - value.value) <= (value.margin or 0.0)) == pytest.approx(0.9, abs=0.02)


@pytest.mark.parametrize("name", ["nipple_above_fold", "lowest_point_above_fold"])
def test_differences_of_heights_are_sure_of_folds_that_move_alike(name: str, rig: Rig) -> None:
    at = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))
    nipples = {each: at[each] for each in ("nipple_L", "nipple_R")}
    row = sure_skin(rig, moved_alike(rig), picked=nipples)[name]
    known = measure_calibration(rig)
    own = known.heights.picked if name.startswith("nipple") else known.heights.lowest
    assert 1e3 * np.sqrt(2.0) * own <= (row.difference.margin or 0.0) < row.left.margin + 1e3 * own
    unshared = sure_skin(rig, np.diag(np.diag(moved_alike(rig))), picked=nipples)[name]
    assert row.between < 0.6 * (unshared.between or 0.0)

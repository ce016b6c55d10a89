"""A unit is decided only when one answer is plausible, and always with a reason."""

import numpy as np
import pytest

from breastrig.core.errors import BadScan, BadSettings
from breastrig.core.units import METRES_PER_UNIT
from breastrig.scan.units import decide_unit, extent, size_doubt


@pytest.mark.parametrize("unit", ["m", "dm", "cm", "mm"])
@pytest.mark.parametrize("metres", [0.75, 0.9, 1.0])
def test_a_torso_in_a_metric_unit_is_recognised(unit: str, metres: float) -> None:
    decided, reason = decide_unit(metres / METRES_PER_UNIT[unit], "auto")
    assert decided == unit
    assert f"{metres:.3g} m" in reason


@pytest.mark.parametrize("unit", ["m", "mm"])
@pytest.mark.parametrize("metres", [0.31, 0.4, 1.5, 2.5])
def test_metres_and_millimetres_are_never_doubtful(unit: str, metres: float) -> None:
    assert decide_unit(metres / METRES_PER_UNIT[unit], "auto")[0] == unit


def test_between_centimetres_and_inches_the_reason_names_both() -> None:
    unit, reason = decide_unit(90.0, "auto")
    assert unit == "cm"
    assert "inches (2.29 m)" in reason


@pytest.mark.parametrize("across", [35.0, 40.0, 50.0, 60.0, 20.0])
def test_two_plausible_units_are_not_decided_silently(across: float) -> None:
    with pytest.raises(BadScan, match=r"could be .* or .*; say which with units") as caught:
        decide_unit(across, "auto")
    assert f"{across:.4g} units across" in str(caught.value)


def test_auto_never_gives_a_unit_that_makes_the_scan_implausible() -> None:
    for across in np.geomspace(1e-3, 1e5, 2000):
        try:
            unit, reason = decide_unit(float(across), "auto")
        except BadScan:
            continue
        assert 0.3 <= across * METRES_PER_UNIT[unit] <= 2.6
        assert reason.endswith(".")


@pytest.mark.parametrize("across", [0.0, 0.05, 5000.0, float("inf"), float("nan")])
def test_a_size_that_fits_no_unit_is_refused(across: float) -> None:
    with pytest.raises(BadScan, match="no torso in any unit"):
        decide_unit(across, "auto")


@pytest.mark.parametrize(("across", "asked", "fits"), [(700.0, "m", "mm"), (0.9, "mm", "m"), (90.0, "mm", "cm")])
def test_a_given_unit_that_cannot_be_right_is_refused_with_one_that_fits(across: float, asked: str, fits: str) -> None:
    with pytest.raises(BadScan, match="which is no torso") as caught:
        decide_unit(across, asked)
    assert f"{fits} " in str(caught.value)


def test_a_given_unit_is_kept_where_auto_would_ask() -> None:
    assert decide_unit(40.0, "in")[0] == "in"
    assert decide_unit(40.0, "cm")[0] == "cm"


def test_an_unknown_unit_is_refused_with_the_known_ones() -> None:
    with pytest.raises(BadSettings, match='"yd" is not a unit; known are: auto, m, dm, cm, mm, in, ft'):
        decide_unit(1.0, "yd")


def test_a_few_stray_points_do_not_change_the_size() -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.5, 0.5, (10_000, 3))
    clean = extent(points)
    points[:20] *= 1000.0
    assert extent(points) == pytest.approx(clean, rel=0.01)


def test_feet_are_decided_where_nothing_else_fits_and_asked_about_where_decimetres_do() -> None:
    assert decide_unit(2.8, "auto") == (
        "ft",
        "The scan is 2.8 units across, which fits a torso only in feet (0.853 m).",
    )
    with pytest.raises(
        BadScan, match=r"could be decimetres \(0.35 m\) or feet \(1.07 m\); say which with units dm or ft"
    ):
        decide_unit(3.5, "auto")
    assert decide_unit(3.5, "ft")[0] == "ft"


@pytest.mark.parametrize("across", [0.3, 0.75, 1.0, 1.5, 1.9, 2.2, 2.6])
def test_feet_never_make_a_scan_in_metres_doubtful(across: float) -> None:
    assert decide_unit(across, "auto")[0] == "m"


@pytest.mark.parametrize(
    ("metres", "unit", "said"),
    [
        (0.73, "m", ""),
        (1.7, "mm", ""),
        (2.408, "m", "2.4 m across, more than scans usually show; check unit and export. In feet (0.734 m)"),
        (
            2.2,
            "mm",
            "Read in millimetres the body is 2.2 m across, more than scans usually show; check unit and export.",
        ),
        (0.4, "m", "less than scans usually show; check unit and export."),
    ],
)
def test_a_size_that_is_not_ordinary_is_said(metres: float, unit: str, said: str) -> None:
    doubt = size_doubt(metres, unit)
    assert said in doubt
    assert (doubt == "") == (said == "")
    assert doubt == "" or doubt.endswith(".")


def test_a_unit_that_is_known_is_not_doubted() -> None:
    """That of a label map, which may show one breast."""
    assert "In centimetres (1 m) it would be ordinary." in size_doubt(0.1, "mm")
    known = size_doubt(0.1, "mm", is_known=True)
    assert known.endswith("less than scans usually show; check unit and export.")

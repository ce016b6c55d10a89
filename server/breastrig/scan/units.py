"""The unit of a scan, decided from its size or checked against it.

A scan of a torso is 0.3 m (one breast region) to 2.6 m (with arms, head and a table) across.  That is less
than a factor of ten, so m, dm, cm and mm never fit together; inches overlap with cm and dm.  `auto` takes the
only unit that fits; between a metric unit and inches it takes the metric one only if that gives an ordinary
torso (0.45 to 1.7 m) and inches do not, and says so; else it asks.  Feet are three to a metre, so both would always
fit: they are thought of only where metres do not fit and feet give an ordinary torso while nothing else does.
"""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadScan, BadSettings, unknown_name
from breastrig.core.units import METRES_PER_UNIT, UNIT_CHOICES, UNIT_NAMES

PLAUSIBLE = (0.3, 2.6)  # m across: from one breast region to a torso with arms, head and table
ORDINARY = (0.45, 1.7)  # m across: a torso, standing or lying, with some of its table
ACCEPTED = (0.2, 4.0)  # m across: what a person may insist on, still less than a factor of 25 around a torso
STRAY = 0.005  # share of the points at each end of each axis that may be stray
SAMPLES = 20_000  # points looked at


def extent(vertices: Array) -> float:
    """Extent of (V, 3) vertices in their own unit: the diagonal of their bounding box, without outliers."""
    sample = vertices[:: max(1, len(vertices) // SAMPLES)]
    low, high = np.quantile(sample, [STRAY, 1.0 - STRAY], axis=0)
    return float(np.linalg.norm(high - low))


def decide_unit(across: float, asked: str, named: str | None = None, by_default: bool = False) -> tuple[str, str]:
    """(unit, sentence with the reason) for a scan that is `across` of its own units wide.

    `asked` is "auto" or a unit; `named` is the file's own, or that of its format for files that name none
    (`by_default`), and is taken where a torso can have this size in it.  Raises BadScan when the size fits no unit,
    several, or not the one asked for; BadSettings when `asked` is no unit.
    """
    if asked not in UNIT_CHOICES:
        raise BadSettings(unknown_name("unit", asked, UNIT_CHOICES))
    fitting = _fitting(across)
    if asked != "auto":
        return asked, _checked(across, asked, fitting)
    if named is not None:
        says = "names no unit, which means" if by_default else "says"
        if _within(across, named, PLAUSIBLE):
            return named, f"The scan is {across:.4g} units across; its file {says} {_name(across, named)}."
        unit, reason = decide_unit(across, asked)
        return unit, f"{reason} Its file {says} {_name(across, named)}, which no torso is."
    if len(fitting) == 1:
        unit = fitting[0]
        return unit, f"The scan is {across:.4g} units across, which fits a torso only in {_name(across, unit)}."
    metric = [unit for unit in fitting if unit not in ("in", "ft") and _within(across, unit, ORDINARY)]
    if len(metric) == 1 and not _within(across, "in", ORDINARY):
        return metric[0], (
            f"The scan is {across:.4g} units across, read as {_name(across, metric[0])}; "
            f"as {_name(across, 'in')} it would not be an ordinary torso."
        )
    if fitting:
        readings = " or ".join(_name(across, unit) for unit in fitting)
        raise BadScan(
            f"The scan is {across:.4g} units across, which could be {readings}; "
            f"say which with units {' or '.join(fitting)}."
        )
    raise BadScan(
        f"The scan is {across:.4g} units across, which is no torso in any unit; "
        "check the export, or give units (m, dm, cm, mm, in or ft) if the scan is right."
    )


def size_doubt(metres: float, unit: str, is_known: bool = False) -> str:
    """A sentence for a scan whose size (m) in this unit no ordinary torso has; empty where one has it.

    Where the unit `is_known`, as that of label maps, no other unit is suggested.
    """
    low, high = ORDINARY
    if low <= metres <= high:
        return ""
    across = metres / METRES_PER_UNIT[unit]
    others = [other for other in METRES_PER_UNIT if other != unit and _within(across, other, ORDINARY)]
    others = [] if is_known else others
    instead = f" In {' or '.join(_name(across, other) for other in others)} it would be ordinary." if others else ""
    compared = "more than scans usually show" if metres > high else "less than scans usually show"
    return f"Read in {UNIT_NAMES[unit]} the body is {metres:.2g} m across, {compared}; check unit and export.{instead}"


def _fitting(across: float) -> list[str]:
    """The units in which this is plausible."""
    fitting = [unit for unit in METRES_PER_UNIT if unit != "ft" and _within(across, unit, PLAUSIBLE)]
    doubtful = "m" not in fitting and not any(_within(across, unit, ORDINARY) for unit in fitting)
    return [*fitting, "ft"] if doubtful and _within(across, "ft", ORDINARY) else fitting


def _checked(across: float, asked: str, fitting: list[str]) -> str:
    if _within(across, asked, ACCEPTED):
        return f"Units were given: {_name(across, asked)} across."
    advice = f"units {' or '.join(fitting)} would fit" if fitting else "no unit fits, check the export"
    raise BadScan(f"In {UNIT_NAMES[asked]} this scan is {_metres(across, asked)} across, which is no torso; {advice}.")


def _within(across: float, unit: str, limits: tuple[float, float]) -> bool:
    return limits[0] <= across * METRES_PER_UNIT[unit] <= limits[1]


def _metres(across: float, unit: str) -> str:
    return f"{across * METRES_PER_UNIT[unit]:.3g} m"


def _name(across: float, unit: str) -> str:
    return f"{UNIT_NAMES[unit]} ({_metres(across, unit)})"

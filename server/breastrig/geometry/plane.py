"""A plane in space."""

from dataclasses import dataclass

from breastrig.core.arrays import Array


@dataclass(frozen=True, eq=False)
class Plane:
    """All points p with normal · p = height."""

    normal: Array  # (3,) unit
    height: float  # m, along the normal

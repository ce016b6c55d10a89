"""Robust weights for iteratively reweighted least squares: w(r) multiplies r², r in units of its scale.

Huber keeps far pairs with bounded pull; Geman-McClure and Tukey let them go.
"""

from collections.abc import Callable
from types import MappingProxyType

import numpy as np

from breastrig.core.arrays import Array


def huber(r: Array) -> Array:
    """1 inside |r| <= 1, then 1/|r|."""
    return np.asarray(1.0 / np.maximum(np.abs(r), 1.0))


def geman_mcclure(r: Array) -> Array:
    """1 / (1 + r²)²."""
    return np.asarray(1.0 / (1.0 + r * r) ** 2)


def tukey(r: Array) -> Array:
    """(1 − r²)² inside |r| < 1, else 0."""
    return np.asarray(np.where(np.abs(r) < 1.0, (1.0 - r * r) ** 2, 0.0))


def none(r: Array) -> Array:
    """Plain least squares."""
    return np.ones_like(r)


KERNELS: MappingProxyType[str, Callable[[Array], Array]] = MappingProxyType(
    {"none": none, "huber": huber, "geman_mcclure": geman_mcclure, "tukey": tukey}
)

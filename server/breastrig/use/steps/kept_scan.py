"""One reading of a scan for many tasks: what was cleaned and indexed stays, where a process serves one scan alone.

A process does so when it is called by `keeping`; elsewhere nothing is kept.  What is kept serves a scan that has the
very same vertices and triangles, compared number by number, so that a result never depends on what was kept.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.prepare_scan import PreparedScan, prepared
from breastrig.geometry.plane import Plane
from breastrig.scan.clean import Surface, clean
from breastrig.scan.orient import LABEL_MAP_FRAME, Frame
from breastrig.scan.scan import Scan


@dataclass
class _Kept:
    """The cached data of the last scan."""

    keeps: bool = False
    read: tuple[Array, Integers] | None = None  # the scan's own vertices and triangles
    surface: Surface | None = None  # of these
    target: ScanTarget | None = None  # with all that was built on it


_kept = _Kept()


def keeping(function: Callable[..., Any], *given: Any) -> Any:
    """The function's result, in a process that from now on caches the data of one scan."""
    _kept.keeps = True
    return function(*given)


def prepared_scan(scan: Scan, stance: str, frame: Frame | None = None) -> PreparedScan:
    """The scan cleaned and prepared (see fitting/prepare_scan.py).  Raises BadScan with a sentence."""
    ready = prepared(_cleaned(scan), stance, frame or (LABEL_MAP_FRAME if scan.from_label_map else None))
    if not _kept.keeps:
        return ready
    if _kept.target is None or not _same_target(_kept.target, ready.target):
        _kept.target = ready.target
    return replace(ready, target=_kept.target)


def _cleaned(scan: Scan) -> Surface:
    if not _kept.keeps:
        return clean(scan)
    read = (scan.vertices, scan.faces)
    before = _kept.read
    same = before is not None and all(np.array_equal(*both) for both in zip(before, read, strict=True))
    if _kept.surface is None or not same:
        _kept.surface, _kept.target = clean(scan), None
        _kept.read = read
    return _kept.surface


def _same_target(one: ScanTarget, other: ScanTarget) -> bool:
    return (
        _same_plane(one.table, other.table)
        and one.use_rays == other.use_rays
        and (one.vertices is other.vertices or np.array_equal(one.vertices, other.vertices))
        and (one.faces is other.faces or np.array_equal(one.faces, other.faces))
    )


def _same_plane(one: Plane | None, other: Plane | None) -> bool:
    if one is None or other is None:
        return one is other
    return np.array_equal(one.normal, other.normal) and one.height == other.height

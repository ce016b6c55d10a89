"""What a fit and the reading of an upload are asked, as plain values that travel between processes.

They stand apart from the numerics that carry them out: who only hands a job on loads none of them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from breastrig.core.stances import AUTO

DEFAULT = "default"  # the preset
FIRST = "first"  # as a drawing: the first one of the rig, none where it has none


@dataclass(frozen=True)
class EarlierFit:
    """A fit of the same scan: its stance, and its last pose as glTF nodes, in the scan's frame (m)."""

    stance: str
    nodes: list[dict[str, Any]]
    model_sha256: str  # of the rig whose nodes they are


@dataclass(frozen=True, kw_only=True)
class FitSettings:
    """What is asked of a fit, whatever scan it is asked of."""

    stance: str = AUTO
    preset: str | Mapping[str, Any] = DEFAULT  # a name, a TOML file, or a document (fitting/recipe.py)
    drawing: str | None = FIRST  # see drawings/patterns.py: names, patterns with parameters, joined by +
    landmark_confidence: dict[str, float] = field(default_factory=dict)  # 0 to 1, of proposed ones; absent: 1
    certain: tuple[str, ...] = ()  # picks that are followed whatever all else says
    refine: bool = True  # a free-form layer on top, which follows the skin that the scan shows
    earlier: EarlierFit | None = None  # None: the start is found from landmarks and scan
    locked: tuple[str, ...] = ()  # blocks of the unknowns that stay where they start (rig/blocks.py)
    orientation: dict[str, Any] | None = None  # of the scan, found at its upload; see fitting/scan_orientation.py


@dataclass(frozen=True)
class FitJob(FitSettings):
    """A fit from files to files."""

    scan: Path
    out: Path
    landmarks_mm: dict[str, list[float]]  # name -> x y z in the scan's frame, millimetres whatever the scan's unit
    units: str = "auto"
    file_type: str | None = None  # None: from the content
    model: Path | None = None  # None: the torso of the package
    cuts: tuple[dict[str, Any], ...] = ()  # by hand, see scan/hand_cuts.py


@dataclass(frozen=True)
class UploadJob:
    """An upload to be read."""

    scan: Path  # the uploaded bytes; the suffix gives the type
    units: str
    kept: Path  # where the scan itself is written, as a STORED file
    mesh: Path  # where the mesh for display is written
    thumbnail: Path  # where a small picture is written
    triangles: int  # at most
    model: Path | None = None  # that the service fits with; None: the torso of the package

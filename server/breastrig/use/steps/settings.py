"""What a fit is asked for, as plain values that are sent between processes."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from breastrig.core.picks import Length
from breastrig.core.stances import AUTO
from breastrig.scan.volumes.answers import NOTHING_SAID, VolumeAnswers

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
    """The settings of a fit, independent of its scan."""

    stance: str = AUTO
    preset: str | Mapping[str, Any] = DEFAULT  # a name, a TOML file, or a document (fitting/recipe.py)
    drawing: str | None = FIRST  # see drawings/patterns.py: names, patterns with parameters, joined by +
    landmark_confidence: dict[str, float] = field(default_factory=dict)  # 0 to 1, of proposed ones; absent: 1
    certain: tuple[str, ...] = ()  # picks that are followed whatever all else says
    marks_mm: dict[str, list[float]] = field(default_factory=dict)  # as landmarks_mm, of any names
    open_names: bool = False  # landmarks of names that the model has not are marks
    length: Length | None = None  # that the scan is scaled to; None: it has its true size
    refine: bool = True  # a free-form layer on top, which follows the skin that the scan shows
    earlier: EarlierFit | None = None  # None: the start is found from landmarks and scan
    locked: tuple[str, ...] = ()  # blocks of the unknowns that stay where they start (rig/blocks.py)
    orientation: dict[str, Any] | None = None  # of the scan, found at its upload; see fitting/hypotheses.py


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
    prior: bytes | None = None  # a file of `breastrig cohort`
    answers: VolumeAnswers = NOTHING_SAID  # of a label map
    lesions: tuple[bytes, ...] = ()  # files of lesions that lie in the scan's image

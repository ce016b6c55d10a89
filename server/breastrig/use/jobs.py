"""Parameters of each task, as plain values that are sent between processes; loads none of the numerics."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from breastrig.core.identity import UNNAMED, Identity
from breastrig.core.stances import AUTO, Stance
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


@dataclass(frozen=True)
class PredictionJob:
    """A stance that was not scanned, from files to files."""

    fit: Path  # folder of a fit
    out: Path
    stance: Stance
    drawing: str | None = None  # that the fit was asked for
    model: Path | None = None  # None: the torso of the package


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
    answers: VolumeAnswers = NOTHING_SAID  # of a label map


@dataclass(frozen=True)
class ProposeJob:
    """A scan to be searched for landmarks."""

    scan: Path
    file_type: str
    units: str
    model: Path | None = None  # None: the torso of the package
    orientation: dict[str, Any] | None = None  # what the upload has found, see fitting/hypotheses.py
    cuts: tuple[dict[str, Any], ...] = ()  # by hand, see scan/hand_cuts.py


@dataclass(frozen=True)
class InkJob:
    """A scan to be searched for ink."""

    scan: Path
    file_type: str
    units: str


@dataclass(frozen=True)
class SkinJob:
    """Lines and places that are to be kept, which must lie on a scan's skin."""

    scan: Path
    file_type: str
    units: str
    shapes: tuple[dict[str, Any], ...]  # of breastrig/drawing@1, mm


@dataclass(frozen=True)
class SnapshotJob:
    """The contents of a share link to a fit, as it is now."""

    fit: Path  # folder of a fit
    plan: dict[str, Any]  # on its scan, as `service/plans.py` gives it
    items: tuple[dict[str, Any], ...]  # of the plan itself
    identity: Identity  # on the pages of the report; without the patient's code
    out: Path  # folder for the files
    scan: Path | None = None  # as it is stored, where its colours are shown
    file_type: str = ""  # of that file
    shows_scan: bool = False  # else the model alone
    has_notes: bool = False  # of the plan
    cuts: tuple[dict[str, Any], ...] = ()  # by hand, see scan/hand_cuts.py
    model: Path | None = None  # None: the torso of the package


@dataclass(frozen=True)
class TransferJob:
    """A drawing on the scan of one fit, wanted on that of another."""

    from_fit: Path  # folder of a fit
    to_fit: Path
    drawing: (
        dict[str, Any] | None
    )  # a document breastrig/drawing@1 or breastrig/plan@1; None: the drawing that the first fit left
    other_patient: bool = False  # the scans are of two patients: the model decides which skin is which
    model: Path | None = None  # None: the torso of the package
    same_patient: bool = False  # a person has said that the drawing is this patient's, whatever its file says
    one_patient: bool = False  # and that both scans are of one, whatever their bodies say


@dataclass(frozen=True)
class PlannedFit:
    """The fit of a scan that a plan names."""

    folder: Path
    scan: str = ""  # as the plan's items name it; empty: found by the plan's table of scans, or by the stance
    one_patient: bool = False  # a person has said that this scan and the job's are, whatever their bodies say


@dataclass(frozen=True)
class PlanJob:
    """A plan to be laid on a scan."""

    plan: dict[str, Any]  # a document breastrig/plan@1, or breastrig/drawing@1
    fit: PlannedFit
    others: tuple[PlannedFit, ...] = ()  # of the same patient's other scans, where items were made
    model: Path | None = None  # None: the torso of the package


PlanLines = tuple[dict[str, Any], bool]  # a document breastrig/drawing@1 on the fit's scan


@dataclass(frozen=True)
class ChecksJob:
    """A fit whose landmarks may be checked."""

    fit: Path  # folder of a fit
    plan: PlanLines | None = None  # its lines, and whether they are all that is wanted; None: the fit's own drawing
    model: Path | None = None  # None: the torso of the package


@dataclass(frozen=True)
class ReportJob:
    """A report of one fit or of two."""

    fit: Path  # folder of a fit
    other: Path | None = None  # of the same patient in another stance
    model: Path | None = None  # None: the torso of the package
    plans: tuple[PlanLines | None, ...] = ()  # of each fit: its lines, and whether they are all that is wanted
    plan: dict[str, Any] | None = None  # or the plan itself (breastrig/plan@1 or drawing@1), to be laid on each scan
    same_patient: bool = False  # a person has said that plan and scans are one patient's, whatever file and bodies say
    one_patient: bool = False  # that was said of these two scans, and is remembered: no doubt is left
    items: tuple[dict[str, Any], ...] = ()  # of the plan of which `plans` are the lines
    identity: Identity = UNNAMED
    doubts: tuple[str, ...] = ()  # whether both fits are of one patient
    cuts: tuple[tuple[dict[str, Any], ...], ...] = ()  # of each fit's scan, made by hand: what is not shown any more


@dataclass(frozen=True)
class LiveQuestion:
    """A pattern that follows a hand; places are mm in the scan's frame."""

    name: str
    parameters: Mapping[str, float | str]
    side: str | None = None  # L, R: that one alone
    handle: str | None = None  # which is dragged
    to_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class LengthsQuestion:
    """The request for lengths along the skin, from each place to the next; mm in the scan's frame."""

    places_mm: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True)
class FollowJob:
    """The fit to go on from when landmarks are moved: its own job with `earlier`, and the picks that it left out."""

    fit: FitJob
    not_followed: tuple[str, ...]

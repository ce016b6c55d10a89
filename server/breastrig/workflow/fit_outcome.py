"""What is known at the end of a fit, in memory: what its files, a report or a program's `Fit` are made from."""

from collections.abc import Mapping
from dataclasses import dataclass

from breastrig.colour.areolae import ObservedAreola
from breastrig.core.arrays import Array
from breastrig.correspondence.distances import SurfaceDistances
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.observed.landmarks import ObservedLandmark
from breastrig.fitting.task import Doubt
from breastrig.fitting.uncertainty.radii import Radii
from breastrig.fitting.verdicts.verdict import Verdict
from breastrig.geometry.polyline import Polyline
from breastrig.least_squares.newton import Status
from breastrig.rig.model import ModelDrawing, Rig
from breastrig.rig.parameters import RigParameters
from breastrig.scan.scan import Scan
from breastrig.workflow.events import Iterated


@dataclass(frozen=True, eq=False)
class ModelAlone:
    """The rig as its bones and shapes have it, without the free-form layer."""

    vertices: Array  # (V, 3) m, in the scan's frame
    distances: SurfaceDistances


@dataclass(frozen=True, eq=False)
class FitOutcome:
    """All that is known at the end of a fit; parameters are in the scan's frame, metres."""

    scan: Scan
    target: ScanTarget  # the cleaned scan
    rig: Rig
    stance: str
    stance_reason: str
    preset: str
    parameters: RigParameters
    vertices: Array  # (V, 3) m, the fitted surface in the scan's frame, refined or not
    refined: bool
    model_alone: ModelAlone
    history: tuple[RigParameters, ...]
    times_s: tuple[float, ...]
    log: tuple[Iterated, ...]
    status: Status
    timing_s: dict[str, float]
    distances: SurfaceDistances
    landmarks: dict[str, Array]  # picked, m
    seen: Mapping[str, ObservedLandmark]  # by name, from colours, with radii of their own
    doubts: tuple[Doubt, ...]  # picks that are asked about
    drawing: ModelDrawing | None
    drawing_missing: tuple[str, ...]  # of each pattern that does not fit on this patient why, a sentence or two
    lines: tuple[Polyline, ...]
    radii: Radii | None  # None: nothing is known of this model's errors
    agreed: tuple[str, ...]  # landmarks that were proposed and only agreed to
    notes: tuple[str, ...]
    verdict: Verdict
    areolae: Mapping[str, ObservedAreola | None]  # by side, None where none is seen; empty for a scan without texture
    covariance: Array  # (P, P) of a step from the parameters (fitting/posterior.py)
    table_triangles: int  # of the scan, cut away as table
    cut_away: float = 0.0  # m², of the scan's floors and walls

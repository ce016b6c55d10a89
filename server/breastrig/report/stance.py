"""One fitted stance of a patient: all that measures, pictures and exports look at.

Everything is in one frame, the scan's, in metres; where it came from (a folder, a service, a test) does not matter.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from breastrig.colour.areolae import ObservedAreola
from breastrig.core.arrays import Array, Integers
from breastrig.correspondence.distances import signed_distances
from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.polyline import Polyline
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import DrawnShape, Rig


@dataclass(frozen=True, eq=False)
class Stance:
    """V model vertices, S scan vertices."""

    rig: Rig
    vertices: Array  # (V, 3) m, the fitted model
    scan_vertices: Array  # (S, 3) m, cleaned
    scan_faces: Integers  # (G, 3)
    name: str  # standing | supine | prone
    picked: dict[str, Array] = field(default_factory=dict)  # (3,) m, landmarks that were picked and not doubted
    seen: dict[str, Array] = field(default_factory=dict)  # (3,) m, landmarks that the scan's colours show
    lines: tuple[Polyline, ...] = ()  # on the scan; with errors where they were transferred there
    banded: tuple[Polyline, ...] = ()  # the same with all errors that are known: what the pictures show bands of
    landmark_radii: Mapping[str, float] = field(default_factory=dict)  # m; 90 % of true places are within
    joint: tuple[tuple[str, ...], Array] | None = None  # L landmarks and (3 L, 3 L) m² of the model's errors there
    areolae: Mapping[str, ObservedAreola | None] = field(default_factory=dict)  # by side; None: not seen
    predicted: bool = False  # computed: the scan's vertices are those of another stance, moved, and no scan of this one
    radii: Array | None = None  # (V,) m, likewise of the vertices; None: not known

    @cached_property
    def search(self) -> ClosestPointSearch:
        """The fitted surface, ready for closest points."""
        return ClosestPointSearch(self.vertices, self.rig.faces)

    @cached_property
    def distances(self) -> Array:
        """(V,) m, above zero where the model lies outside the scan's skin; nan where the scan shows nothing."""
        return signed_distances(ScanTarget(self.scan_vertices, self.scan_faces), self.vertices, self.rig.faces)

    def radius_at(self, points: Array) -> float | None:
        """m, the largest of the (M, 3) m points' radii; None where they are not known."""
        if self.radii is None:
            return None
        at = self.on_model(points)
        return float(np.max(at.positions(self.radii[:, None], self.rig.faces)))

    def on_model(self, points: Array) -> SurfacePoints:
        """The points of the fitted surface closest to (M, 3) m points."""
        return self.search.query(points).on_mesh

    def shape(self, *names: str) -> DrawnShape | None:
        """The first of the named shapes that a drawing of the model has."""
        shapes = {shape.name: shape for drawing in self.rig.drawings for shape in drawing.shapes}
        return next((shapes[name] for name in names if name in shapes), None)


MODEL = "model"  # source of a place


@dataclass(frozen=True, eq=False)
class Place:
    """A landmark's location on this patient, with its source."""

    name: str
    point: Array  # (3,) m
    source: str  # picked | seen | model
    radius: float | None = None  # m; holds the true place with 90 %; None: not known

    def __str__(self) -> str:
        return f"{self.name} ({self.source})"


def places(stance: Stance) -> dict[str, Place]:
    """Every landmark of the rig.

    As picked where it was picked and not doubted, as seen where the scan's colours show it, else the fitted model's.
    """
    rig = stance.rig
    model = dict(zip(rig.landmark_names, rig.landmark_points().positions(stance.vertices, rig.faces), strict=True))
    found = {}
    for name in rig.landmark_names:
        said = (("picked", stance.picked), ("seen", stance.seen), (MODEL, model))
        source, point = next((source, points[name]) for source, points in said if name in points)
        found[name] = Place(name, np.asarray(point), source, stance.landmark_radii.get(name))
    return found

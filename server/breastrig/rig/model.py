"""The rig as a frozen bag of data: template, blendshapes, bones, joints, weights, landmarks.

Nothing here knows how the data came about (gltf/read_model.py reads it) or what is done with it
(skinning.py poses it).  Any rig in this form fits without a code change.

Bone frames.  Bone j has a rest frame: origin o_j and rotation Q_j (columns: its local axes in body
coordinates).  A vertex b of the shaped template is carried to

    R_j S_j Q_jᵀ (b − o_j) + T_j

with the bone's absolute rotation R_j, translation T_j and local scale S_j = diag(s_j); at rest
R_j = Q_j, T_j = o_j, s_j = 1, which is the identity.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np

from breastrig.core.arrays import Array, Integers, frozen
from breastrig.geometry.normals import VertexNormals
from breastrig.geometry.surface_points import ChordalDeviation, SurfacePoints

Skinning = Literal["linear", "dual_quaternion", "corrective"]  # how bones' motions are blended (skinning.py)


@dataclass(frozen=True, eq=False)
class Bone:
    """A rigid body with a scale for each local axis."""

    name: str
    parent: int | None  # index of the parent bone (parents come first); None for the root
    origin: Array  # (3,) m, o_j, body frame at rest
    rotation: Array  # (3, 3), Q_j, columns are the local axes at rest
    scale_min: Array  # (3,) smallest allowed scale per local axis
    scale_max: Array  # (3,) largest allowed scale per local axis
    mirror: str  # name of the bone on the other side, its own name when it lies in the middle


LEAST_GAP = 1e-5  # m, of a joint: nobody can tell 0.01 mm from none, and a smaller size drowns the rest in rounding


@dataclass(frozen=True, eq=False)
class Joint:
    """A point rigidly attached to the two scalable bones that it links."""

    parent: int  # bone index
    child: int  # bone index
    anchor: Array  # (3,) m, body frame at rest
    rotation_sigma: float  # rad, expected size of the relative rotation between two patients or stances
    translation_sigma: float  # m, expected gap of the joint; a fit takes at least LEAST_GAP
    rotation_limit: float  # rad, largest allowed relative rotation


@dataclass(frozen=True, eq=False)
class Shape:
    """Properties of one blendshape besides its displacements."""

    name: str
    kind: str  # "body": the same in every stance; "soft": soft tissue, differs by stance; "gravity": supine only
    min: float  # smallest allowed weight
    max: float  # largest allowed weight
    sigma: float  # expected size of the weight over patients
    mirror: str  # name of the shape on the other side, its own name when symmetric
    label: str  # for people


@dataclass(frozen=True, eq=False)
class Corrective:
    """A shape that the turn of a joint drives: its weight is the product of φ_i to the power of p_i, i = x, y, z."""

    name: str
    joint: int  # index in the rig's joints; φ (rad) is its rotation vector from rest, in the body's axes at rest
    powers: tuple[int, int, int]
    moves: Array  # (V, 3) m for weight 1


@dataclass(frozen=True, eq=False)
class Landmark:
    """A named anatomical point on the skin."""

    name: str
    label: str  # short name for people
    latin: str
    definition: str  # how to find it, one sentence
    easy: bool  # easy to see on an untextured scan
    mirror: str
    face: int
    barycentric: Array  # (3,)


@dataclass(frozen=True)
class Length:
    """A distance that is measured on every body: between two landmarks, on both sides where one of them has sides."""

    name: str
    label: str  # for people
    start: str  # a landmark, without its side where there are two
    end: str


@dataclass(frozen=True, eq=False)
class DrawnShape:
    """One polyline that lies on the model."""

    name: str
    label: str
    closed: bool
    color: str  # "#rrggbb"
    points: SurfacePoints
    corners: tuple[int, ...] = ()  # indices of points at which the line turns sharply; they and the ends stay


@dataclass(frozen=True, eq=False)
class ModelDrawing:
    """A named set of polylines on the model, a data file beside the rig."""

    name: str
    label: str
    shapes: tuple[DrawnShape, ...]


@dataclass(frozen=True, eq=False)
class Rig:
    """V vertices, F faces, B bones, S shapes."""

    name: str
    template: Array  # (V, 3) m, rest pose, +X patient's left, +Y head, +Z front
    faces: Integers  # (F, 3) counter-clockwise seen from outside
    uv: Array  # (V, 2)
    blendshapes: Array  # (S, V, 3) m for weight 1
    skin_weights: Array  # (V, B) rows sum to 1, at most four non-zero
    bones: tuple[Bone, ...]
    joints: tuple[Joint, ...]
    shapes: tuple[Shape, ...]
    landmarks: tuple[Landmark, ...]
    drawings: tuple[ModelDrawing, ...]
    mirror_vertices: Integers  # (V,) vertex on the other side
    regions: dict[str, Integers]  # named vertex sets, for instance breast_L
    sha256: str  # of the .glb and its side file
    lengths: tuple[Length, ...] = ()
    skinning: Skinning = "linear"
    correctives: tuple[Corrective, ...] = ()  # of "corrective" skinning
    known: Mapping[str, str] = field(default_factory=dict)  # what has been estimated for it, see known.py

    def __post_init__(self) -> None:
        for name in ("template", "uv", "blendshapes", "skin_weights"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        for name in ("faces", "mirror_vertices"):
            object.__setattr__(self, name, frozen(getattr(self, name), np.int64))

    @cached_property
    def with_correctives_as_shapes(self) -> "Rig":
        """The rig with its correctives as ordinary shapes, as viewers have it; their weights are computed
        (skinning.py)."""
        if not self.correctives:
            return self
        moves = np.concatenate([self.blendshapes, [each.moves for each in self.correctives]])
        shapes = [Shape(each.name, "pose", 0.0, 0.0, 1.0, each.name, each.name) for each in self.correctives]
        return replace(self, blendshapes=moves, shapes=(*self.shapes, *shapes), skinning="linear", correctives=())

    @cached_property
    def bone_names(self) -> tuple[str, ...]:
        return tuple(bone.name for bone in self.bones)

    @cached_property
    def shape_names(self) -> tuple[str, ...]:
        return tuple(shape.name for shape in self.shapes)

    @cached_property
    def landmark_names(self) -> tuple[str, ...]:
        return tuple(landmark.name for landmark in self.landmarks)

    @cached_property
    def drawing_names(self) -> tuple[str, ...]:
        return tuple(drawing.name for drawing in self.drawings)

    @cached_property
    def rest_rotations(self) -> Array:
        """(B, 3, 3): Q_j."""
        return np.array([bone.rotation for bone in self.bones])

    @cached_property
    def rest_origins(self) -> Array:
        """(B, 3) m: o_j."""
        return np.array([bone.origin for bone in self.bones])

    @cached_property
    def shapes_by_vertex(self) -> Array:
        """(V, 3, S) m: the blendshapes laid out for the Jacobian's inner loop."""
        return np.ascontiguousarray(self.blendshapes.transpose(1, 2, 0))

    @cached_property
    def rest_axes(self) -> tuple[Array, Array]:
        """(3B, 3) and (3B, 1) m: takes a place to its coordinates in all rest frames, axis by axis; for that loop."""
        axes = self.rest_rotations.transpose(2, 0, 1).reshape(-1, 3)
        return axes, np.einsum("bij,bi->jb", self.rest_rotations, self.rest_origins).reshape(-1, 1)

    @cached_property
    def weights_by_bone(self) -> Array:
        """(B, V): the skin weights laid out for the same loop."""
        return np.ascontiguousarray(self.skin_weights.T)

    @cached_property
    def main_bones(self) -> Integers:
        """(V,) the bone that moves each vertex most."""
        return np.asarray(self.skin_weights.argmax(axis=1))

    @cached_property
    def normals_at(self) -> VertexNormals:
        """Takes (V, 3) m vertices to their unit (V, 3) normals."""
        return VertexNormals(self.faces, len(self.template))

    @cached_property
    def chordal_deviation_at(self) -> ChordalDeviation:
        """Takes (V, 3) m vertices and their normals to how far the triangles around each lie below the skin, (V,) m."""
        return ChordalDeviation(self.template, self.faces)

    def has_landmarks(self, names: Iterable[str]) -> bool:
        """Whether it has each of these landmarks, under its name or on both sides."""
        known = {*self.landmark_names}
        return all(name in known or {f"{name}_L", f"{name}_R"} <= known for name in names)

    def landmark_points(self, names: tuple[str, ...] | None = None) -> SurfacePoints:
        """The surface points of the named landmarks (all by default), in the given order."""
        by_name = {landmark.name: landmark for landmark in self.landmarks}
        chosen = [by_name[name] for name in (names or self.landmark_names)]
        return SurfacePoints(
            np.array([landmark.face for landmark in chosen], dtype=np.int64),
            np.array([landmark.barycentric for landmark in chosen], dtype=np.float64).reshape(-1, 3),
        )

"""The JSON beside the mesh: what glTF has no word for (limits, joints, landmarks, symmetry, drawings).

Pydantic says what a file must hold; unknown keys are kept out of the way, so that a newer file or somebody's
own remarks do not break the reading.  Faces and vertices are indices into the .glb's mesh.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, NonNegativeFloat, NonNegativeInt, PositiveFloat

from breastrig.rig.model import Skinning

RIG_SCHEMA = "breastrig/rig@1"
DRAWING_SCHEMA = "breastrig/drawing@1"

Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=64)]
Triple = Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]
Power = Annotated[int, Field(ge=0, le=6)]
PositiveTriple = Annotated[list[PositiveFloat], Field(min_length=3, max_length=3)]


class FilePart(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True, allow_inf_nan=False, defer_build=True)


class Units(FilePart):
    length: Literal["m"] = "m"
    angle: Literal["rad"] = "rad"


class BoneEntry(FilePart):
    name: Name
    parent: Name | None
    scale_min: PositiveTriple
    scale_max: PositiveTriple
    mirror: Name


class JointEntry(FilePart):
    parent: Name
    child: Name
    anchor: Triple
    rotation_sigma: PositiveFloat
    translation_sigma: NonNegativeFloat
    rotation_limit: PositiveFloat


class ShapeEntry(FilePart):
    name: Name
    label: str
    kind: Literal["body", "soft", "gravity"]
    min: FiniteFloat
    max: FiniteFloat
    sigma: PositiveFloat
    mirror: Name


class CorrectiveEntry(FilePart):
    name: Name
    joint: Name  # its child bone
    powers: tuple[Power, Power, Power]


class SurfacePointEntry(FilePart):
    face: NonNegativeInt
    barycentric: Triple


class LandmarkEntry(FilePart):
    name: Name
    label: str
    latin: str
    definition: str
    easy: bool
    mirror: Name
    face: NonNegativeInt
    barycentric: Triple


class LengthEntry(FilePart):
    name: Name
    label: str
    start: Name = Field(alias="from")  # a landmark, without its side where there are two
    end: Name = Field(alias="to")


class Symmetry(FilePart):
    vertices: list[NonNegativeInt]


class RigFile(FilePart):
    """torso.json."""

    schema_: Literal["breastrig/rig@1"] = Field(alias="schema")
    name: Name
    license: str = ""
    units: Units = Units()
    up: Literal["+Y"] = "+Y"
    front: Literal["+Z"] = "+Z"
    skinning: Skinning = "linear"
    correctives: list[CorrectiveEntry] = []
    bones: list[BoneEntry] = Field(min_length=1)
    joints: list[JointEntry]
    shapes: list[ShapeEntry]
    landmarks: list[LandmarkEntry]
    lengths: list[LengthEntry] = []
    drawings: list[Name] = []  # the first is what a fit draws when it is not asked; those not named follow by name
    regions: dict[str, list[NonNegativeInt]] = {}
    symmetry: Symmetry
    provenance: dict[str, Any] = {}


class DrawnShapeEntry(FilePart):
    name: Name
    label: str = ""
    closed: bool = False
    color: str = Field("#101010", pattern=r"^#[0-9a-fA-F]{6}$")
    surface_points: list[SurfacePointEntry] = Field(min_length=1)
    corners: list[NonNegativeInt] = []


class DrawingFile(FilePart):
    """drawings/<name>.json."""

    schema_: Literal["breastrig/drawing@1"] = Field(alias="schema")
    name: Name
    label: str = ""
    shapes: list[DrawnShapeEntry]

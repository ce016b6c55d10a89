"""The parts of a glTF 2.0 document that are written here, by the names of its specification.

Fields that are None or empty are left out of the JSON, in which keys stand in the order of the fields.  pygltflib
has classes for all of glTF; importing them takes a fifth of a second, writing a fit by them a tenth of one.  Methods
that nobody calls are not generated here, which would take time at every start as well.
"""

import json
from dataclasses import dataclass, field
from typing import Any

UNSIGNED_BYTE, UNSIGNED_SHORT, UNSIGNED_INT, FLOAT = 5121, 5123, 5125, 5126
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
LINEAR, LINEAR_MIPMAP_LINEAR, REPEAT = 9729, 9987, 10497
POINTS, LINE_LOOP, LINE_STRIP, TRIANGLES = 0, 2, 3, 4


@dataclass(eq=False, repr=False, match_args=False)
class Property:
    extensions: dict[str, Any] | None = None
    extras: dict[str, Any] | None = None


@dataclass(eq=False, repr=False, match_args=False)
class Asset(Property):
    generator: str | None = None
    version: str = "2.0"


@dataclass(eq=False, repr=False, match_args=False)
class Attributes:
    POSITION: int | None = None
    NORMAL: int | None = None
    TEXCOORD_0: int | None = None
    COLOR_0: int | None = None
    JOINTS_0: int | None = None
    WEIGHTS_0: int | None = None


@dataclass(eq=False, repr=False, match_args=False)
class Primitive(Property):
    attributes: Attributes = field(default_factory=Attributes)
    indices: int | None = None
    mode: int = TRIANGLES
    material: int | None = None
    targets: list[Attributes] = field(default_factory=list)


@dataclass(eq=False, repr=False, match_args=False)
class Mesh(Property):
    primitives: list[Primitive] = field(default_factory=list)
    name: str = ""


@dataclass(eq=False, repr=False, match_args=False)
class Accessor(Property):
    bufferView: int | None = None
    componentType: int | None = None
    normalized: bool | None = None
    count: int | None = None
    type: str | None = None
    max: list[float] | None = None
    min: list[float] | None = None


@dataclass(eq=False, repr=False, match_args=False)
class BufferView(Property):
    buffer: int | None = None
    byteOffset: int = 0
    byteLength: int | None = None
    target: int | None = None


@dataclass(eq=False, repr=False, match_args=False)
class Buffer(Property):
    uri: str | None = None
    byteLength: int = 0


@dataclass(eq=False, repr=False, match_args=False)
class TextureInfo(Property):
    index: int | None = None
    texCoord: int = 0


@dataclass(eq=False, repr=False, match_args=False)
class PbrMetallicRoughness(Property):
    baseColorFactor: list[float] | None = None
    metallicFactor: float = 1.0
    roughnessFactor: float = 1.0
    baseColorTexture: TextureInfo | None = None


@dataclass(eq=False, repr=False, match_args=False)
class Material(Property):
    pbrMetallicRoughness: PbrMetallicRoughness | None = None
    emissiveFactor: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    alphaMode: str = "OPAQUE"
    doubleSided: bool = False
    name: str = ""


@dataclass(eq=False, repr=False, match_args=False)
class Sampler(Property):
    magFilter: int | None = None
    minFilter: int | None = None
    wrapS: int = REPEAT
    wrapT: int = REPEAT


@dataclass(eq=False, repr=False, match_args=False)
class Node(Property):
    mesh: int | None = None
    skin: int | None = None
    rotation: list[float] | None = None
    translation: list[float] | None = None
    scale: list[float] | None = None
    children: list[int] = field(default_factory=list)
    name: str = ""
    weights: list[float] | None = None


@dataclass(eq=False, repr=False, match_args=False)
class Skin(Property):
    inverseBindMatrices: int | None = None
    skeleton: int | None = None
    joints: list[int] = field(default_factory=list)
    name: str = ""


@dataclass(eq=False, repr=False, match_args=False)
class Scene(Property):
    name: str = ""
    nodes: list[int] = field(default_factory=list)


@dataclass(eq=False, repr=False, match_args=False)
class Texture(Property):
    sampler: int | None = None
    source: int | None = None


@dataclass(eq=False, repr=False, match_args=False)
class Image(Property):
    mimeType: str | None = None
    bufferView: int | None = None


@dataclass(eq=False, repr=False, match_args=False)
class AnimationChannelTarget(Property):
    node: int | None = None
    path: str | None = None


@dataclass(eq=False, repr=False, match_args=False)
class AnimationSampler(Property):
    input: int | None = None
    interpolation: str = "LINEAR"
    output: int | None = None


@dataclass(eq=False, repr=False, match_args=False)
class AnimationChannel(Property):
    sampler: int | None = None
    target: AnimationChannelTarget | None = None


@dataclass(eq=False, repr=False, match_args=False)
class Animation(Property):
    name: str = ""
    channels: list[AnimationChannel] = field(default_factory=list)
    samplers: list[AnimationSampler] = field(default_factory=list)


@dataclass(eq=False, repr=False, match_args=False)
class Document(Property):
    accessors: list[Accessor] = field(default_factory=list)
    animations: list[Animation] = field(default_factory=list)
    asset: Asset = field(default_factory=Asset)
    bufferViews: list[BufferView] = field(default_factory=list)
    buffers: list[Buffer] = field(default_factory=list)
    extensionsUsed: list[str] = field(default_factory=list)
    images: list[Image] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    meshes: list[Mesh] = field(default_factory=list)
    nodes: list[Node] = field(default_factory=list)
    samplers: list[Sampler] = field(default_factory=list)
    scene: int | None = None
    scenes: list[Scene] = field(default_factory=list)
    skins: list[Skin] = field(default_factory=list)
    textures: list[Texture] = field(default_factory=list)

    def json(self) -> bytes:
        """The document, its buffers elsewhere; ValueError for a number that is not finite."""
        return json.dumps(_plain(self), separators=(",", ":"), allow_nan=False).encode()


def _plain(value: Any) -> Any:
    """Dictionaries and lists without what is None or empty; an extension may be empty."""
    if isinstance(value, list):
        return value if value and isinstance(value[-1], int | float) else [_plain(each) for each in value]
    if hasattr(value, "__dataclass_fields__"):
        entries = value.__dict__  # in the order of the fields
    elif isinstance(value, dict):
        entries = value
    else:
        return value
    return {
        name: each if name == "extensions" else _plain(each)
        for name, each in entries.items()
        if each is not None and not (isinstance(each, str | list | tuple | dict) and not each)
    }

"""The objects of a glTF document under the names of its specification, and their JSON.

Only what BreastRig writes is here.  Libraries have the rest too, but take a tenth of a second to load and a tenth of a
second to write a fit.  Fields stand in the order in which they are written; those that are None or empty are left out.
"""

import json
from dataclasses import dataclass, field
from typing import Any, TypeAlias

POINTS, LINE_LOOP, LINE_STRIP, TRIANGLES = 0, 2, 3, 4  # modes of primitives
UNSIGNED_BYTE, UNSIGNED_SHORT, UNSIGNED_INT, FLOAT = 5121, 5123, 5125, 5126  # types of numbers
LINEAR, LINEAR_MIPMAP_LINEAR, REPEAT = 9729, 9987, 10497  # filters and wrapping of textures
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963  # targets of buffer views

Attributes: TypeAlias = dict[str, int]  # accessors by what they mean: POSITION, NORMAL, ...


@dataclass(eq=False, repr=False, kw_only=True)
class Entry:
    """Any object of a document."""

    extensions: dict[str, Any] = field(default_factory=dict)
    extras: dict[str, Any] = field(default_factory=dict)


@dataclass(eq=False, repr=False, kw_only=True)
class Accessor(Entry):
    bufferView: int
    byteOffset: int | None = 0
    componentType: int
    normalized: bool | None = False
    count: int
    type: str
    max: list[Any] = field(default_factory=list)
    min: list[Any] = field(default_factory=list)


@dataclass(eq=False, repr=False, kw_only=True)
class AnimationChannelTarget(Entry):
    node: int
    path: str


@dataclass(eq=False, repr=False, kw_only=True)
class AnimationChannel(Entry):
    sampler: int
    target: AnimationChannelTarget


@dataclass(eq=False, repr=False, kw_only=True)
class AnimationSampler(Entry):
    input: int
    interpolation: str = "LINEAR"
    output: int


@dataclass(eq=False, repr=False, kw_only=True)
class Animation(Entry):
    name: str
    channels: list[AnimationChannel] = field(default_factory=list)
    samplers: list[AnimationSampler] = field(default_factory=list)


@dataclass(eq=False, repr=False, kw_only=True)
class Asset(Entry):
    generator: str = ""
    version: str = "2.0"


@dataclass(eq=False, repr=False, kw_only=True)
class Buffer(Entry):
    uri: str | None = None
    byteLength: int


@dataclass(eq=False, repr=False, kw_only=True)
class BufferView(Entry):
    buffer: int
    byteOffset: int = 0
    byteLength: int
    target: int | None = None


@dataclass(eq=False, repr=False, kw_only=True)
class Image(Entry):
    mimeType: str
    bufferView: int


@dataclass(eq=False, repr=False, kw_only=True)
class Sampler(Entry):
    magFilter: int
    minFilter: int
    wrapS: int = REPEAT
    wrapT: int = REPEAT


@dataclass(eq=False, repr=False, kw_only=True)
class Texture(Entry):
    sampler: int
    source: int


@dataclass(eq=False, repr=False, kw_only=True)
class TextureInfo(Entry):
    index: int
    texCoord: int = 0


@dataclass(eq=False, repr=False, kw_only=True)
class PbrMetallicRoughness(Entry):
    baseColorFactor: list[float] = field(default_factory=lambda: [1.0, 1.0, 1.0, 1.0])
    metallicFactor: float = 1.0
    roughnessFactor: float = 1.0
    baseColorTexture: TextureInfo | None = None


@dataclass(eq=False, repr=False, kw_only=True)
class Material(Entry):
    pbrMetallicRoughness: PbrMetallicRoughness | None = None
    emissiveFactor: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    alphaMode: str = "OPAQUE"
    doubleSided: bool = False
    name: str


@dataclass(eq=False, repr=False, kw_only=True)
class Primitive(Entry):
    attributes: Attributes
    indices: int | None = None
    mode: int = TRIANGLES
    material: int | None = None
    targets: list[Attributes] = field(default_factory=list)


@dataclass(eq=False, repr=False, kw_only=True)
class Mesh(Entry):
    primitives: list[Primitive]
    name: str


@dataclass(eq=False, repr=False, kw_only=True)
class Node(Entry):
    mesh: int | None = None
    skin: int | None = None
    rotation: list[float] | None = None
    translation: list[float] | None = None
    scale: list[float] | None = None
    children: list[int] = field(default_factory=list)
    name: str
    weights: list[float] | None = None


@dataclass(eq=False, repr=False, kw_only=True)
class Scene(Entry):
    nodes: list[int]


@dataclass(eq=False, repr=False, kw_only=True)
class Skin(Entry):
    inverseBindMatrices: int
    skeleton: int
    joints: list[int]
    name: str


@dataclass(eq=False, repr=False, kw_only=True)
class Document(Entry):
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


def json_of(document: Document) -> bytes:
    """The document, its buffers elsewhere; ValueError for a number that is not finite."""
    return json.dumps(_plain(document), separators=(",", ":"), allow_nan=False).encode()


_LEAVES = frozenset((bool, int, float, str))  # written as they are


def _plain(value: Any) -> Any:
    """Dictionaries and lists without what is None or empty; an extension may be empty."""
    kind = type(value)
    if kind is list:
        return value if value and type(value[-1]) in _LEAVES else [_plain(each) for each in value]
    entries = value if kind is dict else value.__dict__ if isinstance(value, Entry) else None
    if entries is None:
        return value
    result = {}
    for name, each in entries.items():
        if type(each) in _LEAVES:
            if each != "":
                result[name] = each
        elif each is not None and not (isinstance(each, list | tuple | dict) and not each):
            result[name] = each if name == "extensions" else _plain(each)
    return result

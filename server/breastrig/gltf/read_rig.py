"""torso.glb + torso.json + drawings/*.json -> Rig: ours, or anybody's in the same form.

The .glb gives what everyone's tools can edit (template, faces, uv, shapes, skin weights, rest frames), the
side file the rest; they meet by names.  Rest frames come from the inverse bind matrices, so the pose in which
the file was saved does not matter.  A joint node named `<bone>_scale` stands for its parent, the bone (our
layout, see pose_nodes.py); any other joint node is the bone itself.  This checks that the files agree;
`breastrig model check` judges whether the rig is a good one.
"""

import hashlib
import json
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError

from breastrig.core.arrays import Array, Integers, frozen
from breastrig.core.assets import packaged_models
from breastrig.core.errors import BadModel
from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays, entry
from breastrig.core.private_files import read_ordinary, shown
from breastrig.core.stances import split_side
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.gltf.known_files import known_paths, read_known
from breastrig.gltf.side_file import DrawingFile, FilePart, LandmarkEntry, RigFile, SurfacePointEntry
from breastrig.rig.model import Bone, Corrective, DrawnShape, Joint, Landmark, Length, ModelDrawing, Rig, Shape

TRIANGLES, FLOATS = 4, 5126  # as glTF numbers them
MODEL_BYTES = 500_000_000  # the torso has 2.5 million
ORTHONORMAL = 1e-4  # largest deviation of QᵀQ from the identity before a rest frame counts as scaled
UNIT_SUM = 1e-3  # largest deviation of skin and barycentric weights from 1 before they count as wrong
BONES_MOST = 255  # joint indices of one byte, as most exporters write them; the torso has nine
SHAPES_MOST = 1000  # unknowns of a fit: its normal equations are dense, and this many fill 8 MB; the torso has 55
MOVES_MOST = 20_000_000  # vertices times shapes, 0.5 GB; the torso has 0.13 million
HARMLESS: tuple[str, ...] = (
    "KHR_materials_",
    "EXT_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_punctual",
)
HARMLESS += ("KHR_mesh_quantization",)  # of normals and texture coordinates; positions are looked at
PLAIN = {  # what a rig's numbers may not be packed with, and how exporters leave it out
    "KHR_draco_mesh_compression": "it is compressed with Draco; export it again without compression (Blender: "
    'leave "Compression" under "Data" unticked)',
    "EXT_meshopt_compression": "it is compressed with meshopt; export it again without compression (gltfpack: "
    "without -c and -cc, with -noq)",
}
QUANTISED = (
    "its positions are quantised (KHR_mesh_quantization); export it again with 32-bit floats (gltfpack: with -noq; "
    "glTF-Transform: without quantize)"
)
PLAIN["KHR_meshopt_compression"] = PLAIN["EXT_meshopt_compression"]
BARYCENTRIC_OUTSIDE = 0.05  # how far a surface point may lie outside its triangle

File = TypeVar("File", bound=FilePart)


def default_rig_path() -> Path:
    """The default model's path: from the installed wheel, else from the source checkout."""
    return packaged_models()["torso"]


def read_rig(glb: Path) -> Rig:
    """Reads `glb`, .json and .known of the same name and drawings/*.json beside it; BadModel says what is wrong.

    Files that have not changed since they were read last are the same rig, with all that was derived from it.
    """
    drawings = tuple(sorted(glb.parent.glob("drawings/*.json")))
    stamps = tuple(_stamp(file) for file in (glb, glb.with_suffix(".json"), *drawings, *known_paths(glb)))
    return _read(glb, drawings, stamps) if all(stamps) else _read.__wrapped__(glb, drawings, stamps)


def unread_keys(glb: Path) -> list[str]:
    """Keys of the side file that nothing reads: remarks, or misspelled words."""
    try:
        RigFile.model_validate_json(_bytes(glb.with_suffix(".json")), extra="forbid")
    except ValidationError as error:
        return [".".join(map(str, each["loc"])) for each in error.errors(include_url=False, include_input=False)]
    return []


def _stamp(file: Path) -> tuple[int, ...] | None:
    """A value that changes when the file does; None when the file does not exist."""
    try:
        found = file.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns


@lru_cache(maxsize=4)  # of a process: the models of a service, and one that a test or a program tries beside them
def _read(glb: Path, drawing_paths: tuple[Path, ...], _stamps: tuple[tuple[int, ...] | None, ...]) -> Rig:
    files = {"glb": glb, "json": glb.with_suffix(".json")}
    data = {kind: _bytes(path) for kind, path in files.items()}
    drawings = [_bytes(path) for path in drawing_paths]
    side = _parsed(RigFile, data["json"], files["json"].name)
    try:
        mesh = _SkinnedMesh(*split_glb(data["glb"]))
    except (ValueError, KeyError, TypeError, IndexError, AttributeError, MemoryError) as error:
        raise BadModel(f"{glb.name} cannot be used as a model: {_reason(error)}.") from error
    sha256 = hashlib.sha256(b"".join([data["glb"], data["json"], *drawings])).hexdigest()
    rig = _assembled(
        side,
        mesh,
        tuple(
            _drawing(_parsed(DrawingFile, text, path.name), path.name, len(mesh.faces))
            for text, path in zip(drawings, drawing_paths, strict=True)
        ),
        sha256,
    )
    return replace(rig, known=read_known(glb, sha256))


class _SkinnedMesh:
    """The .glb's part, by names; ValueError with the end of a sentence."""

    def __init__(self, document: dict[str, Any], binary: bytes) -> None:
        _check_packing(document)
        arrays = GltfArrays(document, binary)
        nodes = document.get("nodes", [])
        found = [node for node in nodes if "mesh" in node and "skin" in node]
        meshes = {node["mesh"] for node in found}
        if len(meshes) != 1:
            raise ValueError(f"it needs exactly one mesh with a skin and has {len(meshes)}")
        mesh = entry(document, "meshes", found[0]["mesh"])
        if len(mesh["primitives"]) != 1:
            raise ValueError("its mesh has several materials, a model's mesh needs exactly one")
        primitive = mesh["primitives"][0]
        if primitive.get("mode", TRIANGLES) != TRIANGLES:
            raise ValueError("its mesh is not made of triangles")
        attributes = primitive["attributes"]
        if "JOINTS_1" in attributes:
            raise ValueError("its vertices hang on more than four bones, prune them to four")
        targets = primitive.get("targets", [])
        for place in (attributes, *targets):
            if "POSITION" in place and entry(document, "accessors", place["POSITION"]).get("componentType") != FLOATS:
                raise ValueError(QUANTISED)
        self.template: Array = arrays.read(attributes["POSITION"])
        count = len(self.template)
        _check_amount(count, len(targets))
        self.faces = self._faces(arrays, primitive)
        self.uv = arrays.read(attributes["TEXCOORD_0"]) if "TEXCOORD_0" in attributes else np.zeros((count, 2))
        self.shapes: list[Array] = [
            arrays.read(target["POSITION"]) if "POSITION" in target else np.zeros((count, 3)) for target in targets
        ]
        self.shape_names: list[str] = list((mesh.get("extras") or {}).get("targetNames", []))
        if len(self.shape_names) != len(self.shapes):
            raise ValueError(
                f"it has {len(self.shapes)} shapes but {len(self.shape_names)} names in mesh.extras.targetNames"
            )
        skin = entry(document, "skins", found[0]["skin"])
        joint_names = _joint_names(nodes, skin["joints"])
        self.bone_names = list(dict.fromkeys(joint_names))
        if len(self.bone_names) > BONES_MOST:
            raise ValueError(f"it has {len(self.bone_names)} bones, at most {BONES_MOST} can be fitted; merge some")
        bones = np.array([self.bone_names.index(name) for name in joint_names])
        self.skin_weights = self._weights(arrays, attributes, bones)
        binds = arrays.read(skin["inverseBindMatrices"]) if "inverseBindMatrices" in skin else None
        count_of_joints = len(joint_names)
        self.inverse_bind = np.tile(np.eye(4), (count_of_joints, 1, 1)) if binds is None else binds
        if len(self.inverse_bind) == count_of_joints:
            self.inverse_bind = self.inverse_bind[[joint_names.index(name) for name in self.bone_names]]
        self._check(count)

    def _faces(self, arrays: GltfArrays, primitive: dict[str, Any]) -> Integers:
        count = len(self.template)
        flat = arrays.read(primitive["indices"]) if "indices" in primitive else np.arange(count)
        if flat.ndim != 1 or flat.size == 0 or flat.size % 3 or flat.max() >= count:
            raise ValueError("its triangles are empty or name vertices that do not exist")
        return np.asarray(flat.reshape(-1, 3), np.int64)

    def _weights(self, arrays: GltfArrays, attributes: dict[str, Any], bones: Integers) -> Array:
        """`bones`: of each joint."""
        joints = arrays.read(attributes["JOINTS_0"])
        values = arrays.read(attributes["WEIGHTS_0"])
        if joints.shape != values.shape or joints.shape != (len(self.template), 4):
            raise ValueError("its skin weights do not fit its vertices")
        if joints.dtype.kind != "i" or joints.min() < 0 or joints.max() >= len(bones):
            raise ValueError("its skin weights name bones that do not exist")
        if not np.isfinite(values).all():
            raise ValueError(
                "its skin weights contain numbers that are not finite; normalise all weights and export it again"
            )
        if values.min() < 0 or np.abs(values.sum(axis=1) - 1.0).max() > UNIT_SUM:
            raise ValueError("the skin weights of its vertices do not sum to 1")
        weights = np.zeros((len(values), len(self.bone_names)))
        np.add.at(weights, (np.arange(len(values))[:, None], bones[joints]), values)
        return np.asarray(weights / weights.sum(axis=1, keepdims=True))

    def _check(self, count: int) -> None:
        shapes = {
            "positions": (self.template.shape, (count, 3)),
            "texture coordinates": (self.uv.shape, (count, 2)),
            "inverse bind matrices": (self.inverse_bind.shape, (len(self.bone_names), 4, 4)),
        }
        for what, (found, wanted) in shapes.items():
            if found != wanted:
                raise ValueError(f"its {what} have the shape {found} instead of {wanted}")
        for name, shape in zip(self.shape_names, self.shapes, strict=True):
            if shape.shape != (count, 3):
                raise ValueError(f'its shape "{name}" does not fit its vertices')
        for values in (self.template, self.uv, self.inverse_bind, *self.shapes):
            if not np.isfinite(values).all():
                raise ValueError("it contains numbers that are not finite")


def _check_packing(document: dict[str, Any]) -> None:
    """Raises ValueError for compressed or quantised data, or a required extension that is not supported."""
    used = [str(name) for key in ("extensionsRequired", "extensionsUsed") for name in document.get(key, [])]
    packed = next((name for name in PLAIN if name in used), None)
    if packed is not None:
        raise ValueError(PLAIN[packed])
    unread = [str(name) for name in document.get("extensionsRequired", []) if not str(name).startswith(HARMLESS)]
    if unread:
        raise ValueError(f"it needs the glTF extension {unread[0][:60]}, which is not read; export it without that")


def _check_amount(count: int, shapes: int) -> None:
    """Raises ValueError, before reading them, where the shapes are more than a fit can take."""
    most = min(SHAPES_MOST, MOVES_MOST // max(count, 1))
    if shapes > most:
        raise ValueError(
            f"it has {shapes} shapes, at most {most} can be fitted with {count} vertices; delete what is not needed"
        )


def _joint_names(nodes: list[dict[str, Any]], joints: list[int]) -> list[str]:
    """The bone of each joint.  Blender makes bones of all nodes, so that one and its `_scale` may both be joints."""
    parents = {child: index for index, node in enumerate(nodes) for child in node.get("children", [])}
    own = [nodes[joint].get("name", "") for joint in joints]
    if len(set(own)) != len(own):
        raise ValueError("two of its bones have the same name")
    above = [str(nodes[parents[joint]].get("name")) if joint in parents else "" for joint in joints]
    return [parent if parent and name == f"{parent}_scale" else name for name, parent in zip(own, above, strict=True)]


def _assembled(side: RigFile, mesh: _SkinnedMesh, drawings: tuple[ModelDrawing, ...], sha256: str) -> Rig:
    vertices, faces = len(mesh.template), len(mesh.faces)
    names = _unique("bone", [bone.name for bone in side.bones])
    _same_names("bone", names, mesh.bone_names, mesh.skin_weights)
    driven = [each.name for each in side.correctives]
    _same_names("shape", _unique("shape", [*(shape.name for shape in side.shapes), *driven]), mesh.shape_names)
    if bool(driven) != (side.skinning == "corrective"):
        raise BadModel('The side file says "skinning": "corrective" if and only if it lists correctives.')
    moves = dict(zip(mesh.shape_names, mesh.shapes, strict=True))
    shape_names = [name for name in mesh.shape_names if name not in driven]
    moved_by = [joint.child for joint in side.joints]
    _unique("landmark", [landmark.name for landmark in side.landmarks])
    _unique("drawing", [drawing.name for drawing in drawings])
    columns = [mesh.bone_names.index(name) for name in names]
    shapes = {shape.name: shape for shape in side.shapes}
    landmark_names = [landmark.name for landmark in side.landmarks]
    stems = {split_side(name)[0] for name in landmark_names}
    _unique("length", [length.name for length in side.lengths])
    for length in side.lengths:
        for end in (length.start, length.end):
            _known("landmark", end, [*landmark_names, *sorted(stems - set(landmark_names))])
    for landmark in side.landmarks:
        _check_point(landmark, faces, f'Landmark "{landmark.name}"')
        _known("landmark", landmark.mirror, landmark_names)
    return Rig(
        name=side.name,
        template=mesh.template,
        faces=mesh.faces,
        uv=mesh.uv,
        blendshapes=np.array([moves[name] for name in shape_names]).reshape(-1, vertices, 3),
        skin_weights=mesh.skin_weights[:, columns],
        bones=tuple(_bone(side, index, names, mesh.inverse_bind[columns[index]]) for index in range(len(names))),
        joints=tuple(
            Joint(
                **joint.model_dump(exclude={"parent", "child", "anchor"}),
                parent=_known("bone", joint.parent, names),
                child=_known("bone", joint.child, names),
                anchor=np.array(joint.anchor),
            )
            for joint in side.joints
        ),
        shapes=tuple(_shape(shapes, name, shape_names) for name in shape_names),
        landmarks=tuple(
            Landmark(**mark.model_dump(exclude={"barycentric"}), barycentric=np.array(mark.barycentric))
            for mark in side.landmarks
        ),
        drawings=_in_order(side.drawings, drawings),
        mirror_vertices=_indices(side.symmetry.vertices, vertices, "symmetry.vertices", vertices),
        regions={name: _indices(chosen, vertices, f"region {name}") for name, chosen in side.regions.items()},
        sha256=sha256,
        lengths=tuple(Length(**length.model_dump()) for length in side.lengths),
        skinning=side.skinning,
        correctives=tuple(
            Corrective(each.name, _known("joint", each.joint, moved_by), each.powers, frozen(moves[each.name]))
            for each in side.correctives
        ),
    )


def _bone(side: RigFile, index: int, names: list[str], inverse_bind: Array) -> Bone:
    bone = side.bones[index]
    parent = None if bone.parent is None else _known("bone", bone.parent, names)
    if parent is not None and parent >= index:
        raise BadModel(f'Bone "{bone.name}" stands before its parent "{bone.parent}"; list parents first.')
    turned = inverse_bind[:3, :3]
    if np.abs(turned @ turned.T - np.eye(3)).max() > ORTHONORMAL or np.linalg.det(turned) < 0:
        raise BadModel(
            f'The rest frame of bone "{bone.name}" is scaled or mirrored; apply the armature\'s scale before export.'
        )
    left, _, right = np.linalg.svd(turned)
    rotation = (left @ right).T  # the nearest rotation: float32 rounding is taken out
    if any(low > high for low, high in zip(bone.scale_min, bone.scale_max, strict=True)):
        raise BadModel(f'The scale limits of bone "{bone.name}" are the wrong way round.')
    _known("bone", bone.mirror, names)
    return Bone(
        name=bone.name,
        parent=parent,
        origin=-rotation @ inverse_bind[:3, 3],
        rotation=rotation,
        scale_min=np.array(bone.scale_min),
        scale_max=np.array(bone.scale_max),
        mirror=bone.mirror,
    )


def _shape(shapes: dict[str, Any], name: str, names: list[str]) -> Shape:
    shape = shapes[name]
    if shape.min > shape.max:
        raise BadModel(f'The range of shape "{name}" is the wrong way round.')
    _known("shape", shape.mirror, names)
    return Shape(**shape.model_dump())


def _in_order(names: list[str], drawings: tuple[ModelDrawing, ...]) -> tuple[ModelDrawing, ...]:
    """The drawings in the side file's order; those that it does not name follow by name."""
    known = [drawing.name for drawing in drawings]
    for name in _unique("drawing", names):
        _known("drawing", name, known)
    order = [*names, *sorted(set(known) - set(names))]
    return tuple(drawings[known.index(name)] for name in order)


def _drawing(drawing: DrawingFile, file: str, faces: int) -> ModelDrawing:
    for shape in drawing.shapes:
        for point in shape.surface_points:
            _check_point(point, faces, f'Shape "{shape.name}" of {file}')
        if any(corner >= len(shape.surface_points) for corner in shape.corners):
            raise BadModel(f'Shape "{shape.name}" of {file} has a corner at a point that it does not have.')
    _unique(f"shape of {file}", [shape.name for shape in drawing.shapes])
    return ModelDrawing(
        name=drawing.name,
        label=drawing.label or drawing.name,
        shapes=tuple(
            DrawnShape(
                name=shape.name,
                label=shape.label or shape.name,
                closed=shape.closed,
                color=shape.color,
                points=SurfacePoints(
                    np.array([point.face for point in shape.surface_points], np.int64),
                    np.array([point.barycentric for point in shape.surface_points]),
                ),
                corners=tuple(shape.corners),
            )
            for shape in drawing.shapes
        ),
    )


def _check_point(point: SurfacePointEntry | LandmarkEntry, faces: int, what: str) -> None:
    if point.face >= faces:
        raise BadModel(f"{what} lies on triangle {point.face}, the mesh has only {faces}.")
    if abs(sum(point.barycentric) - 1.0) > UNIT_SUM or min(point.barycentric) < -BARYCENTRIC_OUTSIDE:
        raise BadModel(f"{what} has a point outside its triangle; barycentric weights must be positive and sum to 1.")


def _indices(indices: list[int], below: int, what: str, length: int | None = None) -> Integers:
    result = np.array(indices, np.int64)
    if length is not None and len(result) != length:
        raise BadModel(f"The side file's {what} has {len(result)} entries, the mesh has {length} vertices.")
    if result.size and result.max() >= below:
        raise BadModel(f"The side file's {what} names vertices that the mesh does not have.")
    result.flags.writeable = False
    return result


def _unique(what: str, names: list[str]) -> list[str]:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise BadModel(f'Two entries share the {what} name "{twice[0]}"; names must be unique.')
    return names


def _known(what: str, name: str, names: list[str]) -> int:
    if name not in names:
        raise BadModel(f'The side file names a {what} "{name}" that does not exist; known are: {", ".join(names)}.')
    return names.index(name)


def _same_names(what: str, side: list[str], mesh: list[str], weights: Array | None = None) -> None:
    missing = [name for name in side if name not in mesh]
    if missing:
        raise BadModel(f'The side file lists the {what} "{missing[0]}", which the .glb does not have.')
    for index, name in enumerate(mesh):
        if name not in side and (weights is None or weights[:, index].any()):
            raise BadModel(f'The .glb has the {what} "{name}", which the side file does not list.')


def _parsed(kind: type[File], text: bytes, file: str) -> File:
    try:
        return kind.model_validate(json.loads(text))
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        raise BadModel(f"{file} is not a file of this model: {where}: {first['msg']}.") from error
    except (ValueError, RecursionError) as error:
        raise BadModel(f"{file} is not a JSON file.") from error


def _bytes(path: Path) -> bytes:
    try:
        content = read_ordinary(path, MODEL_BYTES)
        if len(content) > MODEL_BYTES:
            raise BadModel(
                f"The model file {shown(path.name)} is larger than {MODEL_BYTES // 10**6} MB; this is no rig."
            )
        return content
    except OSError as error:
        raise BadModel(
            f"The model file {shown(path.name)} cannot be read; a model is a .glb with a .json beside it."
        ) from error


def _reason(error: BaseException) -> str:
    return str(error) if type(error) is ValueError else "its glTF structure is broken"

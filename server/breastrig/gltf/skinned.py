"""The skinned, morphing mesh as a glTF document: nodes, skin, mesh, material, without anything posed.

Layout: node 0 is the mesh (named as the rig), then for each bone its node and its `<bone>_scale` leaf.  The
inverse bind matrix of joint j is [Q_jᵀ | −Q_jᵀ o_j], so a joint's matrix times it is the rig's own map of
that bone.  All numbers are rounded to float32 first and everything derived (normals) is computed from the
rounded ones: writing what was read gives the same mesh again.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pygltflib import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, Material, Mesh, PbrMetallicRoughness, Primitive, Skin

from breastrig.core.arrays import Array, all_in_row
from breastrig.core.errors import BadModel
from breastrig.geometry.normals import VertexNormals
from breastrig.gltf.container import BufferWriter, append, new_document
from breastrig.gltf.document import Attributes, Document, Node
from breastrig.gltf.pose_nodes import node_poses, scale_node
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters

INFLUENCES = 4  # one JOINTS_0 / WEIGHTS_0 pair
WEIGHT_STEPS = 2**24  # skin weights are multiples of 1 / this: exact in float32, and rows sum to exactly 1
CLAY = [0.60, 0.33, 0.22, 1.0]  # linear RGB of a warm clay


@dataclass(frozen=True, eq=False)
class SkinnedNodes:
    """Indices of the skin and nodes in the document."""

    skin: int
    nodes: dict[str, int]  # node name -> index


def add_skinned_rig(document: Document, buffer: BufferWriter, rig: Rig) -> SkinnedNodes:
    """Adds the rig to an empty document: mesh, material, bones, skin; poses are set by `set_pose`."""
    if sum(bone.parent is None for bone in rig.bones) != 1:
        raise BadModel("A model needs exactly one bone without a parent.")
    names = [rig.name, *rig.bone_names, *(scale_node(name) for name in rig.bone_names)]
    if len(set(names)) != len(names):
        raise BadModel("The names of the model, its bones and their scale nodes must all differ.")
    mesh = append(document.meshes, _mesh(document, buffer, rig))
    nodes = {rig.name: append(document.nodes, Node(name=rig.name, mesh=mesh, skin=0))}
    for bone in rig.bones:
        nodes[bone.name] = append(document.nodes, Node(name=bone.name))
        nodes[scale_node(bone.name)] = append(document.nodes, Node(name=scale_node(bone.name)))
    roots = [nodes[rig.name]]
    for bone in rig.bones:
        node = document.nodes[nodes[bone.name]]
        node.children = [nodes[scale_node(bone.name)]]
        if bone.parent is None:
            roots.append(nodes[bone.name])
        else:
            document.nodes[nodes[rig.bones[bone.parent].name]].children.append(nodes[bone.name])
    document.scenes[0].nodes = roots
    skin = Skin(
        name=f"{rig.name}_skin",
        inverseBindMatrices=buffer.add(_inverse_bind_matrices(rig)),
        joints=[nodes[scale_node(bone.name)] for bone in rig.bones],
        skeleton=roots[1],
    )
    return SkinnedNodes(append(document.skins, skin), nodes)


def skinned_document(rig: Rig, extras: dict[str, Any]) -> tuple[Document, BufferWriter, SkinnedNodes]:
    """A new document of the rig alone, to be posed and added to; `extras` join the notice in asset.extras."""
    document, buffer, skinned = _only_the_rig(rig)
    document = replace(
        document,
        accessors=[*document.accessors],
        bufferViews=[*document.bufferViews],
        materials=[*document.materials],
        asset=new_document(extras).asset,
        buffers=[replace(each) for each in document.buffers],
        meshes=[own_targets(each) for each in document.meshes],
        nodes=[replace(each, children=[*each.children]) for each in document.nodes],
        skins=[replace(each) for each in document.skins],
        scenes=[replace(each, nodes=[*each.nodes]) for each in document.scenes],
    )
    return document, buffer.going_on(document), SkinnedNodes(skinned.skin, {**skinned.nodes})


@lru_cache(maxsize=2)  # of a process that fits one scan after the other
def _only_the_rig(rig: Rig) -> tuple[Document, BufferWriter, SkinnedNodes]:
    """The cached document of the rig alone; skinned_document copies all that may change."""
    document = new_document()
    buffer = BufferWriter(document)
    return document, buffer, add_skinned_rig(document, buffer, rig)


def own_targets(mesh: Mesh) -> Mesh:
    """A copy with its own list of shapes."""
    primitives = [replace(each, targets=[*each.targets]) for each in mesh.primitives]
    return replace(mesh, primitives=primitives, extras={"targetNames": [*mesh.extras["targetNames"]]})


def mesh_of(document: Document, skinned: SkinnedNodes, name: str) -> Mesh:
    """The mesh of the node of that name, which has one."""
    number = document.nodes[skinned.nodes[name]].mesh
    assert number is not None
    return document.meshes[number]


def set_pose(document: Document, skinned: SkinnedNodes, rig: Rig, x: RigParameters) -> None:
    """Poses the nodes of the document; every other node that shares the mesh's shapes takes its weights too."""
    for pose in node_poses(rig, x):
        node = document.nodes[skinned.nodes[pose["name"]]]
        node.translation = pose.get("translation", node.translation)
        node.rotation = pose.get("rotation", node.rotation)
        node.scale = pose.get("scale", node.scale)
        if "weights" in pose:
            for other in document.nodes:
                if other.mesh is not None:
                    other.weights = pose["weights"]


def joints_and_weights(weights: Array) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """((N, 4) uint8, (N, 4) float32): the four strongest bones of each row of (N, B), sums exactly 1."""
    count = min(INFLUENCES, weights.shape[1])
    strongest = np.argsort(-weights, axis=1, kind="stable")[:, :count]
    values = np.take_along_axis(weights, strongest, axis=1)
    steps = np.round(values / values.sum(axis=1, keepdims=True) * WEIGHT_STEPS)
    steps[:, 0] += WEIGHT_STEPS - steps.sum(axis=1)
    joints = np.zeros((len(weights), INFLUENCES), np.uint8)
    result = np.zeros((len(weights), INFLUENCES), np.float32)
    joints[:, :count] = np.where(steps > 0, strongest, 0)  # the format wants joint 0 where the weight is 0
    result[:, :count] = steps / WEIGHT_STEPS
    return joints, result


def as_float32(values: Array) -> NDArray[np.float32]:
    """Rounded to float32, without negative zeros."""
    return values.astype(np.float32) + np.float32(0.0)


@lru_cache(maxsize=4)
def normals_of_shapes(rig: Rig) -> Array:
    """(1 + S, V, 3) unit: the template's normals, then those with each shape at weight 1; of the rounded numbers."""
    vertices, normals_of = as_float32(rig.template).astype(np.float64), VertexNormals(rig.faces, len(rig.template))
    result = np.zeros((1 + len(rig.blendshapes), *vertices.shape))
    result[0] = normals_of(vertices)
    for normals, moves in zip(result[1:], rig.blendshapes, strict=True):
        normals[:] = normals_of(vertices + as_float32(moves))
    result.flags.writeable = False
    return result


def _mesh(document: Document, buffer: BufferWriter, rig: Rig) -> Mesh:
    if (np.count_nonzero(rig.skin_weights, axis=1) > INFLUENCES).any():
        raise BadModel("A vertex of the model hangs on more than four bones; prune its skin weights to four.")
    if len(rig.bones) > np.iinfo(np.uint8).max:
        raise BadModel(f"A model can have at most 255 bones, this one has {len(rig.bones)}.")
    vertices = as_float32(rig.template)
    unmoved, *moved = normals_of_shapes(rig)
    normals = as_float32(unmoved)
    joints, weights = joints_and_weights(rig.skin_weights)
    on_vertices = ARRAY_BUFFER
    index_type = np.uint16 if len(vertices) < np.iinfo(np.uint16).max else np.uint32
    attributes = Attributes(
        POSITION=buffer.add(vertices, target=on_vertices, bounds=True),
        NORMAL=buffer.add(normals, target=on_vertices),
        TEXCOORD_0=buffer.add(as_float32(rig.uv), target=on_vertices),
        JOINTS_0=buffer.add(joints, target=on_vertices),
        WEIGHTS_0=buffer.add(weights, target=on_vertices),
    )
    indices = buffer.add(rig.faces.ravel().astype(index_type), target=ELEMENT_ARRAY_BUFFER)
    targets = []
    for shape, turned in zip(rig.blendshapes, moved, strict=True):
        moves = as_float32(shape)
        turns = as_float32(turned - normals)
        turns[all_in_row(moves == 0.0) & all_in_row(np.abs(turns) < 1e-6)] = 0.0  # rounding of untouched normals
        targets.append(
            Attributes(
                POSITION=buffer.add(moves, target=on_vertices, bounds=True),
                NORMAL=buffer.add(turns, target=on_vertices),
            )
        )
    primitive = Primitive(
        attributes=attributes, indices=indices, material=append(document.materials, _clay()), targets=targets
    )
    return Mesh(name=rig.name, primitives=[primitive], extras={"targetNames": list(rig.shape_names)})


def _clay() -> Material:
    return Material(
        name="clay",
        doubleSided=False,
        pbrMetallicRoughness=PbrMetallicRoughness(baseColorFactor=CLAY, metallicFactor=0.0, roughnessFactor=0.7),
    )


def _inverse_bind_matrices(rig: Rig) -> NDArray[np.float32]:
    """(B, 4, 4): the map from body coordinates into each bone's rest frame."""
    inverse = np.zeros((len(rig.bones), 4, 4))
    turned = rig.rest_rotations.transpose(0, 2, 1)
    inverse[:, :3, :3] = turned
    inverse[:, :3, 3] = -np.einsum("bij,bj->bi", turned, rig.rest_origins)
    inverse[:, 3, 3] = 1.0
    return as_float32(inverse)

"""The whole fit in one .glb: the fitted model with its drawing, and how it got there as an animation.

The nodes are in the last pose, in which the drawing is exact, so a viewer that ignores animations shows the
result.  The animation has one
key for each iterate; keys are at least KEY_SPACING apart, because a fit is faster than the eye, and the true
times are kept in the animation's extras.  Far from the origin the bones are children of a node that stands there, so
that neither the animation's keys nor what a viewer multiplies with single precision loses the place.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pygltflib import ARRAY_BUFFER, Animation, AnimationChannel, AnimationChannelTarget, AnimationSampler

from breastrig.core.arrays import Array
from breastrig.core.single_precision import far_place
from breastrig.geometry.normals import vertex_normals
from breastrig.gltf.container import BufferWriter, append, moved_to, to_glb
from breastrig.gltf.document import Attributes, Document, Node
from breastrig.gltf.lines.drawing_node import add_drawing, drawing_node, positions_exact_in
from breastrig.gltf.lines.ribbon import exact_in, inverses, ribbons
from breastrig.gltf.pose_nodes import node_poses
from breastrig.gltf.skinned import SkinnedNodes, as_float32, mesh_of, set_pose, skinned_document
from breastrig.rig.model import ModelDrawing, Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import Posed, as_linear, pose

SKIN_LAYER = "skin_layer"


def add_skin_layers(
    document: Document,
    buffer: BufferWriter,
    skinned: SkinnedNodes,
    rig: Rig,
    drawing: ModelDrawing | None,
    poses: Sequence[RigParameters],
    surfaces: Sequence[Array],
) -> None:
    """Adds a target for each pose to the rig's mesh and its drawing's, the last one switched on.

    `surfaces` (V, 3) m are where the skin is in these poses: off the model, or off what a viewer's linear skinning
    makes of it.  The drawing is exact on the model in the last pose.
    """
    on_vertices = ARRAY_BUFFER
    skins = [mesh_of(document, skinned, rig.name)]
    lines = () if drawing is None else ribbons(rig, drawing)
    if drawing is not None and lines:
        skins.append(mesh_of(document, skinned, drawing_node(drawing.name)))
        before = exact_in(rig, lines, poses[-1], pose(rig, poses[-1]))
    for key, (x, surface) in enumerate(zip(poses, surfaces, strict=True), 1 - len(poses)):
        posed = Posed(rig, x)
        moves = np.einsum("vij,vj->vi", inverses(posed.linear), surface - posed.vertices)
        turns = vertex_normals(posed.shaped + moves, rig.faces) - vertex_normals(posed.shaped, rig.faces)
        layer = Attributes(
            POSITION=buffer.add(as_float32(moves), target=on_vertices, bounds=True),
            NORMAL=buffer.add(as_float32(turns), target=on_vertices),
        )
        skins[0].primitives[0].targets.append(layer)
        if lines:
            there = exact_in(rig, lines, x, surface)
            for primitive, at, was in zip(skins[1].primitives, there, before, strict=True):
                place = buffer.add(as_float32(at - was), target=on_vertices, bounds=True)
                primitive.targets.append(Attributes(POSITION=place))
        for mesh in skins:
            mesh.extras["targetNames"].append(f"{SKIN_LAYER}{key or ''}")
    for node in document.nodes:
        if node.mesh is not None:
            node.weights = [*(node.weights or []), *_switched(len(poses) - 1, len(poses))]


def _switched(on: int, count: int) -> list[float]:
    """Weights of `count` layers, one of them on, none where `on` is before the first."""
    return [float(layer == on) for layer in range(count)]


FAR_FRAME = "scan_place"
KEY_SPACING = 0.06  # s, the pace at which the page plays iterations at most


def fitted_glb(
    rig: Rig,
    iterates: Sequence[RigParameters],
    times_s: Sequence[float],
    drawing: ModelDrawing | None,
    extras: dict[str, Any],
    surface: Array | None = None,
) -> bytes:
    """The rig posed by the last of the iterates (scan frame, m), with the animation "registration".

    `times_s` are the iterates' times since the start; `extras` join the notice in asset.extras; `surface` (V, 3) m is
    the skin where a free-form layer has moved it off the last of the iterates.  Viewers skin linearly: a rig by dual
    quaternions gets a layer for each iterate.
    """
    iterates = [as_linear(rig, x)[1] for x in iterates]
    rig = rig.with_correctives_as_shapes
    document, buffer, skinned = skinned_document(rig, extras)
    place = far_place(iterates[-1].translations)
    if place.any():
        iterates = [iterate.moved(np.eye(3), -place) for iterate in iterates]
        surface = None if surface is None else surface - place
        _hang_bones(document, skinned, place)
    if drawing is not None:
        add_drawing(document, buffer, skinned, rig, drawing, positions_exact_in(rig, drawing, iterates[-1]))
    set_pose(document, skinned, rig, iterates[-1])
    poses = [node_poses(rig, x) for x in iterates]
    surfaces = [] if rig.skinning == "linear" else [pose(rig, x) for x in iterates]
    if surface is not None:
        surfaces[-1:] = [surface]
    if surfaces:
        first = len(iterates) - len(surfaces)
        add_skin_layers(document, buffer, skinned, rig, drawing, iterates[first:], surfaces)
        for key, nodes in enumerate(poses):
            nodes[-1]["weights"] = [*nodes[-1]["weights"], *_switched(key - first, len(surfaces))]
    document.animations = [_animation(document, buffer, skinned, poses, np.asarray(times_s, np.float64))]
    if extras.get("predicted"):
        for node in document.nodes:
            if node.mesh is not None:
                node.extras = {**(node.extras or {}), "predicted": True}
    return to_glb(document, buffer)


def _hang_bones(document: Document, skinned: SkinnedNodes, place: Array) -> None:
    """Puts a node at the (3,) m place between the scene and the root bone."""
    mesh, bone = document.scenes[0].nodes
    frame = append(document.nodes, Node(name=FAR_FRAME, children=[bone], translation=moved_to(place)))
    document.scenes[0].nodes = [mesh, frame]
    document.skins[skinned.skin].skeleton = frame


def _animation(
    document: Document,
    buffer: BufferWriter,
    skinned: SkinnedNodes,
    poses: Sequence[list[dict[str, Any]]],
    times: Array,
) -> Animation:
    animation = Animation(name="registration", extras={"elapsed_s": [round(float(time), 4) for time in times]})
    keys = buffer.add(_spaced(times).astype(np.float32), bounds=True)

    def animate(nodes: list[int], path: str, values: NDArray[np.float32]) -> None:
        output = buffer.add(values)
        sampler = append(animation.samplers, AnimationSampler(input=keys, output=output))
        for node in nodes:
            target = AnimationChannelTarget(node=node, path=path)
            animation.channels.append(AnimationChannel(sampler=sampler, target=target))

    for index, posed in enumerate(poses[0]):
        for path in ("translation", "rotation", "scale"):
            if path in posed:
                values = np.array([key[index][path] for key in poses], np.float32)
                animate([skinned.nodes[posed["name"]]], path, _one_hemisphere(values) if path == "rotation" else values)
        if posed.get("weights"):
            moving = [node for node, entry in enumerate(document.nodes) if entry.mesh is not None]
            animate(moving, "weights", np.concatenate([key[index]["weights"] for key in poses]).astype(np.float32))
    return animation


def _spaced(times: Array) -> Array:
    """Times from 0 whose steps are at least KEY_SPACING."""
    steps = np.maximum(np.diff(times), KEY_SPACING)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _one_hemisphere(quaternions: NDArray[np.float32]) -> NDArray[np.float32]:
    """(K, 4) with signs such that each key is on the short way from the one before."""
    dots = np.einsum("ki,ki->k", quaternions[1:], quaternions[:-1])
    signs = np.cumprod(np.concatenate([[1.0], np.where(dots < 0, -1.0, 1.0)]))
    return (quaternions * signs[:, None]).astype(np.float32)

"""What a viewer would draw for a glTF: node hierarchy, animation, morph targets and skin in plain numpy.

Written from the glTF 2.0 specification, without the code that writes our files, so that both can disagree.
"""

import base64
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays


class GltfScene:
    """A .glb, or a .gltf with the bytes behind its buffers' addresses."""

    def __init__(self, data: bytes, buffers: Mapping[str, bytes] | None = None) -> None:
        self.document, binary = split_glb(data) if data[:4] == b"glTF" else (json.loads(data), b"")
        for buffer in self.document["buffers"]:
            if "uri" in buffer and not buffer["uri"].startswith("data:"):
                content = (buffers or {})[buffer["uri"]]
                assert len(content) == buffer["byteLength"]
                buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(content).decode()
        self.arrays = GltfArrays(self.document, binary)
        self.nodes: list[dict[str, Any]] = self.document["nodes"]

    def node(self, name: str) -> dict[str, Any]:
        """The node of that name."""
        return next(node for node in self.nodes if node["name"] == name)

    def positions(self, name: str) -> np.ndarray:
        """(V, 3) m, drawn positions of all primitives of the mesh node of that name, one after the other."""
        node = self.node(name)
        mesh = self.document["meshes"][node["mesh"]]
        weights = node.get("weights", mesh.get("weights"))
        return np.concatenate([self._skinned(node, entry, weights) for entry in mesh["primitives"]])

    def at_key(self, animation: str, key: int) -> "GltfScene":
        """The same scene with the nodes as the animation's key number `key` (from the end when negative) puts them."""
        found = next(entry for entry in self.document["animations"] if entry["name"] == animation)
        for channel in found["channels"]:
            sampler = found["samplers"][channel["sampler"]]
            times, values = self.arrays.read(sampler["input"]), self.arrays.read(sampler["output"])
            path, node = channel["target"]["path"], self.nodes[channel["target"]["node"]]
            node[path] = values.reshape(len(times), -1)[key].tolist()
        return self

    def _skinned(self, node: dict[str, Any], primitive: dict[str, Any], weights: list[float] | None) -> np.ndarray:
        attributes = primitive["attributes"]
        points = self.arrays.read(attributes["POSITION"])
        for target, weight in zip(primitive.get("targets", []), weights or [], strict=True):
            points = points + weight * self.arrays.read(target["POSITION"])
        world = self._world_matrices()
        homogeneous = np.column_stack([points, np.ones(len(points))])
        if "skin" not in node:
            return (homogeneous @ world[self.nodes.index(node)].T)[:, :3]
        skin = self.document["skins"][node["skin"]]
        inverse = self.arrays.read(skin["inverseBindMatrices"])
        matrices = np.array([world[joint] @ inverse[i] for i, joint in enumerate(skin["joints"])])
        joints, strengths = self.arrays.read(attributes["JOINTS_0"]), self.arrays.read(attributes["WEIGHTS_0"])
        blended = np.einsum("vi,viab->vab", strengths, matrices[joints])
        return np.einsum("vab,vb->va", blended, homogeneous)[:, :3]

    def _world_matrices(self) -> dict[int, np.ndarray]:
        world: dict[int, np.ndarray] = {}

        def visit(index: int, above: np.ndarray) -> None:
            world[index] = above @ _local(self.nodes[index])
            for child in self.nodes[index].get("children", []):
                visit(child, world[index])

        for root in self.document["scenes"][self.document["scene"]]["nodes"]:
            visit(root, np.eye(4))
        return world


def _local(node: dict[str, Any]) -> np.ndarray:
    """T R S of a node, (4, 4)."""
    if "matrix" in node:
        return np.array(node["matrix"]).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0.0, 0.0, 0.0, 1.0])
    result = np.eye(4)
    result[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    result[:3, :3] *= node.get("scale", [1.0, 1.0, 1.0])
    result[:3, 3] = node.get("translation", [0.0, 0.0, 0.0])
    return result

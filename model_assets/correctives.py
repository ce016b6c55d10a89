"""Correctives of the torso's shoulders: python model_assets/correctives.py FOLDER [--picture FILE]

Writes the torso with "skinning": "corrective" to FOLDER/torso.glb, what is known of it beside it, and prints how far
each skinning is from flesh (docs/decisions/0023-skinning.md).  For flesh stand the torso's tetrahedra: cores of collar
bone and upper arm are rigid, the trunk stands, elsewhere each is as near as can be to a rotation and to its volume.
"""

import argparse
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from contact_sheet import sheet, tile
from scipy.sparse.linalg import splu

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.caps import closed
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.known_files import bind_known
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Corrective, Rig
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.rig.skinning import Posed, PosedByDualQuaternions, PosedWithCorrectives, bone_matrices
from breastrig.volume.known_volume import known_volume
from breastrig.volume.tetrahedra import shape_gradients, stiffness
from breastrig_studies.output.rig_files import write_rig

REST = 41.0  # degrees from hanging, of the torso's arms
LEARNT, SHARES = (10, 50, 90, 130, 170), (0.0, 0.15)  # degrees from hanging; of a turn that the shoulder girdle does
POWERS = 3
FREE, NEAR, REACH = (
    0.02,
    0.10,
    0.25,
)  # arm's share below which flesh is held, beyond so far (m) from the joint; all of it
MOSTLY, END, CORE = 0.9, 0.085, 0.018  # arm's share at its end, which starts so far from the joint; m around bones
RIDGE = 0.02  # m² a unit: shapes do not grow where the arm's bones fold linear skinning flat
VOLUME, LEAST, ROUNDS = 2.0, 0.1, 40  # weight of volumes beside rotations; least stretch; of projecting and solving
AROUND = 0.09  # m around the joint, where the skin's area is compared


class Flesh:
    """The torso's tetrahedra, of N nodes of which the first V are the skin."""

    def __init__(self, rig: Rig) -> None:
        self.rig, self.known, self.skin = rig, known_volume(rig), len(rig.template)
        self.matrix = stiffness(self.known).tocsc()
        inside = np.arange(self.skin, len(self.known.points))
        within = splu(self.matrix[inside][:, inside])
        weights = -within.solve(self.matrix[inside][:, : self.skin] @ rig.skin_weights)
        self.weights = np.concatenate([rig.skin_weights, weights])  # (N, B), harmonic inside
        self.owner = self._owners()
        trunk = (self.weights[:, self._bones("upper_arm")].sum(axis=1) < FREE) & (self._away() > NEAR)
        self.held = (self.owner >= 0) | trunk | (self._away() > REACH)
        self.free = np.flatnonzero(~self.held)
        self.factors = splu(self.matrix[self.free][:, self.free])
        near = (~self.held)[self.known.tetrahedra].any(axis=1)
        self.corners = self.known.tetrahedra[near]
        self.gradients, self.volumes = (
            each[near] for each in shape_gradients(self.known.points, self.known.tetrahedra)
        )

    def _bones(self, start: str) -> list[int]:
        return [bone for bone, name in enumerate(self.rig.bone_names) if name.startswith(start)]

    def _away(self) -> Array:
        """(N,) m from the nearer shoulder joint."""
        anchors = [self.rig.joints[joint].anchor for joint in shoulders(self.rig)]
        return np.asarray(np.min([np.linalg.norm(self.known.points - anchor, axis=1) for anchor in anchors], axis=0))

    def _owners(self) -> Integers:
        """(N,) the bone that a node is rigid with, or -1: cores of collar bone and upper arm, and the arm's end."""
        points, owner = self.known.points, np.full(len(self.known.points), -1)
        for joint in shoulders(self.rig):
            shoulder, arm = self.rig.joints[joint].parent, self.rig.joints[joint].child
            inner = next(each.anchor for each in self.rig.joints if each.child == shoulder)
            outer = self.rig.joints[joint].anchor
            far = points[: self.skin][self.rig.skin_weights[:, arm] > MOSTLY].mean(axis=0)
            along, off = _beside(points, outer, far)
            own = self.weights[:, arm] > 0.5
            owner[own & ((along > END) | ((along > 0.0) & (off < CORE)))] = arm
            along, off = _beside(points, inner, outer)
            owner[(along > 0.0) & (along < np.linalg.norm(outer - inner) - CORE) & (off < CORE)] = shoulder
        return owner

    @property
    def free_skin(self) -> Booleans:
        return np.asarray(~self.held[: self.skin])

    def skin_in(self, x: RigParameters) -> Array:
        """(V, 3) m: local and global steps in turn (Bouaziz and others, Projective Dynamics, 2014)."""
        linear, offset = bone_matrices(self.rig, x)
        points = (
            np.einsum("nb,bij,nj->ni", self.weights, linear, self.known.points, optimize=True) + self.weights @ offset
        )
        own = self.owner >= 0
        points[own] = np.einsum("nij,nj->ni", linear[self.owner[own]], self.known.points[own]) + offset[self.owner[own]]
        pulled = self.matrix[self.free][:, np.flatnonzero(self.held)] @ points[self.held]
        for _ in range(ROUNDS):
            forces = np.zeros_like(points)
            wanted = self._wanted(np.einsum("mai,maj->mij", points[self.corners], self.gradients))
            np.add.at(forces, self.corners, np.einsum("m,mij,maj->mai", self.volumes, wanted, self.gradients))
            points[self.free] = self.factors.solve(forces[self.free] - pulled)
        return np.asarray(points[: self.skin])

    @staticmethod
    def _wanted(gradients: Array) -> Array:
        """(M, 3, 3): between the nearest rotation and what is near and keeps the volume."""
        left, stretch, right = np.linalg.svd(gradients)
        turned_over = np.linalg.det(left @ right) < 0.0
        left[turned_over, :, 2] *= -1.0
        stretch[turned_over, 2] *= -1.0
        kept = np.maximum(stretch, LEAST)
        kept /= np.cbrt(kept.prod(axis=1, keepdims=True))
        return np.asarray((left * (1.0 + VOLUME * kept)[:, None]) @ right / (1.0 + VOLUME))


def _beside(points: Array, start: Array, end: Array) -> tuple[Array, Array]:
    """(N,) m along the line from start to end, and off it."""
    direction = (end - start) / np.linalg.norm(end - start)
    along = (points - start) @ direction
    return along, np.linalg.norm(points - start - along[:, None] * direction, axis=1)


def shoulders(rig: Rig) -> list[int]:
    """The joints of both upper arms."""
    return [i for i, joint in enumerate(rig.joints) if rig.bone_names[joint.child].startswith("upper_arm")]


def raised(rig: Rig, degrees: float, share: float = 0.0) -> RigParameters:
    """Both arms so far from hanging, sideways, `share` of it by the shoulder girdle."""
    rest = rest_parameters(rig)
    rotations, translations = rest.rotations.copy(), rest.translations.copy()
    for arm in shoulders(rig):
        above = next(joint for joint in rig.joints if joint.child == rig.joints[arm].parent)
        for joint, part in ((rig.joints[arm], 1.0 - share), (above, share)):
            side = 1.0 if joint.anchor[0] > 0.0 else -1.0
            turn = exp_so3(np.array([0.0, 0.0, side * part * np.radians(degrees - REST)]))
            for bone in {joint.child, rig.joints[arm].child}:
                rotations[bone] = turn @ rotations[bone]
                translations[bone] = joint.anchor + turn @ (translations[bone] - joint.anchor)
    return replace(rest, rotations=rotations, translations=translations)


def correctives(rig: Rig, flesh: Sequence[Array]) -> tuple[Corrective, ...]:
    """Of each arm's turn to the powers 1 to POWERS, least squares to (V, 3) m skins at the angles LEARNT."""
    made = []
    bases = np.radians(np.array(LEARNT) - REST)[:, None] ** np.arange(1, POWERS + 1)
    table, pulled = np.zeros((len(rig.template), 3 * POWERS, 3 * POWERS)), np.zeros((len(rig.template), 3 * POWERS))
    for degrees, base, skin in zip(LEARNT, bases, flesh, strict=True):
        linear = Posed(rig, raised(rig, degrees))
        rows = np.concatenate([power * linear.linear for power in base], axis=2)
        table += rows.transpose(0, 2, 1) @ rows
        pulled += np.einsum("vai,va->vi", rows, skin - linear.vertices)
    moves = np.linalg.solve(table + RIDGE * np.eye(3 * POWERS), pulled[..., None])[..., 0].reshape(-1, POWERS, 3)
    for joint in shoulders(rig):
        side = 1.0 if rig.joints[joint].anchor[0] > 0.0 else -1.0
        for power in range(POWERS):
            own = np.where((side * rig.template[:, :1] > 0.0), side ** (power + 1) * moves[:, power], 0.0)
            name = f"{rig.bone_names[rig.joints[joint].child]}_raised_{power + 1}"
            made.append(Corrective(name, joint, (0, 0, power + 1), own))
    return tuple(made)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    rig = read_rig(default_rig_path())
    flesh = Flesh(rig)
    skins = {(share, degrees): flesh.skin_in(raised(rig, degrees, share)) for share in SHARES for degrees in LEARNT}
    made = correctives(rig, [skins[0.0, degrees] for degrees in LEARNT])
    corrected = replace(rig, skinning="corrective", correctives=made)
    write_rig(corrected, options.folder, license="CC0-1.0", provenance={"of": rig.sha256})
    known = options.folder / "torso.known"
    shutil.copytree(default_rig_path().with_suffix(".known"), known, dirs_exist_ok=True)
    glb = options.folder / "torso.glb"
    bind_known(glb, read_rig(glb).sha256)

    anchor, volume = rig.joints[shoulders(rig)[0]].anchor, volume_of(rig, rig.template)
    around = rig.faces[(np.linalg.norm(rig.template - anchor, axis=1) < AROUND)[rig.faces].all(axis=1)]
    area = area_of(rig.template, around)
    rows = []
    for (share, degrees), skin in skins.items():
        x = raised(rig, degrees, share)
        ways = [Posed(rig, x), PosedByDualQuaternions(rig, x), PosedWithCorrectives(corrected, x)]
        surfaces = [each.vertices for each in ways]
        for name, there in zip(("linear", "dual quaternion", "corrective", "flesh"), [*surfaces, skin], strict=True):
            gained, wider = 1e6 * (volume_of(rig, there) - volume), 100.0 * (area_of(there, around) / area - 1.0)
            gaps = 1e3 * np.linalg.norm(there - skin, axis=1)[flesh.free_skin]
            numbers = f"{gained:6.0f} ml {wider:5.1f} %  {gaps.mean():5.1f} {gaps.max():5.1f} mm"
            print(f"{share:4.2f} {degrees:3d} {name:15s} {numbers}")
        if share == 0.0:
            rows.append((f"{degrees}: linear, dual quaternion, corrective, flesh", [*surfaces, skin]))
    if options.picture:
        tiles = [(caption, [tile(rig, there, "front") for there in each]) for caption, each in [rows[0], *rows[2:]]]
        sheet(tiles, options.picture)


def volume_of(rig: Rig, vertices: Array) -> float:
    """m³, between neck, elbows and hips."""
    whole = closed(vertices, rig.faces)
    a, b, c = whole.vertices[whole.faces].transpose(1, 0, 2)
    return float(np.einsum("fi,fi->", a, np.cross(b, c)) / 6.0)


def area_of(vertices: Array, faces: Array) -> float:
    """m²."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


if __name__ == "__main__":
    main()

"""Nine bones, their eight joints and the skin weights.

The spine's weights are smooth steps in height (scaling a bone by a fifth must not crease the skin); shoulders and
upper arms start from MakeHuman's weights, which artists painted, and are spread by heat flow.
"""

from typing import Any

import numpy as np

from breastrig.rig.model import Bone, Joint
from steps.operators import laplacian, smoothed
from steps.source import Array, Source
from steps.whole_body import FLIP, Template


def _rest_rotation(along: Array | None) -> Array:
    """Local axes: the body's, or Y along the bone (up when the arm hangs) and Z as far front as can be."""
    if along is None:
        return np.eye(3)
    y = along / np.linalg.norm(along)
    z = np.array([0.0, 0.0, 1.0]) - y[2] * y
    z /= np.linalg.norm(z)
    return np.stack([np.cross(y, z), y, z], axis=1)


def mirror_name(name: str) -> str:
    """upper_arm_L <-> upper_arm_R; names without a side stay."""
    swap = {"_L": "_R", "_R": "_L"}
    return name[:-2] + swap[name[-2:]] if name[-2:] in swap else name


def bones_and_joints(source: Source, body: Array, recipe: dict[str, Any]) -> tuple[tuple[Bone, ...], tuple[Joint, ...]]:
    """The skeleton at rest."""

    def place(entry: Any) -> Array:
        return source.joint(entry, body) if isinstance(entry, str) else np.array(entry, dtype=float)

    bones: list[Bone] = []
    joints: list[Joint] = []
    names: list[str] = []
    for entry in recipe["bones"]:
        for side in ("_L", "_R") if entry.get("sided") else ("",):
            flip = FLIP if side == "_R" else np.ones(3)
            origin = flip * place(entry["origin"])
            along = flip * (origin * flip - place(entry["tip"])) if "tip" in entry else None
            parent_name = entry.get("parent")
            if parent_name and parent_name not in names:
                parent_name += side
            name = entry["name"] + side
            parent = names.index(parent_name) if parent_name else None
            low, high = np.array(entry["scale_min"], dtype=float), np.array(entry["scale_max"], dtype=float)
            rotation = _rest_rotation(along)
            bones.append(Bone(name, parent, np.round(origin, 6), rotation, low, high, mirror_name(name)))
            names.append(name)
            if parent is not None:
                joint = entry["joint"]
                anchor = np.round(flip * place(joint["anchor"]), 6)
                joints.append(
                    Joint(
                        parent, len(bones) - 1, anchor,
                        float(np.radians(joint["rotation_sigma_deg"])), joint["translation_sigma"],
                        float(np.radians(joint["rotation_limit_deg"])),
                    )
                )  # fmt: skip
    return tuple(bones), tuple(joints)


def smooth_step(x: Array) -> Array:
    """0 below -1, 1 above 1, twice differentiable between."""
    t = np.clip(0.5 * (x + 1.0), 0.0, 1.0)
    return np.asarray(t**3 * (t * (6.0 * t - 15.0) + 10.0))


def skin_weights(source: Source, template: Template, names: list[str], recipe: dict[str, Any]) -> Array:
    """(V, B): rows sum to 1, at most four non-zero, symmetric."""
    count = len(source.vertices)
    choices = recipe["weights"]
    stiffness, area = laplacian(template.vertices, template.triangles)

    def painted(bones: list[str], side: str) -> Array:
        total = np.zeros(count)
        for bone in bones:
            index, value = source.weights[bone + side]
            total[index] += value
        return template.carry(total)

    result = np.zeros((len(template.vertices), len(names)))
    for group in ("shoulder", "upper_arm"):
        for side in ("L", "R"):
            raw = painted(choices[group], f".{side}")
            result[:, names.index(f"{group}_{side}")] = smoothed(raw, stiffness, area, choices["smoothing"])
    result = np.clip(result, 0.0, 1.0)
    total = result.sum(axis=1, keepdims=True)
    result = result / np.maximum(total, 1.0)
    rest = 1.0 - result.sum(axis=1)

    height = template.vertices[:, 1] + choices["tilt"] * template.vertices[:, 2]
    spine = [entry["bone"] for entry in choices["spine"]]
    above = [smooth_step((height - e["height"]) / e["half_width"]) if "height" in e else np.ones(len(height))
             for e in choices["spine"]]  # fmt: skip
    for k, bone in enumerate(spine):
        upper = above[k + 1] if k + 1 < len(spine) else np.zeros(len(height))
        result[:, names.index(bone)] = rest * above[k] * (1.0 - upper)
    order = [names.index(mirror_name(name)) for name in names]
    middle = template.mirror == np.arange(len(template.mirror))
    result[middle] = 0.5 * (result[middle] + result[middle][:, order])
    result[result < choices["smallest"]] = 0.0
    rank = np.argsort(-result, axis=1, kind="stable")
    np.put_along_axis(result, rank[:, 4:], 0.0, axis=1)
    partner_kept = result[middle][:, order] > 0
    result[middle] = np.where(partner_kept, result[middle], 0.0)  # left and right are dropped together
    result = np.round(result, recipe["decimals"])
    right = template.vertices[:, 0] < 0
    result[right] = result[template.mirror[right]][:, order]
    return np.asarray(result / result.sum(axis=1, keepdims=True))

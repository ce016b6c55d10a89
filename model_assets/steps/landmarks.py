"""The 12 landmarks, each found on the template by the definition that a person would use on a patient."""

from typing import Any

import numpy as np

from breastrig.geometry.rotations import exp_so3
from breastrig.rig.model import Landmark
from steps.skeleton import mirror_name
from steps.skin import Hits, Skin, hollowness
from steps.source import Array
from steps.whole_body import FLIP, Template

DOWN_CLAVICLE = np.array([0.0, -0.5, -0.87])


def _front_profile(skin: Skin, x: float, low: float, high: float) -> Array:
    """(M, 3) the front of a sagittal cut from `high` down to `low` (m)."""
    cut = skin.sagittal_cut(x)
    cut = cut[(cut[:, 1] > low) & (cut[:, 1] < high) & (cut[:, 2] > 0.0)]
    return np.asarray(cut[np.argsort(-cut[:, 1], kind="stable")])


def _fold(skin: Skin, nipple: Array, r: dict[str, Any]) -> Array:
    """The lowest of the strongly hollow points under the breast on cuts near the nipple."""
    candidates = []
    for dx in np.arange(-r["fold_reach"], r["fold_reach"] + 1e-9, r["fold_step"]):
        profile = _front_profile(skin, nipple[0] + dx, nipple[1] - 0.11, nipple[1] - 0.02)
        profile = profile[profile[:, 2] > r["fold_front"]]
        if len(profile) < 10 or profile[-1, 1] > nipple[1] - 0.09:
            continue  # this cut runs down the side of the chest, not under the breast
        even, hollow = hollowness(profile, 0.003, 3)
        best = int(hollow.argmax())
        candidates.append((hollow[best], even[best]))
    usual = float(np.median([value for value, _ in candidates]))
    strong = [point for value, point in candidates if value > r["fold_strength"] * usual]
    return min(strong, key=lambda point: float(point[1]))


def with_hanging_arms(template: Template, arms: tuple[Array, Array], shoulder: Array, lowered: float) -> Skin:
    """The skin with both upper arms turned down about the shoulder joints.

    arms: (V,) blend weights of the left and the right arm; shoulder: (3,) m the left joint; lowered: rad.
    """
    vertices = template.vertices.copy()
    for weight, side in zip(arms, (1.0, -1.0), strict=True):
        joint = shoulder * (1.0 if side > 0 else FLIP)
        from_joint = template.vertices - joint
        vertices += weight[:, None] * (from_joint @ exp_so3(np.array([0.0, 0.0, -side * lowered])).T - from_joint)
    return Skin(vertices, template.triangles)


def _at_rest(skin: Skin, hits: Hits, which: int) -> Array:
    """(3,) m: where the skin that one of the hits met lies at rest."""
    return np.asarray(hits.barycentric[which] @ skin.vertices[skin.triangles[hits.faces[which]]])


def find_landmarks(
    skin: Skin, smooth: Skin, standing: Skin, template: Template, shoulder: Array, r: dict[str, Any]
) -> dict[str, Array]:
    """Name -> (3,) m on the left and in the middle.

    Profiles are read on the finer `smooth` skin.  The shoulder's landmarks are found on `standing`, the skin with the
    arms hanging as patients stand: with raised arms other skin lies above the joint.
    """
    nipple = template.vertices[template.rings[-1][0]]
    fold = _fold(smooth, nipple, r)
    even, hollow = hollowness(_front_profile(smooth, 0.0, r["notch_low"], r["notch_high"]), 0.003, 3)
    notch = even[int(hollow.argmax())]
    middle = _front_profile(smooth, 0.0, 0.05, notch[1] + 0.001)

    def at_height(y: float) -> Array:
        return np.array([np.interp(-y, -middle[:, 1], middle[:, i]) for i in range(3)])

    xiphoid = at_height(float(fold[1]))
    between = middle[(middle[:, 1] <= notch[1]) & (middle[:, 1] >= xiphoid[1])]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(between, axis=0), axis=1))])
    mid_sternum = np.array([np.interp(0.5 * along[-1], along, between[:, i]) for i in range(3)])
    low, high = at_height(r["navel_low"]), at_height(r["navel_high"])
    region = middle[(middle[:, 1] > low[1]) & (middle[:, 1] < high[1])]
    chord = low[2] + (region[:, 1] - low[1]) / (high[1] - low[1]) * (high[2] - low[2])
    umbilicus = region[int((chord - region[:, 2]).argmax())]
    above = standing.ray(shoulder + np.array([r["acromion_side"], 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    start = 0.5 * (notch + above.points[-1]) + np.array([0.0, r["midclavicle_up"], 0.0])
    direction = DOWN_CLAVICLE / np.linalg.norm(DOWN_CLAVICLE)
    collarbone = standing.ray(start - 0.15 * direction, direction)
    acromion, midclavicle = _at_rest(skin, above, -1), _at_rest(skin, collarbone, 0)
    return {
        "suprasternal_notch": notch,
        "mid_sternum": mid_sternum,
        "xiphoid": xiphoid,
        "midclavicle_L": midclavicle,
        "acromion_L": acromion,
        "nipple_L": nipple,
        "inframammary_fold_L": fold,
        "umbilicus": umbilicus,
    }


def landmarks(positions: dict[str, Array], skin: Skin, recipe: dict[str, Any]) -> tuple[Landmark, ...]:
    """The recipe's landmarks on the template, right ones mirrored."""
    result = []
    for entry in recipe["landmarks"]["list"]:
        for side in ("_L", "_R") if entry.get("sided") else ("",):
            name = entry["name"] + side
            point = np.round(positions[entry["name"] + ("_L" if side else "")] * (FLIP if side == "_R" else 1.0), 6)
            found = skin.nearest(point[None]) if side else skin.nearest_on_midline(point[None])
            words = {"_L": "left ", "_R": "right ", "": ""}[side]
            result.append(
                Landmark(
                    name, words + entry["label"], entry["latin"], entry["definition"], entry["easy"],
                    mirror_name(name), int(found.faces[0]), found.barycentric[0],
                )
            )  # fmt: skip
    return tuple(result)

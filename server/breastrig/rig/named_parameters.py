"""The pose and shape of a rig by name, as programs hold them, and bodies drawn at random."""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, frozen
from breastrig.core.errors import BadSettings
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.body_statistics import body_statistics
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.rig.skinning import in_pose


@dataclass(frozen=True, eq=False)
class BonePose:
    """One bone, absolute in the scan's frame."""

    rotation: Array  # (3, 3), its columns are the bone's local axes
    translation: Array  # (3,) in the scan's unit: where the bone's origin is
    scale: Array  # (3,) along its local axes; 1 is the model's own size in metres


@dataclass(frozen=True, eq=False)
class Parameters:
    """All parameters of a rig, by name; V vertices."""

    bones: dict[str, BonePose]
    blendshapes: dict[str, float]  # weights; 0 is the template
    metres_per_unit: float = 1.0  # of the translations
    skin_layer: Array | None = None  # (V, 3) m in the rest pose, added to the blendshapes; None: the model alone


def parameters_by_name(rig: Rig, x: RigParameters, metres_per_unit: float, surface: Array | None = None) -> Parameters:
    """Parameters by name from those in metres; `surface` (V, 3) m is the skin in that pose where a layer moves it."""
    translations = x.translations / metres_per_unit
    return Parameters(
        {
            name: BonePose(frozen(x.rotations[j]), frozen(translations[j]), frozen(x.scales[j]))
            for j, name in enumerate(rig.bone_names)
        },
        {name: float(weight) for name, weight in zip(rig.shape_names, x.weights, strict=True)},
        metres_per_unit,
        None if surface is None else frozen(layer_at_rest(rig, x, surface)),
    )


def layer_at_rest(rig: Rig, x: RigParameters, surface: Array) -> Array:
    """(V, 3) m: how far a posed skin lies off the model, as moves of the rest pose."""
    posed = in_pose(rig, x)
    return np.asarray(np.linalg.solve(posed.linear, (surface - posed.vertices)[..., None])[..., 0])


def in_metres(rig: Rig, given: Parameters) -> RigParameters:
    """The parameters as a fit has them, in metres; BadSettings for those of another rig."""
    if set(given.bones) != set(rig.bone_names) or set(given.blendshapes) != set(rig.shape_names):
        raise BadSettings(f"These parameters name other bones or shapes than {rig.name}; give those of this rig.")
    bones = [given.bones[name] for name in rig.bone_names]
    return RigParameters(
        rotations=np.array([bone.rotation for bone in bones]),
        translations=given.metres_per_unit * np.array([bone.translation for bone in bones]),
        scales=np.array([bone.scale for bone in bones]),
        weights=np.array([given.blendshapes[name] for name in rig.shape_names]),
    )


def posed(rig: Rig, given: Parameters) -> Array:
    """(V, 3) in the parameters' unit: the skin, its layer with it."""
    state = in_pose(rig, in_metres(rig, given))
    vertices = state.vertices
    if given.skin_layer is not None:
        if np.shape(given.skin_layer) != vertices.shape:
            raise BadSettings(f"skin_layer has the shape {np.shape(given.skin_layer)}; it must be {vertices.shape}.")
        vertices = vertices + np.einsum("vij,vj->vi", state.linear, given.skin_layer)
    return np.asarray(vertices / given.metres_per_unit)


def sampled(rig: Rig, rng: np.random.Generator) -> Parameters:
    """A random body drawn from the rig's priors, in a pose drawn from its joints' priors; metres, its root at rest."""
    rest, known = rest_parameters(rig), body_statistics(rig)
    scales, weights = rest.scales, rng.normal(0.0, [shape.sigma for shape in rig.shapes])
    if known is not None:
        drawn = rng.multivariate_normal(np.zeros(len(known.covariance)), known.covariance, method="eigh")
        scales = (known.mean_scales + drawn[: scales.size]).reshape(scales.shape)
        weights = drawn[scales.size :]
    limits = [(bone.scale_min, bone.scale_max) for bone in rig.bones]
    scales = np.clip(scales, *(np.array(ends) for ends in zip(*limits, strict=True)))
    weights = np.clip(weights, [shape.min for shape in rig.shapes], [shape.max for shape in rig.shapes])
    rotations, translations = rest.rotations.copy(), rest.translations.copy()
    for joint in sorted(rig.joints, key=lambda joint: joint.child):
        turn = rng.normal(0.0, joint.rotation_sigma, 3) / np.sqrt(3.0)
        turn *= min(1.0, joint.rotation_limit / max(float(np.linalg.norm(turn)), 1e-12))
        above, below = joint.parent, joint.child
        relative = rest.rotations[above].T @ rest.rotations[below]
        rotations[below] = rotations[above] @ relative @ exp_so3(turn[None])[0]
        anchor = [
            rotations[j] @ (scales[j] * (rest.rotations[j].T @ (joint.anchor - rest.translations[j])))
            for j in (above, below)
        ]
        translations[below] = translations[above] + anchor[0] - anchor[1]
    return parameters_by_name(rig, RigParameters(rotations, translations, scales, weights), 1.0)

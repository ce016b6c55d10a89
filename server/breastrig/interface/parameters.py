"""The pose and shape of a fitted model, by name."""

from dataclasses import dataclass

from breastrig.core.arrays import Array, frozen
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters


@dataclass(frozen=True, eq=False)
class BonePose:
    """One bone, absolute in the scan's frame."""

    rotation: Array  # (3, 3), its columns are the bone's local axes
    translation: Array  # (3,) in the scan's unit: where the bone's origin is
    scale: Array  # (3,) along its local axes; 1 is the model's own size in metres


@dataclass(frozen=True, eq=False)
class Parameters:
    """All of a model's, by name."""

    bones: dict[str, BonePose]
    blendshapes: dict[str, float]  # weights; 0 is the template


def parameters_by_name(rig: Rig, x: RigParameters, metres_per_unit: float) -> Parameters:
    """Of parameters in metres in the scan's frame."""
    translations = x.translations / metres_per_unit
    return Parameters(
        {
            name: BonePose(frozen(x.rotations[j]), frozen(translations[j]), frozen(x.scales[j]))
            for j, name in enumerate(rig.bone_names)
        },
        {name: float(weight) for name, weight in zip(rig.shape_names, x.weights, strict=True)},
    )

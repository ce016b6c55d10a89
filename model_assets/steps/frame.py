"""Bodies of other sizes in the frame that a recipe's lengths were written for: from pelvis to neck they are as long."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from breastrig.rig.model import Bone, Joint, Rig
from steps.source import Array, Source


@dataclass(frozen=True)
class Frame:
    """From a recipe's frame to a body: `size` times as large, then moved by `shift` (m)."""

    size: float
    shift: Array

    def of_source(self, source: Source) -> Source:
        """The source as the recipe sees it."""
        return replace(source, vertices=(source.vertices - self.shift) / self.size, unit=source.unit / self.size)

    def of_rig(self, rig: Rig, decimals: int) -> Rig:
        """What was built in the frame, as large as the body is; in its place it stays."""

        def sized(points: Array) -> Array:
            return np.round(self.size * points, decimals)

        def bone(each: Bone) -> Bone:
            return replace(each, origin=sized(each.origin))

        def joint(each: Joint) -> Joint:
            return replace(
                each, anchor=sized(each.anchor), translation_sigma=round(self.size * each.translation_sigma, 6)
            )

        return replace(
            rig,
            template=sized(rig.template),
            blendshapes=sized(rig.blendshapes),
            bones=tuple(map(bone, rig.bones)),
            joints=tuple(map(joint, rig.joints)),
        )


def reference_body(source: Source, targets: list[list[Any]]) -> Array:
    """(S, 3) m: the symmetric adult body with these targets."""
    moved = sum((weight * source.target(name) for name, weight in targets), source.vertices)
    return source.symmetrised(np.asarray(moved))


def frame(source: Source, recipe: dict[str, Any]) -> Frame:
    """Of the recipe's body against the one that its lengths were written for; the identity where they are one."""
    ends = [
        [source.joint(name, reference_body(source, recipe[which]["targets"])) for name in ("pelvis", "neck")]
        for which in ("frame", "body")
    ]
    (low, high), (own_low, own_high) = ends
    size = float((own_high - own_low)[1] / (high - low)[1])
    shift = 0.5 * (own_low + own_high) - size * (0.5 * (low + high))
    return Frame(size, shift * [0.0, 1.0, 1.0])

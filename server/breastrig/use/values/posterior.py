"""A fit's posterior for programs: the Gaussian around its parameters (fitting/posterior.py)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, frozen
from breastrig.geometry.rotations import log_so3
from breastrig.rig.blocks import blocks
from breastrig.rig.model import Rig
from breastrig.rig.named_parameters import Parameters, parameters_by_name
from breastrig.rig.parameters import RigParameters


@dataclass(frozen=True, eq=False, repr=False)
class Posterior:
    """P unknowns in metres and radians, whatever the scan's unit: for each of B bones rotation (rotation vector),
    translation and scale, three numbers each, then S blendshape weights; P = 9 B + S.

    It knows the scan's noise and what is expected of bodies, not how far bodies are from what the model can show:
    `Fit.uncertainty` has that as well.
    """

    mean: Array  # (P,) where the fit ended
    covariance: Array  # (P, P) of a step from there; a rotation's is in the bone's own axes: R exp(step)
    blocks: Mapping[str, slice]  # "BONE.rotation", "BONE.translation", "BONE.scale", and each blendshape's name
    model: Rig
    in_metres: RigParameters  # the mean

    def sample(self, rng: np.random.Generator) -> Parameters:
        """Parameters drawn from it, of the model alone, in metres in the scan's frame; see `Rig.pose`."""
        step = rng.multivariate_normal(np.zeros(len(self.mean)), self.covariance, method="eigh")
        return parameters_by_name(self.model, self.in_metres.retract(step), 1.0)

    def __repr__(self) -> str:
        return f"<Posterior: {len(self.mean)} unknowns in {len(self.blocks)} blocks>"


def posterior_of(rig: Rig, x: RigParameters, covariance: Array) -> Posterior:
    """Around x, with the covariance of a step from it; of more unknowns than x has, of the first (P, P)."""
    parts = np.concatenate([log_so3(x.rotations), x.translations, x.scales], axis=1)
    return Posterior(
        mean=frozen(np.concatenate([parts.ravel(), x.weights])),
        covariance=frozen(covariance[: x.dof, : x.dof]),
        blocks=blocks(rig),
        model=rig,
        in_metres=x,
    )

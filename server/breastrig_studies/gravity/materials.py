"""Energy densities of soft tissue, with their first and second derivatives by the deformation gradient.

Volume: compressible neo-Hookean, W = μ/2 (tr FᵀF − 3 − 2 ln J) + λ/2 (J − 1)² (Bonet and Wood, Nonlinear Continuum
Mechanics for Finite Element Analysis, 2008, chapter 6).  Skin: an incompressible neo-Hookean membrane in plane stress,
W = μh/2 (tr C + 1/det C − 3), C the right Cauchy-Green tensor of the tangent plane (same, chapter 6).
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from breastrig.core.arrays import Array

Response = tuple[Array, Array, Array]  # (E, Q) energy density, (E, Q, 9) its gradient, (E, Q, 9, 9) its Hessian by F


class Law(Protocol):
    """A material law of E elements with Q quadrature points each."""

    def energy(self, gradients: Array) -> Array:
        """(E, Q) density at (E, Q, 3, 3) deformation gradients; inf where an element is inverted."""

    def response(self, gradients: Array) -> Response:
        """Density, stress and stiffness; undefined where inverted."""

    def growth(self, gradients: Array) -> Array:
        """(E, Q) volume or area, times that without stress."""


@dataclass(frozen=True, eq=False)
class NeoHookean:
    """Moduli in Pa, each (E,)."""

    shear: Array
    lame: Array  # λ; 20 times the shear modulus is a Poisson's ratio of 0.476

    def energy(self, gradients: Array) -> Array:
        volume = np.linalg.det(gradients)
        safe = np.where(volume > 0.0, volume, 1.0)
        trace = np.einsum("eqij,eqij->eq", gradients, gradients)
        mu, lame = self.shear[:, None], self.lame[:, None]
        found = 0.5 * mu * (trace - 3.0 - 2.0 * np.log(safe)) + 0.5 * lame * (safe - 1.0) ** 2
        return np.asarray(np.where(volume > 0.0, found, np.inf))

    def growth(self, gradients: Array) -> Array:
        return np.asarray(np.linalg.det(gradients))

    def response(self, gradients: Array) -> Response:
        volume = np.linalg.det(gradients)[..., None, None]
        inverse = np.linalg.inv(gradients).swapaxes(-1, -2)  # F⁻ᵀ
        mu, lame = self.shear[:, None, None, None], self.lame[:, None, None, None]
        stress = mu * (gradients - inverse) + lame * (volume - 1.0) * volume * inverse
        mu, lame, volume = mu[..., None, None], lame[..., None, None], volume[..., None, None]
        crossed = np.einsum("eqil,eqkj->eqijkl", inverse, inverse)
        along = np.einsum("eqij,eqkl->eqijkl", inverse, inverse)
        stiffness = mu * _IDENTITY + (mu - lame * volume * (volume - 1.0)) * crossed
        stiffness += lame * volume * (2.0 * volume - 1.0) * along
        shape = gradients.shape[:2]
        return self.energy(gradients), stress.reshape(*shape, 9), stiffness.reshape(*shape, 9, 9)


@dataclass(frozen=True, eq=False)
class Membrane:
    """Skin on facets, unstressed in the reference."""

    stiffness: Array  # (E,) N/m: shear modulus times thickness
    tangents: Array  # (E, Q, 3, 2) orthogonal, longer than 1 where skin is taut without displacements

    def energy(self, gradients: Array) -> Array:
        stretched = gradients @ self.tangents
        metric = stretched.swapaxes(-1, -2) @ stretched
        area = np.linalg.det(metric)
        trace = np.trace(metric, axis1=-2, axis2=-1)
        found = 0.5 * self.stiffness[:, None] * (trace + 1.0 / np.maximum(area, 1e-12) - 3.0)
        return np.asarray(np.where(area > 1e-6, found, np.inf))

    def growth(self, gradients: Array) -> Array:
        stretched = gradients @ self.tangents
        return np.asarray(np.sqrt(np.linalg.det(stretched.swapaxes(-1, -2) @ stretched)))

    def response(self, gradients: Array) -> Response:
        stretched = gradients @ self.tangents  # (E, Q, 3, 2)
        inverse = np.linalg.inv(stretched.swapaxes(-1, -2) @ stretched)
        thinned = np.linalg.det(inverse)[..., None, None]
        lifted = stretched @ inverse
        size = self.stiffness[:, None, None, None]
        stress = size * (stretched - thinned * lifted) @ self.tangents.swapaxes(-1, -2)
        across = lifted @ stretched.swapaxes(-1, -2)  # projector on the deformed tangent plane
        thinned = thinned[..., None, None]
        flat = np.eye(3)[:, None, :, None] * np.eye(2)[None, :, None, :]
        flat = flat - thinned * np.einsum("eqik,eqab->eqiakb", np.eye(3) - across, inverse)
        flat = flat + thinned * np.einsum("eqib,eqka->eqiakb", lifted, lifted)
        flat = flat + 2.0 * thinned * np.einsum("eqia,eqkb->eqiakb", lifted, lifted)
        turned = np.einsum("eqja,eqiakb,eqlb->eqijkl", self.tangents, flat, self.tangents, optimize=True)
        shape = gradients.shape[:2]
        stiffness = size[..., None, None] * turned
        return self.energy(gradients), stress.reshape(*shape, 9), stiffness.reshape(*shape, 9, 9)


_IDENTITY = np.einsum("ik,jl->ijkl", np.eye(3), np.eye(3))

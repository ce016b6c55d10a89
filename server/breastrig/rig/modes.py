"""Smooth modes: how breasts differ from what bones and shapes can show, alike over a few centimetres of skin.

The misfit is a Gaussian process on the template, u(v) in metres, whose values at some landmarks are its unknowns
(inducing points: Quiñonero-Candela and Rasmussen, 2005), k(v, w) = exp(−|v − w|² / 2 ℓ²) max(0, n_v·n_w):

    u_a(v) = Σ_l (K^-½ k(·, v))_l m_la,        m ~ N(0, 1), K = 3 L of them, three axes a for each landmark l

Landmarks over bones have none: they say where the bones are.  Evidence: docs/decisions/0039.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.settings_file import Positive, SettingsPart
from breastrig.core.stances import split_side
from breastrig.geometry.normals import vertex_normals
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig, Shape

JITTER = 1e-6  # of the deviation's square: two landmarks may lie on one place


class ModeSizes(SettingsPart):
    """modes.toml beside a rig."""

    width: Positive  # m, ℓ
    along: Positive  # m, standard deviation on each axis along the skin
    across: Positive  # m, of its height
    symmetry: Positive  # expected difference between the sides, of one deviation
    landmarks: tuple[str, ...]  # on soft tissue, without their side; a rig that lacks one has no modes


@lru_cache(maxsize=8)
def mode_sizes(rig: Rig) -> ModeSizes | None:
    """The sizes of the rig's modes; None for a rig without any."""
    found = known_part(rig, "modes.toml", ModeSizes)
    return found if found is not None and rig.has_landmarks(found.landmarks) else None


def mode_count(rig: Rig) -> int:
    """K."""
    return len(with_modes(rig).shapes) - len(rig.shapes)


@lru_cache(maxsize=8)
def with_modes(rig: Rig) -> Rig:
    """The rig with its modes as further shapes, after its own; itself where it has none."""
    sizes = mode_sizes(rig)
    if sizes is None:
        return rig
    landmarks = [each for each in rig.landmarks if split_side(each.name)[0] in sizes.landmarks]
    normals = vertex_normals(rig.template, rig.faces)
    points = rig.landmark_points(tuple(each.name for each in landmarks))
    places = points.positions(rig.template, rig.faces)
    facing = points.directions(normals, rig.faces)

    def alike(at: Array, looking: Array) -> Array:
        squares = ((at[:, None] - places) ** 2).sum(axis=2)
        return np.asarray(np.exp(-0.5 * squares / sizes.width**2) * np.clip(looking @ facing.T, 0.0, 1.0))

    values, vectors = np.linalg.eigh(alike(places, facing) + JITTER * np.eye(len(places)))
    shares = alike(rig.template, normals) @ (vectors / np.sqrt(values)) @ vectors.T  # (V, L)
    upright = np.einsum("vi,vj->vij", normals, normals)
    moves = sizes.along * np.eye(3) + (sizes.across - sizes.along) * upright  # (V, 3, 3) of the three axes
    signs = np.ones((len(places), 3))
    signs[[index for index, each in enumerate(landmarks) if split_side(each.name)[1] == "R"], 0] = -1.0
    names = [(f"mode_{each.name}_{axis}", f"mode_{each.mirror}_{axis}") for each in landmarks for axis in "xyz"]
    shapes = [Shape(name, "mode", -np.inf, np.inf, 1.0, mirror, "") for name, mirror in names]
    modes = np.einsum("vl,vji,li->livj", shares, moves, signs).reshape(-1, *rig.template.shape)
    return replace(rig, blendshapes=np.concatenate([rig.blendshapes, modes]), shapes=(*rig.shapes, *shapes))

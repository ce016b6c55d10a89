"""How the chest lies under a breast, given the skin around it: estimated on women who are also made without breasts.

The map treats the three coordinates alike and is not shown the breasts, so that their weight does not pull the chest.
It departs from the smoothest sheet through the places around (ridge regression).  Half of the women estimate it, a
quarter (validation) chooses the penalty, a quarter tests it (docs/decisions/0021).
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree
from steps.operators import laplacian, smoothed, thin_plate
from steps.source import Array, Booleans, Integers, Source
from virtual_patient.sampled import sampled
from virtual_patient.woman import vertices_of

from breastrig.geometry.normals import vertex_normals
from breastrig.rig.model import Rig
from breastrig.volume.bare_chest import BareChest

SMALLEST, FIRMEST = (-1.0, -1.0), (1.0, 1.0)
MIRROR = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Women:
    """(N, V, 3) m each, standing, on the rig's vertices."""

    whole: Array
    bare: Array  # with the breast dials at their smallest, and what that leaves of a breast smoothed away

    def part(self, first: int, step: int) -> "Women":
        return Women(self.whole[first::step], self.bare[first::step])


def made(rig: Rig, source: Source, mix: csr_matrix, count: int) -> Women:
    """`mix`: MakeHuman's vertices -> the rig's."""
    whole, bare = [], []
    for number in range(count):
        woman = sampled(number)
        others = tuple(detail for detail in woman.details if not detail[0].startswith("breast/"))
        small = mix @ vertices_of(source, replace(woman, cup=SMALLEST, firmness=FIRMEST, details=others))
        whole.append(mix @ vertices_of(source, woman))
        bare.append(thin_plate(small, breasts(rig), *laplacian(small, rig.faces)))
    return Women(np.array(whole), np.array(bare))


def estimated(rig: Rig, women: Women, recipe: dict[str, Any]) -> BareChest:
    """Prints how far off it is."""
    away = cKDTree(rig.template[breasts(rig)]).query(rig.template)[0]
    arm = np.isin(np.arange(len(away)), np.concatenate([rig.regions["arm_L"], rig.regions["arm_R"]]))
    under = np.flatnonzero((away < recipe["fade"]) & ~arm)
    around = _spread(rig, np.flatnonzero((away >= recipe["reach"]) & ~arm), recipe["apart"])
    fade = 1.0 - away[under] / recipe["fade"]
    flat = thin_plate(rig.template, breasts(rig), *laplacian(rig.template, rig.faces))
    sheet = RBFInterpolator(flat[around], np.eye(len(around)), kernel="linear", degree=1)(flat[under])

    development, validation, test = women.part(0, 2), women.part(1, 4), women.part(3, 4)
    sides = [(development.whole, development.bare)]
    sides += [tuple(each[:, rig.mirror_vertices] * MIRROR for each in sides[0])]
    whole, bare = (np.concatenate(each) for each in zip(*sides, strict=True))
    middle = whole[:, around].mean(axis=1, keepdims=True)
    at, goal = (
        (each - middle).transpose(0, 2, 1).reshape(-1, each.shape[1]) for each in (whole[:, around], bare[:, under])
    )

    def of(penalty: float) -> BareChest:
        extra = np.linalg.solve(at.T @ at + penalty * np.eye(len(around)), at.T @ (goal - at @ sheet.T)).T
        return BareChest(under, np.round(fade * fade * (3.0 - 2.0 * fade), 3), around, np.round(sheet + extra, 4))

    rng = np.random.default_rng(0)
    fitted = [Women(each.whole + _noise(rig, len(each.whole), recipe, rng), each.bare) for each in (validation, test)]
    best = min(recipe["penalties"], key=lambda penalty: float(np.abs(_gaps(rig, of(penalty), fitted[0])).mean()))
    for name, bodies in (("their skin", test), ("a fit's skin", fitted[1])):
        gaps = 1e3 * np.abs(_gaps(rig, of(best), bodies))
        print(f"Chests under breasts from {name}: {gaps.mean():.1f} mm off, 95 % {np.percentile(gaps, 95):.1f}.")
    print(f"Penalty {best}, {len(around)} places around.")
    return of(best)


def breasts(rig: Rig) -> Booleans:
    """(V,)"""
    return np.isin(np.arange(len(rig.template)), np.concatenate([rig.regions["breast_L"], rig.regions["breast_R"]]))


def _gaps(rig: Rig, chest: BareChest, women: Women) -> Array:
    """(N, B) m along the normal, under the bases of the breasts: above 0 in front of the true chest."""
    inside = breasts(rig)
    return np.array(
        [
            np.einsum("vi,vi->v", chest.of(whole) - bare, vertex_normals(bare, rig.faces))[inside]
            for whole, bare in zip(women.whole, women.bare, strict=True)
        ]
    )


def _noise(rig: Rig, count: int, recipe: dict[str, Any], rng: np.random.Generator) -> Array:
    """(count, V, 3) m: how fits are off, smooth along the skin."""
    stiffness, area = laplacian(rig.template, rig.faces)
    field = rng.normal(size=(len(area), 3 * count)) / np.sqrt(area)[:, None]
    even = smoothed(field, stiffness, area, recipe["noise_spread"])
    return (recipe["noise"] * even / even.std(axis=0)).reshape(len(area), count, 3).transpose(1, 0, 2)


def _spread(rig: Rig, vertices: Integers, apart: float) -> Integers:
    """Some of the vertices and their mirror images, that far apart (m) from each other."""
    chosen: list[int] = []
    for vertex in vertices[rig.template[vertices, 0] > -1e-6]:
        if not chosen or np.linalg.norm(rig.template[chosen] - rig.template[vertex], axis=1).min() > apart:
            chosen.append(int(vertex))
    return np.unique(np.concatenate([chosen, rig.mirror_vertices[chosen]]))

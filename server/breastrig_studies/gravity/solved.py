"""One woman's breasts at rest in four positions: unloaded, standing, supine and prone.

Stiffness is drawn from what was published (tissue.toml): nobody knows it of a woman who was only scanned.
"""

import tomllib
from contextlib import suppress
from dataclasses import dataclass
from importlib import resources
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.model import Rig
from breastrig.volume.gravity.breast_mesh import BreastMesh, block, chest_wall
from breastrig.volume.gravity.statics import NoEquilibrium, SoftBody, Tissue, unloaded

DIRECTIONS = {"standing": (0.0, -1.0, 0.0), "supine": (0.0, 0.0, -1.0), "prone": (0.0, 0.0, 1.0)}
G = 9.81  # m/s²
GLAND = 0.035  # m, how far gland reaches behind the nipple
STIFFER, TRIES = 2.0, 4
NEAR = 0.002  # m in the mean: how near she stands to the shape that was given; hers counts
TILT = np.radians(5.0)  # standard deviation of how a trunk leans in any position


@dataclass(frozen=True)
class Stiffness:
    """As drawn for one woman."""

    fat: float  # Pa, shear modulus
    gland: float  # times fat's
    fascia: float  # times fat's: the layer on the chest wall, in which the breast slides
    skin: float  # N/m
    depth: float  # m of tissue between wall and skin beside the breast


def drawn(rng: np.random.Generator, table: dict[str, Any]) -> Stiffness:
    """From the distributions of tissue.toml."""

    def lognormal(name: str) -> float:
        return float(table[name]["median"] * np.exp(table[name]["log_sd"] * rng.normal()))

    return Stiffness(
        **{name: lognormal(name) for name in ("fat", "gland", "fascia", "skin")},
        depth=float(rng.uniform(*table["depth"]["range"])),
    )


def published() -> dict[str, Any]:
    """The distributions with their sources."""
    return tomllib.loads((resources.files("breastrig.volume.gravity") / "tissue.toml").read_text("utf-8"))


def solved(rig: Rig, mesh: BreastMesh, vertices: Array, rng: np.random.Generator) -> dict[str, Array]:
    """Displacements (m) from (V, 3) m standing vertices, by position: of the block's skin vertices and of its points.

    The stiffness is drawn again, STIFFER each time, where nothing unloaded sinks into the standing shape: a breast
    that stands up so is not so soft.  Raises NoEquilibrium after TRIES.
    """
    stiffness = drawn(rng, published())
    down, *others = (exp_so3(TILT * rng.normal(size=3)) @ (G * np.array(way)) for way in DIRECTIONS.values())
    points = block(chest_wall(mesh, vertices, stiffness.depth), vertices[mesh.columns])
    share = gland(mesh, rig)
    for factor in STIFFER ** np.arange(TRIES):
        shear = factor * stiffness.fat * (1.0 + (stiffness.gland - 1.0) * share)
        shear[: 3 * len(mesh.triangles)] = factor * stiffness.fat * stiffness.fascia
        tissue = Tissue(shear, factor * stiffness.skin, stretch=1.1)

        def body_at(place: Array, tissue: Tissue = tissue) -> SoftBody:
            return SoftBody(place, mesh.tetrahedra, mesh.surface, mesh.held, tissue)

        with suppress(NoEquilibrium):
            body, standing = unloaded(points, body_at, down, NEAR)
            supine = body.at_rest(others[0])
            prone = body.at_rest(others[1], supine)  # hangs about as far as it sank
            skin = body.on_surface(mesh.surface[mesh.located[0]], mesh.located[1])
            found = {"unloaded": -standing, "supine": supine - standing, "prone": prone - standing}
            moved_to = body.between(body.mesh.p.T - points) + standing  # where she stands, from where she was to stand
            return (
                {f"{name}_skin": skin @ moved for name, moved in found.items()}
                | {f"{name}_points": moved[: len(points)] for name, moved in found.items()}
                | {
                    "given": vertices,
                    "standing_skin": skin @ moved_to,
                    "stiffness": np.array([factor, *vars(stiffness).values()]),
                }
            )
    raise NoEquilibrium("This shape does not stand, however stiff it is.")


def gland(mesh: BreastMesh, rig: Rig) -> Array:
    """(T,) share of gland: most behind the nipple, none at the breast's edge."""
    at = block(chest_wall(mesh, rig.template, 0.015), rig.template[mesh.columns])[mesh.tetrahedra].mean(axis=1)
    nipple = rig.template[rig.regions[f"areola_{mesh.side}"]].mean(axis=0)
    return np.asarray(np.exp(-0.5 * (np.linalg.norm(at - nipple, axis=1) / GLAND) ** 2))

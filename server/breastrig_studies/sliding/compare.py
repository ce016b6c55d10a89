"""How far off are tumours carried from prone to supine, by today's map and by what else could be known?

python -m breastrig_studies.sliding.compare TABLE.csv COHORT [COHORT ...]

Each patient with tumours.json is fitted prone and supine (supine_physics) with the true landmarks. The chest wall is
that of PATIENT/prone/wall.ply; of patients without, the height over it that tumours.json states. One row a patient and
way, one line a group in the output. Ways:

- `map`: without a wall. `held`: as the program carries with a wall that is seen. `held_estimated`: the same over the
  wall that the fit estimates.
- `fraction`: the wall rigidly with the breastbone, depth between it and the skin kept as a fraction.
- `field`: `map`, and a linear field of what it misses, by its own motion and depth; `field_on_wall`: `held` with the
  strength of three layers for its one. Both learned on the lattices of the development bodies.
- `dense`: the spline through the true skin of both, which no scan shows.
"""

import csv
import json
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from scipy.interpolate import RBFInterpolator

from breastrig.core.arrays import Array, Booleans
from breastrig.core.units import METRES_PER_UNIT
from breastrig.drawings.line_error import carried_errors
from breastrig.drawings.skin_maps.interior_map import held, moved_inside, over, with_breastbone
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig.volume.known_volume import known_volume
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import DEVELOPMENT, Case, read_cohort
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.transfer import fitted

FROM, TO = "prone", ("supine_physics", "supine")
NODES, SEED = 400, 0  # of a lattice, to learn on
SKIN = 2500  # points of the true skin
NEAR = 0.015  # m over the wall
MOVED = 0.002  # m: nodes that move less teach nothing
PENALTY = {"field": 1e-4, "field_on_wall": 1e-5}
COLUMNS = ("group", "patient", "way", "tumours", "mean_mm", "p95_mm", "held", "near_wall", "near_mean_mm", "near_held")


@dataclass(frozen=True, eq=False)
class Carried:
    """One patient's tumours, and nodes of its lattice after them; lengths in m, in the frame of the supine scan."""

    name: str
    group: str
    tumours: int
    true: Array  # (M, 3)
    ways: dict[str, Array]  # (M, 3) each
    fast: Array  # (M, 3) rigidly with the breastbone
    height: Array  # (M,) over the wall
    depth: Array  # (M,) share of the way from skin to wall
    axes: Array  # (3, 3) of the body, in columns
    side: Array  # (M,) 1 left, -1 right
    radius: Array  # (M,)

    def layers(self) -> Array:
        """(M, 3) layers on the wall."""
        return np.stack([self.depth, self.depth**3, np.exp(-self.height / 0.012)], axis=1)

    def mirrored(self, vectors: Array) -> Array:
        """(M, 3) vectors along the body's axes, right ones as if they were left; and back, for it is its own inverse
        but for the axes."""
        return np.asarray(vectors @ self.axes * np.stack([self.side, *2 * [np.ones_like(self.side)]], axis=1))

    def features(self) -> Array:
        """(M, 16) of the field: its own motion and a constant, by layers and without."""
        motion = self.mirrored(self.ways["map"] - self.fast)
        each = np.concatenate([motion, np.full((len(motion), 1), 0.01)], axis=1)
        layers = np.concatenate([np.ones((len(motion), 1)), self.layers()], axis=1)
        return np.asarray(np.einsum("ml,mi->mli", layers, each).reshape(len(motion), -1))


def carried(place: Path, cases: dict[str, Case], rig: Rig, recipe: Recipe) -> Carried:
    """The tumours of the patient in this folder by all ways that need no learning."""
    tumours = json.loads((place / "tumours.json").read_text("utf-8"))["tumours"]
    b = next(name for name in TO if name in cases)
    scenes = [read_scene(cases[name]) for name in (FROM, b)]
    a_fit, b_fit = (fitted(rig, recipe, scene, scene.landmarks) for scene in scenes)
    count = len(tumours)
    points, true = (1e-3 * np.array([each["center"][name] for each in tumours]) for name in (FROM, b))
    if (place / "volume.npz").is_file():
        here, there = (in_scan(place / name, at) for name, at in nodes(place / "volume.npz", (FROM, b)).items())
        points, true = np.concatenate([points, here]), np.concatenate([true, there])
    both = moved_inside(rig, a_fit, b_fit, np.concatenate([points, a_fit.vertices]))
    found, skin = both[: len(points)], both[len(points) :]
    fast = with_breastbone(rig, a_fit.vertices, skin, points)
    estimated = over(ClosestPointSearch(estimated_wall(rig, a_fit.vertices), rig.faces), points)
    if (place / FROM / "wall.ply").is_file():
        wall = trimesh.load(place / FROM / "wall.ply", process=False)
        per_unit = METRES_PER_UNIT[cases[FROM].unit]
        height = over(ClosestPointSearch(per_unit * np.asarray(wall.vertices), np.asarray(wall.faces)), points)
    else:
        height = 1e-3 * np.array([each["wall_mm"][FROM] for each in tumours])
    to_skin = a_fit.search(rig).query(points).distances
    share = height / (height + to_skin)
    said = carried_errors(rig, a_fit, b_fit, points, found, on_skin=False)
    assert said is not None
    axes = umeyama(rig.template, b_fit.vertices).rotation
    own = umeyama(rig.template, a_fit.vertices).rotation
    ways = {
        "map": found,
        "held": held(rig, found, fast, height),
        "held_estimated": held(rig, found, fast, estimated),
        "fraction": fast + share[:, None] * (found - fast),
        "dense": dense(scenes[0].truth, scenes[1].truth, points),
    }
    side = np.sign((points - a_fit.vertices.mean(axis=0)) @ own[:, 0])
    group = cases[FROM].group or f"given, {cases[FROM].family}"
    return Carried(place.name, group, count, true, ways, fast, height, 1.0 - share, axes, side, said)


def nodes(file: Path, names: tuple[str, str]) -> dict[str, Array]:
    """(NODES, 3) m of each stance, body coordinates."""
    volume = np.load(file)
    moving = np.linalg.norm(volume[names[0]] - volume[names[1]], axis=1) > MOVED
    chosen = np.random.default_rng(SEED).choice(np.flatnonzero(moving), NODES, replace=False)
    return {name: volume[name][chosen].astype(np.float64) for name in names}


def in_scan(folder: Path, points: Array) -> Array:
    """(M, 3) m of body coordinates in the scan's frame."""
    case = json.loads((folder / "case.json").read_text("utf-8"))
    placed, per_unit = np.array(case["body_mm_to_scan"]), METRES_PER_UNIT[case["unit"]]
    return np.asarray(per_unit * (1e3 * points @ placed[:3, :3].T + placed[:3, 3]))


def estimated_wall(rig: Rig, vertices: Array) -> Array:
    """(V, 3) m: as volume/tetrahedra.py has it, turned as a whole."""
    known = known_volume(rig)
    inwards = known.points[len(vertices) : 2 * len(vertices)] - known.chest.of(rig.template)
    return np.asarray(known.chest.of(vertices) + inwards @ umeyama(rig.template, vertices).rotation.T)


def dense(a: ClosestPointSearch | None, b: ClosestPointSearch | None, points: Array) -> Array:
    """(M, 3) m by the spline through the true skin."""
    assert a is not None
    assert b is not None
    chosen = np.random.default_rng(SEED).choice(len(a.vertices), min(SKIN, len(a.vertices)), replace=False)
    return np.asarray(RBFInterpolator(a.vertices[chosen], b.vertices[chosen], kernel="linear", degree=1)(points))


def learn(found: list[Carried]) -> None:
    """Adds the ways that are learned on the development bodies, tumours and nodes alike."""
    own = [each for each in found if each.group == DEVELOPMENT]
    weights = [
        np.where(np.arange(len(each.true)) < each.tumours, each.tumours, len(each.true) - each.tumours) ** -0.5
        for each in own
    ]

    def solved(rows: list[Array], goals: list[Array], penalty: float) -> Array:
        at, goal = np.concatenate(rows), np.concatenate(goals)
        return np.asarray(np.linalg.solve(at.T @ at + penalty * np.eye(at.shape[1]), at.T @ goal))

    field = solved(
        [weight[:, None] * each.features() for each, weight in zip(own, weights, strict=True)],
        [
            weight[:, None] * each.mirrored(each.true - each.ways["map"])
            for each, weight in zip(own, weights, strict=True)
        ],
        PENALTY["field"],
    )
    layers = solved(
        [
            (weight[:, None, None] * (each.fast - each.ways["map"])[:, :, None] * each.layers()[:, None]).reshape(-1, 3)
            for each, weight in zip(own, weights, strict=True)
        ],
        [(w[:, None] * (each.true - each.ways["map"])).ravel() for each, w in zip(own, weights, strict=True)],
        PENALTY["field_on_wall"],
    )
    for each in found:
        miss = each.features() @ field * np.stack([each.side, *2 * [np.ones_like(each.side)]], axis=1)
        each.ways["field"] = each.ways["map"] + miss @ each.axes.T
        share = each.layers() @ layers
        each.ways["field_on_wall"] = each.ways["map"] + share[:, None] * (each.fast - each.ways["map"])


def row(parts: list[tuple[Array, Array, Booleans]]) -> dict[str, float | int | str]:
    """Numbers of (m off, m radius, near the wall)."""
    gap, radius, near = (np.concatenate(each) for each in zip(*parts, strict=True))
    return {
        "tumours": len(gap),
        "mean_mm": round(1e3 * float(gap.mean()), 2),
        "p95_mm": round(1e3 * float(np.percentile(gap, 95)), 2),
        "held": round(float((gap <= radius).mean()), 3),
        "near_wall": int(near.sum()),
        "near_mean_mm": round(1e3 * float(gap[near].mean()), 2) if near.any() else "",
        "near_held": round(float((gap <= radius)[near].mean()), 3) if near.any() else "",
    }


def part(each: Carried, way: str) -> tuple[Array, Array, Booleans]:
    gap = np.linalg.norm(each.ways[way] - each.true, axis=1)
    return gap[: each.tumours], each.radius[: each.tumours], each.height[: each.tumours] < NEAR


def main(table: Path, folders: Iterable[Path]) -> None:
    rig, recipe = read_rig(default_rig_path()), load_recipe("default")
    found = []
    for folder in folders:
        cases = read_cohort(folder)
        for place in sorted({case.folder.parent for case in cases}):
            if (place / "tumours.json").is_file():
                own = {case.name: case for case in cases if case.folder.parent == place}
                found.append(carried(place, own, rig, recipe))
    learn(found)
    with table.open("w", encoding="utf-8", newline="") as file:
        out = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        out.writeheader()
        for each in found:
            for way in each.ways:
                out.writerow({"group": each.group, "patient": each.name, "way": way} | row([part(each, way)]))
    for group in sorted({each.group for each in found}):
        for way in found[0].ways:
            said = row([part(each, way) for each in found if each.group == group])
            sys.stdout.write(f"{group}, {way}: " + ", ".join(f"{name} {value}" for name, value in said.items()) + "\n")


if __name__ == "__main__":
    given = arguments(__doc__, "TABLE", "COHORT...")
    main(Path(given.table), [Path(each) for each in given.cohort])

"""Writes the motion of skin when a body lies down (drawings/skin_maps): its mean and its variation.

    breastrig evaluate --warped 44 COHORT -o DIR --quick
    python model_assets/make_poses.py POSES
    python model_assets/make_poses.py HEAVY --women 12 --kind heavy
    python -m breastrig_studies.lying_motion DIR/warped POSES HEAVY [-o FILE]

Only of the development half. The mean is that of the first folder. It contains two ways of computing how a body lies
down, that of the given patients and that of the virtual cohort: it begins with the mean of both; then the skin map's
remaining error is added as far as both ways agree on it, so that nothing rests on one way of computing alone. Each body
counts as it is and mirrored.

The variation is the principal components of all folders' bodies about that mean, symmetric and antisymmetric ones. It
uses dense skin, also where no scan shows it.
"""

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.drawings.skin_maps.lying_motion import SCHEMA, Motions
from breastrig.drawings.skin_maps.skin_map import FittedScan, SkinMap, spread_out, within_reach
from breastrig.fitting.recipe import load_recipe
from breastrig.geometry.normals import face_normals, vertex_normals
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig_studies.cohort import DEVELOPMENT, Case, read_cohort
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.transfer import fitted, places

FILE = default_rig_path().with_suffix(".known") / "lying_motion.json"
APART = 0.02  # m, between the places
ROUNDS = 2  # of adding what both ways still get wrong; a third changes less than 0.1 mm
WIDTH = 0.025  # m, of the Gaussian over the points around a place
FEW = 20  # points within three widths; with fewer nothing is known of a place
KEPT = 12  # modes of variation; of the next ones none is larger than what a fit is off
FINER = 0.015  # m, between the places of these ways, and of the Gaussian around each
OFTEN = 0.3  # of the most that a vertex is known: one that is known less often says nothing of patients
LEAST = 3.0  # vertices around a place; where fewer are known its motion fades
ON_SKIN, SEEN_COSINE = 0.012, 0.5  # m, and cosine of 60 degrees, of a vertex on its true skin
SIDES = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]])
OURS = "cohort_"  # how the sources of our virtual cohort are named


@dataclass(frozen=True, eq=False)
class Pair:
    """M points of one body's skin, standing and lying."""

    standing: FittedScan
    lying: FittedScan
    points: Array  # (M, 3) m, on the standing scan
    true: Array  # (M, 3) m, where they are lying
    vertices: Integers  # (M,) the model's nearest


def pairs(rig: Rig, folder: Path) -> Iterator[tuple[dict[str, str], tuple[Scene, Scene], Pair]]:
    """The pairs of scans of the development half that show the whole torso, with the record of each patient."""
    for patient, cases in paired(folder):
        scenes = (read_scene(cases[0]), read_scene(cases[1]))
        fits = [fitted(rig, load_recipe("default"), scene, scene.landmarks) for scene in scenes]
        asked = places(rig, scenes, fits[0])
        nearest = np.asarray(cKDTree(fits[0].vertices).query(asked.points)[1], dtype=np.int64)
        yield patient, scenes, Pair(fits[0], fits[1], asked.points, asked.true, nearest)


def paired(folder: Path) -> Iterator[tuple[dict[str, str], tuple[Case, Case]]]:
    """Each patient's record with each pair of a standing and a supine scan, of the development half."""
    by_patient: dict[str, list[Case]] = {}
    for case in read_cohort(folder):
        by_patient.setdefault(case.patient, []).append(case)
    for patient, cases in by_patient.items():
        record = json.loads((folder / patient / "patient.json").read_text("utf-8"))
        if cases[0].group == DEVELOPMENT and record.get("capture", "ordinary") == "ordinary":
            standing, lying = ([case for case in cases if case.stance == name] for name in ("standing", "supine"))
            yield from ((record | {"name": patient}, pair) for pair in product(standing, lying))


def mean_at(rig: Rig, given: Sequence[Pair], at: Array, motion: Array) -> Array:
    """(N, 3) m along the body's axes: what is missing of the skin's motion on the mean around (N, 3) m `at`.

    With (V, 3) m `motion` expected; where that is 0 everywhere, all beyond the rigid motion is missing.
    """
    missing = [_missing(rig, pair, motion, carried=bool(motion.any())) for pair in given]
    where = np.concatenate([rig.template[pair.vertices] * side for pair in given for side in SIDES])
    off = np.concatenate([each * side for each in missing for side in SIDES])
    return _around(where, off, np.concatenate([np.full(len(each), 1.0 / len(each)) for each in missing * 2]), at)


def _missing(rig: Rig, pair: Pair, motion: Array, carried: bool) -> Array:
    """(M, 3) m along the body's axes: from where skin is `carried`, or only expected, to its true place."""
    way = SkinMap(rig, pair.standing, pair.lying, motion=motion[None])
    reached = way.to_b(pair.points) if carried else way.expected(pair.points)
    return np.asarray((pair.true - reached) @ umeyama(rig.template, pair.lying.vertices).rotation)


def _around(where: Array, off: Array, weight: Array, at: Array) -> Array:
    """(N, 3) m: the mean of what is `off` (M, 3) m around each of (N, 3) m `at`; 0 where there is little."""
    tree, found = cKDTree(where), np.zeros((len(at), 3))
    for k, place in enumerate(at):
        near = np.asarray(tree.query_ball_point(place, 3.0 * WIDTH), dtype=np.int64)
        if len(near) > FEW:
            share = weight[near] * np.exp(-0.5 * (np.linalg.norm(where[near] - place, axis=1) / WIDTH) ** 2)
            found[k] = share @ off[near] / share.sum()
    return found


def missing_of_the_model(rig: Rig, scenes: tuple[Scene, Scene], pair: Pair, motion: Array) -> tuple[Array, Booleans]:
    """((V, 3) m as _missing of the model's vertices, (V,) of which of them something is known)."""
    standing, lying = scenes[0].truth, scenes[1].truth
    assert standing is not None
    assert lying is not None
    vertices = pair.standing.vertices
    found = standing.query(vertices)
    normals = face_normals(standing.vertices, standing.triangles)[found.faces]
    along = np.einsum("vi,vi->v", normals, vertex_normals(vertices, rig.faces)) > SEEN_COSINE
    known = along & (found.distances < ON_SKIN) & within_reach(rig, vertices, vertices)
    true = found.on_mesh.positions(lying.vertices, lying.triangles)
    every = Pair(pair.standing, pair.lying, found.points, true, np.arange(len(vertices)))
    return _missing(rig, every, motion, carried=False), known


def differing(rig: Rig, women: Sequence[Sequence[tuple[Array, Booleans]]]) -> Motions:
    """The modes, one standard deviation each, in which patients, each given as pairs of (moves, known), vary most."""
    template, covered = rig.template, np.sum([known for given in women for _, known in given], axis=0)
    left = np.flatnonzero((covered > OFTEN * covered.max()) & (template[:, 0] > -1e-6))
    at, parts = template[left][spaced(template[left], FINER)], []
    for given in women:
        for moves, known in given:
            sides = []
            for side in SIDES:
                squares = ((at[:, None] - template * side) ** 2).sum(axis=2)
                share = np.exp(-0.5 * squares / FINER**2) * known
                sides.append(share @ (moves * side) / np.maximum(share.sum(axis=1), LEAST)[:, None])
            alike, against = sides[0] + sides[1], sides[0] - sides[1]
            parts.append(0.5 * np.array([alike, against]) / np.sqrt(len(given) * len(women)))
    found: list[tuple[float, int, Array]] = []
    for sign, each in zip((1, -1), np.moveaxis(np.array(parts), 1, 0), strict=True):
        _, sizes, ways = np.linalg.svd(each.reshape(len(each), -1), full_matrices=False)
        found += [(size, sign, size * way.reshape(-1, 3)) for size, way in zip(sizes, ways, strict=True)]
    best = sorted(found, key=lambda each: -each[0])[:KEPT]
    return Motions(at, np.array([way for _, _, way in best]), np.array([sign for _, sign, _ in best]))


def agreed(ways: Sequence[Array]) -> Array:
    """Each number as far as all of the `ways`, arrays of one shape, have it; 0 where they differ in sign."""
    stacked = np.array(ways)
    alike = np.abs(np.sign(stacked).sum(axis=0)) == len(stacked)
    return np.where(alike, np.sign(stacked[0]) * np.abs(stacked).min(axis=0), 0.0)


def spaced(points: Array, apart: float) -> Integers:
    """Indices of (M, 3) m points of which none is within `apart` of another, and all others are."""
    order = spread_out(points, len(points))
    farther = [
        np.linalg.norm(points[order[:k]] - points[order[k]], axis=1).min() >= apart for k in range(1, len(order))
    ]
    return order[: 1 + farther.index(False) if False in farther else len(order)]


def estimated(rig: Rig, ways: Mapping[str, Sequence[Pair]]) -> Motions:
    """The mean, from pairs by way of lying down."""
    known = np.unique(np.concatenate([pair.vertices for given in ways.values() for pair in given]))
    skin = np.abs(rig.template[known]) * [1.0, 0.0, 0.0] + rig.template[known] * [0.0, 1.0, 1.0]
    at = skin[spaced(skin, APART)]
    still = np.zeros_like(rig.template)
    moves = np.mean([mean_at(rig, given, at, still) for given in ways.values()], axis=0)
    for _ in range(ROUNDS):
        expected = Motions(at, moves[None], np.ones(1)).at(rig.template)[0]
        moves = moves + agreed([mean_at(rig, given, at, expected) for given in ways.values()])
    return Motions(at, moves[None], np.ones(1))


def main(folders: Sequence[Path], file: Path = FILE) -> None:
    """Fits the folders' pairs and writes the file."""
    rig = read_rig(default_rig_path())
    ways: dict[str, list[Pair]] = {}
    for patient, _, pair in pairs(rig, folders[0]):
        ways.setdefault("ours" if patient["source"].startswith(OURS) else "given", []).append(pair)
    mean = estimated(rig, ways)
    write(rig, mean, folders, file)


def write(rig: Rig, mean: Motions, folders: Sequence[Path], file: Path) -> None:
    """Writes the mean, and the variation over the folders' patients."""
    motion = mean.at(rig.template)[0]
    women: dict[tuple[Path, str], list[tuple[Array, Booleans]]] = {}
    for folder in folders:
        for patient, scenes, pair in pairs(rig, folder):
            of_patient = women.setdefault((folder, patient["name"]), [])
            of_patient.append(missing_of_the_model(rig, scenes, pair, motion))
    parts = {"mean": mean, "ways": differing(rig, [*women.values()])}
    document = {"schema": SCHEMA, "women": len(women)} | {
        name: {
            "places_mm": np.round(1e3 * motions.places, 1).tolist(),
            "moves_mm": np.round(1e3 * motions.moves, 1).tolist(),
            "signs": motions.signs.astype(int).tolist(),
        }
        for name, motions in parts.items()
    }
    file.write_text(json.dumps(document, indent=None, separators=(", ", ": ")) + "\n", "utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("-o", "--output", type=Path, default=FILE)
    options = parser.parse_args()
    main(options.folders, options.output)

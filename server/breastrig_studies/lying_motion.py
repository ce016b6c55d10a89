"""Writes how skin moves when a body lies down (drawings/skin_maps): the mean over pairs of stances whose skin is known.

    breastrig evaluate --warped 44 COHORT -o DIR --quick
    python -m breastrig_studies.lying_motion DIR/warped

Of the choosing half only.  Two ways of computing how a body lies down are in it, that of the given patients and that of
our virtual cohort.  They begin with the mean of both; then what the skin map still gets wrong is added, as far as both
ways agree on it, so that nothing is estimated that one way of computing alone says.  Each body counts as she is and
mirrored.
"""

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Integers
from breastrig.drawings.skin_maps.lying_motion import SCHEMA, LyingMotion
from breastrig.drawings.skin_maps.skin_map import FittedScan, SkinMap, spread_out
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.transfer import fitted, places

FILE = default_rig_path().with_suffix(".known") / "lying_motion.json"
APART = 0.02  # m, between the places
ROUNDS = 2  # of adding what both ways still get wrong; a third changes less than 0.1 mm
WIDTH = 0.025  # m, of the Gaussian over the points around a place
FEW = 20  # points within three widths; with fewer nothing is known of a place
OURS = "cohort_"  # how the sources of our virtual cohort are named


@dataclass(frozen=True, eq=False)
class Pair:
    """M points of one body's skin, standing and lying."""

    standing: FittedScan
    lying: FittedScan
    points: Array  # (M, 3) m, on the standing scan
    true: Array  # (M, 3) m, where they are lying
    vertices: Integers  # (M,) the model's nearest


def pairs(rig: Rig, folder: Path) -> dict[str, list[Pair]]:
    """By way of lying down, those of the choosing half whose scans show the whole torso."""
    found: dict[str, list[Pair]] = {}
    for patient, cases in _stances(folder):
        scenes = (read_scene(cases["standing"]), read_scene(cases["supine"]))
        fits = [fitted(rig, load_recipe("default"), scene, scene.landmarks) for scene in scenes]
        asked = places(rig, scenes, fits[0])
        nearest = np.asarray(cKDTree(fits[0].vertices).query(asked.points)[1], dtype=np.int64)
        way = "ours" if patient["source"].startswith(OURS) else "given"
        found.setdefault(way, []).append(Pair(fits[0], fits[1], asked.points, asked.true, nearest))
    return found


def _stances(folder: Path) -> Iterator[tuple[dict[str, str], dict[str, Case]]]:
    by_patient: dict[str, dict[str, Case]] = {}
    for case in read_cohort(folder):
        by_patient.setdefault(case.patient, {})[case.name] = case
    for patient, cases in by_patient.items():
        record = json.loads((folder / patient / "patient.json").read_text("utf-8"))
        if record["half"] == "choose" and record["capture"] == "ordinary" and cases.keys() >= {"standing", "supine"}:
            yield record, cases


def mean_at(rig: Rig, given: Sequence[Pair], at: Array, motion: Array) -> Array:
    """(N, 3) m along the body's axes: what is missing of the skin's motion on the mean around (N, 3) m `at`.

    With (V, 3) m `motion` expected; where that is 0 everywhere, all beyond the rigid motion is missing.
    """
    sides = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]])
    stand, missing, weights = [], [], []
    for pair in given:
        way = SkinMap(rig, pair.standing, pair.lying, motion=motion)
        reached = way.to_b(pair.points) if motion.any() else way.expected(pair.points)
        off = (pair.true - reached) @ umeyama(rig.template, pair.lying.vertices).rotation
        for side in sides:
            stand.append(rig.template[pair.vertices] * side)
            missing.append(off * side)
            weights.append(np.full(len(off), 1.0 / len(off)))
    where, off, weight = np.concatenate(stand), np.concatenate(missing), np.concatenate(weights)
    tree, found = cKDTree(where), np.zeros((len(at), 3))
    for k, place in enumerate(at):
        near = np.asarray(tree.query_ball_point(place, 3.0 * WIDTH), dtype=np.int64)
        if len(near) > FEW:
            share = weight[near] * np.exp(-0.5 * (np.linalg.norm(where[near] - place, axis=1) / WIDTH) ** 2)
            found[k] = share @ off[near] / share.sum()
    return found


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


def estimated(rig: Rig, ways: Mapping[str, Sequence[Pair]]) -> LyingMotion:
    """From pairs by way of lying down."""
    known = np.unique(np.concatenate([pair.vertices for given in ways.values() for pair in given]))
    skin = np.abs(rig.template[known]) * [1.0, 0.0, 0.0] + rig.template[known] * [0.0, 1.0, 1.0]
    at = skin[spaced(skin, APART)]
    still = np.zeros_like(rig.template)
    moves = np.mean([mean_at(rig, given, at, still) for given in ways.values()], axis=0)
    for _ in range(ROUNDS):
        expected = LyingMotion(at, moves).at(rig.template)
        moves = moves + agreed([mean_at(rig, given, at, expected) for given in ways.values()])
    return LyingMotion(at, moves)


def main(folder: Path, file: Path = FILE) -> None:
    """Fits the folder's pairs and writes the file."""
    rig = read_rig(default_rig_path())
    ways = pairs(rig, folder)
    motion = estimated(rig, ways)
    document = {
        "schema": SCHEMA,
        "pairs": {way: len(given) for way, given in ways.items()},
        "places_mm": np.round(1e3 * motion.places, 1).tolist(),
        "moves_mm": np.round(1e3 * motion.moves, 1).tolist(),
    }
    file.write_text(json.dumps(document, indent=None, separators=(", ", ": ")) + "\n", "utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

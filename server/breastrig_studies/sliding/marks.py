"""Measures lines between standing and lying beside marks, right ones and with one wrong pair: docs/decisions/0034.

python -m breastrig_studies.sliding.marks TABLE.csv COHORT [COHORT ...]

Marks are far from each other on the skin of chest and breasts that both scans show, each 2 mm off on each of them; of
eight, one is then 40 mm off.  Lines and picks are those of studies/transfer.py.  The test set is left out.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.documents import csv_table
from breastrig.drawings.line_error import carried_errors
from breastrig.drawings.skin_maps.skin_map import FittedScan, carried, shared_marks, spread_out
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.transfer import CLICK, SEED, Places, fitted, on_the_chest, places, seen

COUNTS = (0, 4, 8, 16)
MARK, WRONG, OF = 0.002, 0.04, 8  # m off, m that the wrong one is off, and of how many
STANCES = ("standing", "supine")
COLUMNS = ("patient", "group", "family", "picks", "marks", "wrong", "mean_mm", "p95_mm", "held", "radius_mm", "asked")

Pair = tuple[FittedScan, FittedScan]
Marks = tuple[Array, Array]  # (16, 3) m on each scan


def marks_on(scenes: tuple[Scene, Scene]) -> Marks:
    """The most marks, in an order in which the first ones are far from each other too."""
    rng, truth = np.random.default_rng(SEED), scenes[0].truth
    assert truth is not None
    shown = np.flatnonzero(on_the_chest(scenes[0]) & seen(scenes[0]) & seen(scenes[1]))
    chosen = shown[spread_out(truth.vertices[shown], max(COUNTS))]
    first, second = (np.array([_off(scene, vertex, rng) for vertex in chosen]) for scene in scenes)
    return first, second


def _off(scene: Scene, vertex: int, rng: np.random.Generator) -> Array:
    assert scene.truth is not None
    return scene.along_the_skin(scene.target.search.query(scene.truth.vertices[[vertex]]).points[0], MARK, rng)


def marked(pair: Pair, marks: Marks, count: int, wrong: Array | None = None) -> Pair:
    """The scans with the first marks; the second's first one elsewhere where it is wrong."""
    here, there = ({f"mark {k}": place for k, place in enumerate(each[:count])} for each in marks)
    there |= {} if wrong is None else {"mark 0": wrong}
    return replace(pair[0], marks=here), replace(pair[1], marks=there)


def rows(rig: Rig, pair: Pair, asked: tuple[Places, Places], marks: Marks, wrong: Array) -> Iterator[dict[str, Any]]:
    """One for each number of marks, and for one wrong pair."""
    for count, other in [*((count, None) for count in COUNTS), (OF, wrong)]:
        a, b = marked(pair, marks, count, other)
        found = shared_marks(rig, a, b)
        errors, radii = [], []
        for (first, second), lines in zip(((a, b), (b, a)), asked, strict=True):
            there = carried(rig, first, second, lines.points)
            errors.append(1e3 * np.linalg.norm(there - lines.true, axis=1))
            said = carried_errors(rig, first, second, lines.points, there, marks=found.followed)
            radii.append(np.full(len(there), np.nan) if said is None else 1e3 * said)
        error, radius = np.concatenate(errors), np.concatenate(radii)
        yield {
            "marks": count,
            "wrong": int(other is not None),
            "mean_mm": round(float(error.mean()), 2),
            "p95_mm": round(float(np.percentile(error, 95)), 2),
            "held": round(float((error < radius).mean()), 3),
            "radius_mm": round(float(np.median(radius)), 1),
            "asked": " ".join(name.removeprefix("mark ") for name, _ in found.asked),
        }


def of_woman(rig: Rig, cases: tuple[Case, Case]) -> Iterator[dict[str, Any]]:
    """The rows of one woman, with true picks and with picks 5 mm off."""
    scenes = read_scene(cases[0]), read_scene(cases[1])
    rng, recipe = np.random.default_rng(SEED), load_recipe("default")
    off = [{name: s.along_the_skin(place, CLICK, rng) for name, place in s.landmarks.items()} for s in scenes]
    marks = marks_on(scenes)
    wrong = scenes[1].along_the_skin(marks[1][0], WRONG, rng)
    asked: tuple[Places, Places] | None = None
    for picks, given in (("true", [scene.landmarks for scene in scenes]), ("5 mm off", off)):
        first, second = (fitted(rig, recipe, scene, each) for scene, each in zip(scenes, given, strict=True))
        asked = asked or (places(rig, scenes, first), places(rig, scenes[::-1], second))
        about = {"patient": cases[0].patient, "group": cases[0].group, "family": cases[0].family, "picks": picks}
        yield from (about | row for row in rows(rig, (first, second), asked, marks, wrong))


def pairs(cohort: Path) -> Iterator[tuple[Case, Case]]:
    """Of each woman the first standing and the first lying scan with a true surface."""
    cases = [case for case in read_cohort(cohort) if not case.held_out and (case.folder / "truth.ply").is_file()]
    for patient in dict.fromkeys(case.patient for case in cases):
        found = [[case for case in cases if (case.patient, case.stance) == (patient, each)] for each in STANCES]
        if all(found):
            yield found[0][0], found[1][0]


def main() -> None:
    given, rig = arguments(__doc__, "TABLE", "COHORT..."), read_rig(default_rig_path())
    found = [row for cohort in given.cohort for cases in pairs(Path(cohort)) for row in of_woman(rig, cases)]
    Path(given.table).write_bytes(csv_table(COLUMNS, found))


if __name__ == "__main__":
    main()

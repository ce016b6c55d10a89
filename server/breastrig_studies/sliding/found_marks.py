"""Measures small marks found by colour, and their pairs between standing and lying: docs/decisions/0036.

python -m breastrig_studies.sliding.found_marks TABLE.csv FOLDER HALF

Painted patients of a half (development | validation) are made in FOLDER, with dots, crosses and moles on both scans and
a plan's lines on every second standing one.  Fits have picks 5 mm off.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.colour.spots import find_spots
from breastrig.core.arrays import Array
from breastrig.core.documents import csv_table
from breastrig.drawings.marks.mark_pairs import SmallMarks, followed, paired
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.scan.read import read_scan
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.transfer import CLICK, fitted
from breastrig_studies.virtual.bodies import read_bodies
from breastrig_studies.virtual.case_files import moved, write_json
from breastrig_studies.virtual.painted import painted_patients
from breastrig_studies.virtual.painted.files import write_painted_case
from breastrig_studies.virtual.painted.make import draw_skin, painted_scan
from breastrig_studies.virtual.painted.small_marks import with_small
from breastrig_studies.virtual.scan import scan_body
from breastrig_studies.virtual.warped.make import Half

SEED, SIDE, SKINS = 20_261_129, 2048, 2  # of a patient
PLANS = ("none", "lumpectomy")  # by turns
STANCES = ("standing", "supine")
HIT = 4e-3  # m, within which a mark is found
FRECKLE = "freckle"  # neither wanted nor false
COLUMNS = ("patient", "tone", "plan", "true", "found", "false", "on_both", "pairs", "right")


def make_marked(folder: Path, half: Half) -> None:
    """PATIENT_SKIN/STANCE/{scan.zip, truth.ply, landmarks.json, case.json, marks.json}; those that are there stay.

    marks.json has kind, size (m) and place (m) of each mark, in the same order in both stances.
    """
    bodies = read_bodies()
    chosen = [(k, patient) for k, patient in enumerate(bodies.patients) if patient.name in painted_patients(half)]
    for index, number, patient in ((k, number, patient) for k, patient in chosen for number in range(SKINS)):
        place = folder / f"{patient.name}_{number}"
        if (place / "patient.json").is_file():
            continue
        seed, tone, plan = (SEED, index, number), 1 + (index + 3 * number) % 6, PLANS[(index + number) % 2]
        plain = draw_skin(patient.bodies[0], bodies.faces, np.random.default_rng(seed), tone, plan)
        both, alone, marks = with_small(plain, np.random.default_rng((*seed, 9)))
        for painted, body in zip((both, alone), patient.bodies, strict=True):
            random, here = np.random.default_rng((*seed, body.stance == "supine")), place / body.stance
            scan = scan_body(bodies, body, random)
            found = painted_scan(painted, body, scan, random, SIDE, inked=True)
            of_scan = (body, bodies.faces, scan, found.atlas, found.picture, painted.marks)
            placed = write_painted_case(here, *of_scan, True, "m", random, {"tone": tone, "plan": plan})
            at = [moved(each.place.positions(body.vertices, bodies.faces), placed)[0].tolist() for each in marks]
            listed = [[each.kind, each.size, *where] for each, where in zip(marks, at, strict=True)]
            (here / "marks.json").write_text(json.dumps(listed), "utf-8")
        write_json(place / "patient.json", {"family": "makehuman", "half": half, "virtual": True})


def row(rig: Rig, cases: tuple[Case, ...]) -> dict[str, Any]:
    """The numbers of one patient, of both scans together, on skin that the map follows."""
    recipe, fits, found, true, kinds = load_recipe("default"), [], [], [], np.zeros(0, dtype=np.str_)
    for case in cases:
        scene, rng = read_scene(case), np.random.default_rng(11)
        picks = {name: scene.along_the_skin(place, CLICK, rng) for name, place in scene.landmarks.items()}
        fits.append(fitted(rig, recipe, scene, picks))
        spots = find_spots(read_scan(case.scan, None, case.unit, for_display=False))
        places = np.array([spot.place for spot in spots]).reshape(-1, 3)
        colours = np.array([spot.colour for spot in spots]).reshape(-1, 3)
        found.append(SmallMarks(places, np.array([spot.size for spot in spots]), colours))
        listed = json.loads((case.folder / "marks.json").read_text("utf-8"))
        kinds = np.array([kind for kind, *_ in listed])
        true.append(np.array([place for _, _, *place in listed]))
    pairs = paired(rig, fits[0], fits[1], found[0], found[1])
    is_which = [_which(marks.places, places) for marks, places in zip(found, true, strict=True)]
    here, there = is_which[0][[pair.here for pair in pairs]], is_which[1][[pair.there for pair in pairs]]
    numbers, met = {"true": 0, "found": 0, "false": 0}, []
    for fit, marks, places, which in zip(fits, found, true, is_which, strict=True):
        followed_true = followed(rig, fit, SmallMarks(places, np.ones(len(places)), places)) & (kinds != FRECKLE)
        which = which[followed(rig, fit, marks)]
        met.append(set(which.tolist()) & set(np.flatnonzero(followed_true).tolist()))
        numbers["true"] += int(followed_true.sum())
        numbers["found"] += len(met[-1])
        numbers["false"] += int((which < 0).sum())
    about = json.loads((cases[0].folder / "case.json").read_text("utf-8"))
    right = int(((here == there) & (here >= 0)).sum())
    last = {"on_both": len(met[0] & met[1]), "pairs": len(pairs), "right": right}
    return {"patient": cases[0].patient, "tone": about["tone"], "plan": about["plan"]} | numbers | last


def _which(places: Array, true: Array) -> Any:
    """(M,) the number of the true mark at each of (M, 3) m places, -1 for none."""
    gaps = np.linalg.norm(places[:, None] - true, axis=2)
    return np.where(gaps.min(axis=1, initial=np.inf) < HIT, gaps.argmin(axis=1), -1)


def rows(rig: Rig, cohort: Path) -> Iterator[dict[str, Any]]:
    """One for each patient."""
    cases = read_cohort(cohort)
    for patient in dict.fromkeys(case.patient for case in cases):
        by_stance = {case.stance: case for case in cases if case.patient == patient}
        yield row(rig, tuple(by_stance[stance] for stance in STANCES))


def main() -> None:
    given = arguments(__doc__, "TABLE", "FOLDER", "HALF")
    make_marked(Path(given.folder), given.half)
    Path(given.table).write_bytes(csv_table(COLUMNS, list(rows(read_rig(default_rig_path()), Path(given.folder)))))


if __name__ == "__main__":
    main()

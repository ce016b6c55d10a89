"""Makes men of MakeHuman's adult dials, standing and lying: python model_assets/make_men.py FOLDER.

As make_poses.py makes women (virtual_patient/sampled.py), of statures of the survey ANSUR II; every other one has
gynaecomastia.  Men n with n % 3 == 2 are of the group `validation`, the others are what `breastrig model learn male
FOLDER` learns from.  A man who is there stays.
"""

import argparse
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
from make_cohort import HERE, LOWEST, Net, lying_turns, shared_net, standing_turns
from make_poses import landmarks, posed
from steps.source import Source, fetch, read_source
from virtual_patient.body import BOX, Body
from virtual_patient.sampled import man
from virtual_patient.woman import AVERAGE, Woman, vertices_of

from breastrig_studies.virtual.case_files import UNITS, write_case, write_json
from breastrig_studies.virtual.scan import Circumstances, scan_skin

GROUPS = ("development", "development", "validation")
FIRST = 5000  # number of the first man
STATURE, SPREAD = 1.756, 0.039  # m, and of its logarithm: 4,082 men of ANSUR II
BELOW = 0.004  # m to both sides of the nipple's meridian where his fold or the muscle's border is looked for
LARGER = 1.08  # of a man's trunk against a woman's, from pelvis to neck (steps/frame.py)
TALL = (BOX[0], LARGER * BOX[1], 1.15 * BOX[2])  # m


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--men", type=int, default=24)
    parser.add_argument("--part", default="0/1", help="K/N: only men k of each n, for several processes")
    options = parser.parse_args()
    wanted = tomllib.loads((HERE / "recipe.toml").read_text("utf-8"))["source"]
    source = read_source(fetch(wanted["wheel"], wanted["requirement"], wanted["sha256"], HERE / "sources"))
    net = shared_net(source, TALL, LOWEST, woman=replace(AVERAGE, sex="male"))
    part, parts = map(int, options.part.split("/"))
    for number in range(part, options.men, parts):
        place = options.folder / f"man_{number:03d}_{GROUPS[number % 3]}"
        if not (place / "patient.json").is_file():
            write_man(place, source, net, number)


def write_man(place: Path, source: Source, net: Net, number: int) -> None:
    """Both his scans; patient.json comes last."""
    random = np.random.default_rng((FIRST, number))
    him = with_arms(man(FIRST + number), random)
    skin, stature = vertices_of(source, him), STATURE * np.exp(SPREAD * random.standard_normal())
    body = Body(source, stature / np.ptp(skin[np.unique(source.quads), 1]) * skin, *net.fine)
    marks = landmarks(body, net, BELOW)
    for k, (name, turns) in enumerate((("standing", standing_turns(him)), ("supine", lying_turns(him)))):
        moved = posed(body, net, marks, him, name == "standing", turns)
        scan = scan_skin(moved, net.faces, net.scanned, random, Circumstances(every=2))
        write_case(place / name, moved, net.faces, scan, UNITS[k % 2], random, {})
    half = GROUPS[number % 3]
    about = {"family": "makehuman", "virtual": True, "half": half, "capture": "ordinary", "source": place.name}
    write_json(place / "patient.json", about | {"weight": him.weight, "muscle": him.muscle, "breasts": max(him.cup)})
    print(place.name)


def with_arms(him: Woman, random: np.random.Generator) -> Woman:
    """Standing and lying as the virtual cohort does."""
    left, right, lying_left, lying_right = (float(each) for each in random.normal((-7, -7, 8, 8), 3.0))
    lean = float(random.normal(0.0, 0.8))
    return replace(him, standing_arms=(left, right), lying_arms=(lying_left, lying_right), lean=lean)


if __name__ == "__main__":
    main()

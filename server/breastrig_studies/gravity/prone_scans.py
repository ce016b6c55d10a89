"""Prone scans of the bodies that were solved under gravity.

python -m breastrig_studies.gravity.prone_scans COHORT DATA

COHORT is a folder of make_gravity.py; DATA becomes a folder of cases for `breastrig evaluate DATA`. Their origin is not
that of virtual/warped/prone.py, whose field of view they have. Computed breasts hang a third as far as volunteers'
(docs/decisions/0020), so their motion to the front is enlarged.
"""

import sys
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from breastrig.core.arrays import Array
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.volume.breast_skin import MIRROR, breast_skins
from breastrig_studies.arguments import arguments
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.case_files import write_json
from breastrig_studies.virtual.warped.prone import draw_numbers, write_prone

FORWARDS = (1.5, 4.0)  # times the computed motion
SEED = 7


def hanging_skin(rig: Rig, file: Path, forwards: float) -> Array:
    """(V, 3) m from one body's file: standing, both breasts hanging `forwards` times as far as computed."""
    found = {name: np.asarray(values, dtype=np.float64) for name, values in np.load(file).items()}
    skin = found["given"].copy()
    for each in breast_skins(rig):
        mirror = MIRROR if each.side == "R" else np.ones(3)
        skin[each.skin] += found["prone_skin"] * mirror * [1.0, 1.0, forwards]
    return skin


def main(cohort: Path, data: Path) -> None:
    """Writes NAME/prone/{scan.ply, landmarks.json, case.json, truth.ply} and NAME/patient.json of each body."""
    rig = read_rig(default_rig_path())
    arms = rig.skin_weights[:, [k for k, name in enumerate(rig.bone_names) if name.startswith("upper_arm")]].sum(axis=1)
    for file in sorted(cohort.glob("[0-9]*[0-9].npz")):
        random = np.random.default_rng([SEED, int(file.stem)])
        numbers = replace(draw_numbers(random), forwards=float(random.uniform(*FORWARDS)))
        skin = hanging_skin(rig, file, numbers.forwards)
        places = dict(zip(rig.landmark_names, rig.landmark_points().positions(skin, rig.faces), strict=True))
        drawn = {"numbers": asdict(numbers)}
        place = data / f"gravity_{file.stem}"
        count = write_prone(place, VirtualBody("prone", skin, places, None), rig.faces, arms, numbers, drawn, random)
        write_json(place / "patient.json", {"virtual": True, "origin": "MakeHuman", "family": "makehuman", **drawn})
        sys.stdout.write(f"{place.name}: {count} triangles\n")


if __name__ == "__main__":
    given = arguments(__doc__, "COHORT", "DATA")
    main(Path(given.cohort), Path(given.data))

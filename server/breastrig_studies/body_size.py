"""Measures how often scans of a wrong scale, and of the right one, are questioned (fitting/verdicts/verdict.py).

python -m breastrig_studies.body_size DIR/poses [GROUP]

Each scan is fitted as it is, with all landmarks and with none; the fit and its scan are then scaled together.
"""

import sys
from pathlib import Path

import numpy as np

from breastrig.core.errors import FitFailed
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.verdicts.verdict import unusual_size, verdict_limits
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import read_cohort
from breastrig_studies.studies.case import read_scene

SCALES = (0.8, 0.9, 1.0, 1.1, 1.25, 1.4)


def main(folder: Path, group: str | None) -> None:
    """Prints a share for each scale."""
    rig, recipe = read_rig(default_rig_path()), load_recipe("default")
    asked: dict[str, list[list[bool]]] = {"all landmarks": [], "none": []}
    for case in read_cohort(folder):
        if case.held_out or group not in (None, case.group):
            continue
        scene = read_scene(case)
        for given, picks in zip(asked, (dict(scene.landmarks), {}), strict=True):
            try:
                fit = scene.fitted(rig, recipe, picks)
            except FitFailed:
                continue
            row = []
            for scale in SCALES:
                target = ScanTarget(scale * scene.target.vertices, scene.target.faces)
                found = unusual_size(verdict_limits(rig), rig, scale * fit.vertices, target, case.stance)
                row.append(bool(found))
            asked[given].append(row)
    for given, rows in asked.items():
        shares = zip(SCALES, np.array(rows).mean(axis=0), strict=True)
        said = ", ".join(f"{scale}: {100 * share:.0f} %" for scale, share in shares)
        sys.stdout.write(f"{len(rows)} fits, {given} given; asked about at {said}\n")


if __name__ == "__main__":
    given = arguments(__doc__, "FOLDER", "[GROUP]")
    main(Path(given.folder), given.group)

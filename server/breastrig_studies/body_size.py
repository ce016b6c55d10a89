"""How often a scan of a wrong scale is asked about, and one of the right scale (fitting/verdicts/size.py).

    python -m breastrig_studies.body_size DIR/poses [GROUP]

Each scan is fitted as it is, without landmarks; the fit and its scan are then scaled together.  Women of
model_assets/make_poses.py are brought to statures of the survey first, several times each, for MakeHuman's are 1.3 to
2.2 m tall.
"""

import json
import sys
from pathlib import Path

import numpy as np

from breastrig.core.errors import FitFailed
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.verdicts.verdict import unusual_size, verdict_limits
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig_studies.cohort import read_cohort
from breastrig_studies.studies.case import read_scene

SCALES = (0.8, 0.9, 1.0, 1.1, 1.25, 1.4)
STATURE, SPREAD = 1.628, 0.039  # m, and of its logarithm: 1,986 women of ANSUR II
DRAWS = 8  # statures for each scan


def main(folder: Path, group: str | None) -> None:
    """Prints a share for each scale."""
    rig, recipe, random = read_rig(default_rig_path()), load_recipe("default"), np.random.default_rng(0)
    asked: list[list[bool]] = []
    for case in read_cohort(folder):
        about = json.loads((folder / case.patient / "patient.json").read_text("utf-8"))
        if group not in (None, about.get("half")):
            continue
        scene = read_scene(case)
        try:
            fit = scene.fitted(rig, recipe, {})
        except FitFailed:
            continue
        own = about.get("stature_m")
        sizes = [1.0] if own is None else STATURE / own * np.exp(SPREAD * random.standard_normal(DRAWS))
        for size in sizes:
            row = []
            for scale in SCALES:
                target = ScanTarget(scale * size * scene.target.vertices, scene.target.faces)
                vertices = scale * size * fit.vertices
                row.append(bool(unusual_size(verdict_limits(rig), rig, vertices, target, case.stance)))
            asked.append(row)
    shares = np.array(asked).mean(axis=0)
    sys.stdout.write(
        f"{len(asked)} bodies; asked about at "
        + ", ".join(f"{s}: {100 * a:.0f} %" for s, a in zip(SCALES, shares, strict=True))
        + "\n"
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else None)

"""Writes how high the parts of lying bodies are above the table (fitting/body), over bodies whose skin is known.

    breastrig evaluate --warped 44 COHORT -o DIR --quick
    python -m breastrig.evaluation.lying_heights DIR/warped

Of both halves: how high a body lies differs from one woman to the next, and each half alone has too few of them to say
how it goes with what is seen.  Every woman counts alike, however many bodies were made of her; what it is worth was
measured on each woman with the others' bodies only (the preset's [lying]).
"""

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.evaluation.cohort import read_cohort
from breastrig.evaluation.studies.case import read_scene
from breastrig.evaluation.studies.reference_fit import reference_fit
from breastrig.fitting.body.lying_heights import SCHEMA, means_of, parts_of
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig

FILE = Path(__file__).parents[1] / "fitting" / "body" / "torso_lying_heights.json"


def learnt(rig: Rig, women: Mapping[str, Sequence[Array]]) -> dict[str, Any]:
    """The document of bodies' (G,) m heights by part, by woman."""
    rows = np.concatenate([np.array(given) for given in women.values()])
    shares = np.concatenate([np.full(len(given), 1.0 / len(given)) for given in women.values()]) / len(women)
    mean = shares @ rows
    _, sizes, directions = np.linalg.svd(np.sqrt(shares)[:, None] * (rows - mean), full_matrices=False)
    return {
        "schema": SCHEMA,
        "bodies": {woman: len(given) for woman, given in women.items()},
        "parts": [*parts_of(rig)],
        "mean_mm": np.round(1e3 * mean, 1).tolist(),
        "factors_mm": np.round(1e3 * sizes[:, None] * directions, 2).tolist(),
    }


def main(folder: Path, file: Path = FILE) -> None:
    """Fits the whole skin of the folder's lying bodies and writes the file."""
    rig, recipe = read_rig(default_rig_path()), load_recipe("default")
    parts, women = parts_of(rig), dict[str, list[Array]]()
    for case in read_cohort(folder):
        told = json.loads((folder / case.patient / "patient.json").read_text("utf-8"))
        if case.stance != "supine" or told["capture"] != "ordinary":
            continue
        scene = read_scene(case)
        table, whole = scene.target.table, reference_fit(scene, rig, recipe)
        if table is not None and whole is not None:
            heights = means_of(parts.values(), whole.vertices @ table.normal - table.height)
            women.setdefault(told["source"], []).append(heights)
    file.write_text(json.dumps(learnt(rig, women), indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

"""Writes the depth of hidden skin as a function of a lying belly's height (fitting/body), over bodies with known skin.

    breastrig evaluate --warped 44 COHORT -o DIR --quick
    python -m breastrig_studies.bodies.trunk_depth DIR/warped

Both halves are used, because few patients are deep: each half alone has one or two of them. The gain was measured on
each patient with the others' bodies only (fitting/body/refine.py). The bodies are fitted without landmarks; every
patient counts alike, however many bodies were made of one, and each body counts as it is and mirrored. For a body whose
belly lies a beyond ORDINARY, with hidden skin h above the model and the expectation over all bodies (hidden_skin.py),
the slope of a place is Σ a h / (Σ a² + DAMPING²). It goes through zero at ORDINARY, so that it does not depend on the
ways of computing how bodies lie down, which disagree about the height of an ordinary back.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.fitting.body.refine import DEPTH_SCHEMA, hidden_skin
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig_studies.arguments import arguments
from breastrig_studies.bodies.hidden_skin import FOLDER, hidden_heights, smoothed
from breastrig_studies.cohort import read_cohort
from breastrig_studies.studies.case import read_scene

# Hidden skin of the development half, no landmark given, each patient by the others, mean mm (5.9 without): 0.2125 m
# 5.3, 0.2175 5.4.  Below 0.2175 bodies that lie by finite elements get worse, 11.5 -> 11.8, who lie higher, not lower.
ORDINARY = 0.2175  # m, of the belly above the table
DAMPING = (
    0.015  # m: backs differ by 6 mm otherwise, slopes are about 0.4; with 0 one patient alone would make the slope
)
MOST = 0.05  # m beyond it; 0.041 is the most of any body, and a fit may have gone wrong
REACH = 0.11  # m; the backs of all bodies are fitted 0.03 to 0.08 above their table


@dataclass(frozen=True, eq=False)
class Body:
    excess: float  # m, of the belly beyond the ordinary
    hidden: Booleans  # (V,)
    heights: Array  # (V,) m of the true skin above what is expected


def estimated(rig: Rig, women: Mapping[str, Sequence[Body]]) -> dict[str, Any]:
    """The file's document."""
    products, squares, total = np.zeros(len(rig.template)), np.zeros(len(rig.template)), 0.0
    for bodies in women.values():
        for body in bodies:
            share = 1.0 / len(bodies)
            total += 2.0 * share * body.excess**2
            for side in (slice(None), rig.mirror_vertices):
                products += share * body.excess * np.where(body.hidden, body.heights, 0.0)[side]
                squares += share * body.excess**2 * body.hidden[side]
    skin = smoothed(rig, products / np.maximum(squares, 1e-12), squares / (total + 2.0 * DAMPING**2))
    return {
        "schema": DEPTH_SCHEMA,
        "bodies": {woman: len(bodies) for woman, bodies in women.items()},
        "ordinary_mm": round(1e3 * ORDINARY, 1),
        "most_mm": round(1e3 * MOST, 1),
        "reach_mm": round(1e3 * REACH, 1),
        "places_mm": np.round(1e3 * skin.places, 1).tolist(),
        "normals": np.round(skin.normals, 3).tolist(),
        "slopes": np.round(skin.heights, 4).tolist(),
    }


def main(folder: Path, into: Path = FOLDER) -> None:
    """Fits the folder's lying bodies and writes the file."""
    rig, recipe = read_rig(default_rig_path()), load_recipe("default")
    expected = hidden_skin(rig, "supine")
    if expected is None:
        raise SystemExit(
            f"Nothing is known of the hidden skin of {rig.name}: run breastrig_studies.bodies.hidden_skin first."
        )
    women = dict[str, list[Body]]()
    for case in read_cohort(folder):
        patient = json.loads((folder / case.patient / "patient.json").read_text("utf-8"))
        if case.held_out or (patient["capture"], case.stance) != ("ordinary", "supine"):
            continue
        scene = read_scene(case)
        if scene.target.table is None:
            continue
        vertices = scene.fitted(rig, recipe, {}).vertices
        above = vertices @ scene.target.table.normal - scene.target.table.height
        excess = max(float(above[rig.regions["belly"]].mean()) - ORDINARY, 0.0)
        hidden, heights = hidden_heights(scene, rig, vertices)
        women.setdefault(patient["source"], []).append(Body(excess, hidden, heights - expected))
    (into / "trunk_depth.json").write_text(json.dumps(estimated(rig, women)) + "\n", "utf-8")


if __name__ == "__main__":
    given = arguments(__doc__, "FOLDER")
    main(Path(given.folder))

"""Writes bodies.json (fitting/body): mean and covariance of scales and shapes over a folder of cases.

    breastrig evaluate --warped 73 --half development COHORT -o DIR --quick
    python -m breastrig_studies.bodies.body_statistics DIR/warped
    python -m breastrig_studies.bodies.body_statistics --beside DIR/poses DIR/women

Each body counts as it is and mirrored, so that no side is preferred; each patient counts alike, however many scans
there are. Standing and lying bodies each lose their own mean: the prior's centre knows the stance already. The
covariance is kept as its strongest directions. With --beside the file's bodies keep half of the weight. Of folders that
have groups only the development group is read.
"""

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.body_statistics import SCHEMA, BodyStatistics, body_statistics
from breastrig.rig.cohort_posterior import mirrored_places
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import read_cohort
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.reference_fit import reference_fit

FILE = default_rig_path().with_suffix(".known") / "bodies.json"
KEPT = 0.98  # of the variance


@dataclass(frozen=True, eq=False)
class KnownBody:
    """The fit to one scan whose whole skin is known."""

    woman: str
    stance: str
    parameters: RigParameters


def statistics(rig: Rig, bodies: Sequence[KnownBody]) -> BodyStatistics:
    """Mean and covariance over these bodies."""
    rows = np.array([np.concatenate([each.parameters.scales.ravel(), each.parameters.weights]) for each in bodies])
    times = Counter((each.woman, each.stance) for each in bodies)
    counts = np.array([1.0 / times[each.woman, each.stance] for each in bodies] * 2)
    stances = np.array([each.stance for each in bodies] * 2)
    rows = np.concatenate([rows, rows[:, mirrored_places(rig)]])
    deviations = rows.copy()
    for stance in np.unique(stances):
        its = stances == stance
        deviations[its] -= np.average(rows[its], axis=0, weights=counts[its])
    covariance = (deviations * counts[:, None]).T @ deviations / counts.sum()
    mean = np.average(rows[:, : 3 * len(rig.bones)], axis=0, weights=counts)
    return BodyStatistics(mean, covariance, len(bodies))


def mixed(first: BodyStatistics, second: BodyStatistics) -> BodyStatistics:
    """The average of both, each with half of the weight."""
    return BodyStatistics(
        0.5 * (first.mean_scales + second.mean_scales),
        0.5 * (first.covariance + second.covariance),
        first.bodies + second.bodies,
    )


def document(rig: Rig, known: BodyStatistics) -> dict[str, Any]:
    """The file's document."""
    return {
        "schema": SCHEMA,
        "bodies": known.bodies,
        "bones": list(rig.bone_names),
        "shapes": list(rig.shape_names),
        "mean_scales": np.round(known.mean_scales, 4).tolist(),
        "factors": np.round(_strongest(known.covariance), 5).tolist(),
    }


def _strongest(covariance: Array) -> Array:
    """(K, N) whose FᵀF is nearly the (N, N) covariance."""
    values, directions = np.linalg.eigh(covariance)
    values, directions = values[::-1], directions[:, ::-1].T
    count = int(np.searchsorted(np.cumsum(values) / values.sum(), KEPT)) + 1
    return np.asarray(np.sqrt(values[:count, None]) * directions[:count])


def known_bodies(folder: Path, rig: Rig, recipe: Recipe) -> Iterator[KnownBody]:
    """Fits to every case of the folder."""
    for case in read_cohort(folder):
        if not case.teaches:
            continue
        found = reference_fit(read_scene(case), rig, recipe)
        if found is not None:
            yield KnownBody(case.patient, case.stance, found.parameters)


def main(folders: Sequence[Path], beside: bool, file: Path = FILE) -> None:
    """Writes the file of these folders' bodies."""
    rig, recipe = read_rig(default_rig_path()), load_recipe("default")
    known = statistics(rig, [body for folder in folders for body in known_bodies(folder, rig, recipe)])
    before = body_statistics(rig) if beside else None
    known = known if before is None else mixed(before, known)
    file.write_text(json.dumps(document(rig, known)) + "\n", "utf-8")


if __name__ == "__main__":
    given = arguments(__doc__, "FOLDER...", "--beside")
    main([Path(each) for each in given.folder], given.beside)

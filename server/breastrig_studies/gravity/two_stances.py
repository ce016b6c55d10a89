"""Writes the second way of gravity.json (volume/predicted.py), from bodies that are known standing and lying:

    breastrig evaluate --warped 36 COHORT -o DIR --quick
    python model_assets/make_poses.py POSES --first 4000 --women 80 --part 0/2
    python -m breastrig_studies.gravity.two_stances DIR/warped POSES

They were laid down in two ways, neither of which is that of the first, solved bodies. Only of the development half;
each breast of each woman counts alike, the right one mirrored.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from breastrig.core.arrays import Array
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig.volume.breast_skin import MIRROR, breast_skins
from breastrig.volume.predicted import breast_presence, gravity_prior, in_template, posture
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import Case
from breastrig_studies.gravity.estimate import PLACE, Woman, gaussian, write
from breastrig_studies.lying_motion import paired
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.transfer import fitted

FACTORS = 6
OBSERVATION = 0.02  # m, as in estimate.py (docs/decisions/0020)


def women_in(rig: Rig, folder: Path) -> Iterator[Woman]:
    """Each breast of each woman of the development half, of her first pair of scans."""
    recipe = load_recipe("default")
    first: dict[str, tuple[Case, Case]] = {}
    for patient, cases in paired(folder):
        first.setdefault(patient["name"], cases)
    for cases in first.values():
        standing, lying = (read_scene(case) for case in cases)
        yield from breasts(rig, fitted(rig, recipe, standing, standing.landmarks), (standing, lying))


def breasts(rig: Rig, fit: FittedScan, scenes: tuple[Scene, Scene]) -> Iterator[Woman]:
    """Heights of the fitted standing breasts, and where the same skin truly lies: the body laid on how it should lie by
    the skin around the breasts."""
    standing, lying = scenes[0].truth, scenes[1].truth
    assert standing is not None
    assert lying is not None
    body, turn = in_template(rig, fit.vertices)
    on = standing.query(fit.vertices).on_mesh
    here, there = (on.positions(each.vertices, each.triangles) for each in (standing, lying))
    ring, goal = np.union1d(*(each.near for each in breast_skins(rig))), body + posture(rig, "supine")
    laid = (there - there[ring].mean(axis=0)) @ umeyama(there[ring], goal[ring]).rotation.T + goal[ring].mean(axis=0)
    moves: Array = laid - goal - (here - fit.vertices) @ turn.T
    for each in breast_skins(rig):
        side = MIRROR if each.side == "R" else np.ones(3)
        heights = each.heights(body) * side
        laid_heights = np.where(each.breast[:, None], each.heights(body + moves) * side, heights)
        if breast_presence(heights[each.breast]) == 1.0:
            yield Woman(0, {"standing": heights.ravel(), "supine": laid_heights.ravel()})


def main(folders: Sequence[Path], file: Path = PLACE) -> None:
    """Estimates and writes the file, whose first way stays."""
    rig = read_rig(default_rig_path())
    known = gravity_prior(rig)
    assert known is not None
    found = gaussian([woman for folder in folders for woman in women_in(rig, folder)], FACTORS, OBSERVATION)
    write(replace(known, ways=(known.ways[0], found)), file)


if __name__ == "__main__":
    given = arguments(__doc__, "FOLDER...")
    main([Path(each) for each in given.folder])

"""The example patient standing, her fit, and the fits of what is left of her scan when it is spoilt."""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.assets import asset_folder
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.least_squares.newton import Status
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose
from breastrig.scan.clean import clean
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan

EXAMPLE = asset_folder("example") / "standing"


def silent(recipe: Recipe) -> Recipe:
    """The recipe by which no pick tells of its partner on the other side."""
    return recipe.model_copy(update={"partners": {}})


def without_modes(recipe: Recipe) -> Recipe:
    """The recipe that moves bones and shapes alone."""
    return recipe.model_copy(
        update={"stages": tuple(each.model_copy(update={"free_modes": False}) for each in recipe.stages)}
    )


@dataclass(frozen=True, eq=False)
class Patient:
    rig: Rig
    vertices: Array  # (V, 3) m, centred; her left is +x, her head +y
    faces: Integers
    landmarks: dict[str, Array]
    chest: Integers  # model vertices of the breasts
    x: RigParameters  # the model on the unspoilt scan

    @property
    def fitted(self) -> Array:
        """(V, 3) m"""
        return pose(self.rig, self.x)

    def parameters(
        self,
        vertices: Array,
        faces: Integers,
        landmarks: dict[str, Array] | None = None,
        recipe: Recipe | None = None,
    ) -> RigParameters:
        """The model fitted to another scan of her, with all her landmarks or these, by the default recipe or this."""
        given = self.landmarks if landmarks is None else landmarks
        surface = clean(Scan(vertices, faces, "m", 1.0, "As asked for.", "0" * 64))
        target = ScanTarget(surface.vertices, surface.faces)
        start = start_from_landmarks(self.rig, given)
        last = list(
            fit_iterates(
                FitTask(
                    self.rig,
                    target,
                    start,
                    recipe or load_recipe("default"),
                    {},
                ).with_picks(given)
            )
        )[-1]
        assert last.status is Status.CONVERGED
        return last.parameters

    def moved_mm(self, vertices: Array, faces: Integers) -> float:
        """Mean distance of the breasts from where the unspoilt scan puts them."""
        gap = pose(self.rig, self.parameters(vertices, faces))[self.chest] - self.fitted[self.chest]
        return float(1e3 * np.linalg.norm(gap, axis=1).mean())


def example_patient() -> Patient:
    rig = read_rig(default_rig_path())
    scan = read_scan(EXAMPLE / "scan.ply", None, "auto")
    centre = scan.vertices.mean(axis=0)
    places, _ = read_landmarks(EXAMPLE / "landmarks.json")
    landmarks = {name: 1e-3 * np.asarray(place) - centre for name, place in places.items()}
    chest = np.unique(np.concatenate([rig.regions["breast_L"], rig.regions["breast_R"]]))
    start = start_from_landmarks(rig, landmarks)
    blank = Patient(rig, scan.vertices - centre, np.asarray(scan.faces), landmarks, chest, start)
    return Patient(rig, blank.vertices, blank.faces, landmarks, chest, blank.parameters(blank.vertices, blank.faces))

"""Suspicious picks seen by the fit that goes on without them, above all a navel beside its dent: the skin tells."""

from functools import lru_cache

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.core.assets import asset_folder
from breastrig.fitting.fit import FitTask
from breastrig.fitting.picks.issues import from_observation, on_smooth_skin, refit_without, unusual
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.prepare_scan import prepared
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.fitting.task import ended
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.skinning import pose
from breastrig.scan.clean import clean
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.read import read_scan

NAVEL = "umbilicus"
LIMIT = load_recipe("default").outliers.unusual


@lru_cache(maxsize=2)
def example(stance: str) -> FitTask:
    """The example patient with her true picks."""
    folder, rig = asset_folder("example") / stance, read_rig(default_rig_path())
    target = prepared(clean(read_scan(folder / "scan.ply", None, "m", texture=False)), stance).target
    true = {name: 1e-3 * np.array(place) for name, place in read_landmarks(folder / "landmarks.json")[0].items()}
    return FitTask(
        rig,
        target,
        start_from_landmarks(rig, true),
        load_recipe("default"),
        {},
        stance,
    ).with_picks(true)


def fitted(task: FitTask, pick: Array, name: str = NAVEL) -> Posterior:
    """The end of the fit with the landmark picked there."""
    moved = task.with_picks(task.landmarks | {name: pick})
    *_, last = checked_iterates(moved)
    return Posterior(ended(moved, last), last.parameters)


def beside(task: FitTask, angle: float, distance: float, name: str = NAVEL) -> Array:
    """(3,) m on the skin beside the landmark; angle: rad from the body's left to up."""
    across = task.landmarks["acromion_L"] - task.landmarks["acromion_R"]
    up = task.landmarks["suprasternal_notch"] - task.landmarks[NAVEL]
    away = np.cos(angle) * across / np.linalg.norm(across) + np.sin(angle) * up / np.linalg.norm(up)
    return np.asarray(task.target.search.query((task.landmarks[name] + distance * away)[None]).points[0])


@pytest.mark.parametrize("stance", ["standing", "supine"])
def test_a_right_navel_is_not_asked_about(stance: str) -> None:
    posterior = fitted(example(stance), example(stance).landmarks[NAVEL])
    assert on_smooth_skin(posterior) == ()
    assert unusual(posterior) == ()


@pytest.mark.slow
@pytest.mark.parametrize(("stance", "angle"), [("standing", np.radians(60)), ("supine", np.radians(240))])
def test_a_navel_beside_its_concavity_is_named_with_its_distance(stance: str, angle: float) -> None:
    task = example(stance)
    pick = beside(task, angle, 0.05)
    posterior = fitted(task, pick)
    assert on_smooth_skin(posterior) == (NAVEL,)
    seen = from_observation(refit_without(posterior, (NAVEL,)), posterior.task.given[NAVEL])
    assert seen is not None
    gap, deviation = seen
    away = float(np.linalg.norm(pick - task.landmarks[NAVEL]))
    assert gap == pytest.approx(away, abs=0.01), "m; to first order some are half as far"
    assert deviation > LIMIT
    (doubt,) = unusual(posterior)
    assert doubt.names == (NAVEL,)
    assert doubt.followed
    assert f" {1e3 * gap:.0f} mm from where" in doubt.reason
    certain = posterior.task.with_picks(posterior.task.landmarks, certain=(NAVEL,))
    assert unusual(Posterior(certain, posterior.state.x)) == ()


def test_a_fit_that_goes_on_without_a_pick_ends_where_one_ends_that_never_had_it() -> None:
    task = example("standing")
    pick = beside(task, 0.0, 0.05)
    followed = fitted(task, pick)
    without = refit_without(followed, (NAVEL,))
    assert NAVEL not in without.task.landmarks
    never = task.with_picks(without.task.landmarks)
    *_, last = checked_iterates(never)
    points = task.rig.landmark_points((NAVEL,))
    at, before, wanted = (
        points.positions(vertices, task.rig.faces)[0]
        for vertices in (without.state.vertices, followed.state.vertices, pose(task.rig, last.parameters))
    )
    assert np.linalg.norm(before - wanted) > 0.04
    assert np.linalg.norm(at - wanted) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "angle"),
    [("inframammary_fold_L", 180), ("nipple_R", 180)],
)
def test_the_neighbours_of_a_wrong_pick_are_right(name: str, angle: float) -> None:
    """It bends the lying breast so far that to first order the nipples are beyond their limits as well."""
    task = example("supine")
    posterior = fitted(task, beside(task, np.radians(angle), 0.05, name), name)
    assert [doubt.names for doubt in unusual(posterior)] == [(name,)]

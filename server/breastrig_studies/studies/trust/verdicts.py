"""Is a right fit called good, and is no wrong one?

Four fits: with all landmarks that the scan shows, with none, with those picked that the fit without any proposed (a
person who nods at everything), and from a start that is turned head down.  Right and wrong are decided by the true
landmarks; where a scan shows only a part of the body the proposals are often wrong.
"""

import json
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.distances import surface_summary_mm
from breastrig.fitting.picks.issues import unusual
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.starts.orientation import MIN_LANDMARKS, start_from_scan
from breastrig.fitting.task import FitTask, PickIssue, ended
from breastrig.fitting.verdicts.reasons import GivenLandmarks, picked_names
from breastrig.fitting.verdicts.verdict import judge
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.similarity import Similarity, similar_parameters
from breastrig_studies.studies.case import Scene

SHOWN = 0.01  # m; a landmark farther from the scan cannot be picked
WHOLE = ("ordinary", "poor_sensor", "large_holes")  # captures of the warped family that show all of the trunk


def verdicts(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """{"whole": bool, "fits": {kind: {"level", "error_mm": of the true landmarks, "reasons"}}}."""
    gaps = np.atleast_1d(scene.target.vertex_tree.query(np.array(list(scene.landmarks.values())))[0])
    shown = {n: place for (n, place), gap in zip(scene.landmarks.items(), gaps, strict=True) if gap < SHOWN}
    found = start_from_scan(rig, scene.target, scene.frame.fronts)
    fits: dict[str, Any] = {}
    none, proposed = judged(scene, rig, recipe, found.parameters, {}, found.margin, {})
    near = scene.target.search.query(np.array(list(proposed.values())))
    on_skin = dict(zip(proposed, near.points, strict=True))
    if len(shown) >= MIN_LANDMARKS:
        fits["landmarks"], _ = judged(scene, rig, recipe, scene.start(rig, shown), shown, None, on_skin)
    fits["none"] = none
    nodded = {
        n: at for n, at, gap in zip(proposed, near.points, near.distances, strict=True) if gap < SHOWN
    }  # one picks on skin
    if len(nodded) >= MIN_LANDMARKS:
        fits["accepted"], _ = judged(scene, rig, recipe, scene.start(rig, nodded), nodded, None, on_skin)
    fits["head_down"], _ = judged(scene, rig, recipe, head_down(rig, scene, found.similarity), {}, None, {})
    capture = json.loads((scene.case.folder / "case.json").read_text("utf-8")).get("capture", WHOLE[0])
    return {"whole": capture in WHOLE, "fits": fits}


def judged(
    scene: Scene,
    rig: Rig,
    recipe: Recipe,
    start: RigParameters,
    picks: dict[str, Array],
    clearness: float | None,
    proposed: dict[str, Array],
) -> tuple[dict[str, Any], dict[str, Array]]:
    """The verdict on the fit with its errors, and the locations of its landmarks."""
    task = FitTask(rig, scene.target, start, recipe, {}, scene.case.stance).with_picks(picks)
    *_, last = checked_iterates(task)
    posterior = Posterior(ended(task, last), last.parameters)
    doubts: tuple[PickIssue, ...] = (*last.not_followed, *unusual(posterior))
    vertices = posterior.state.vertices
    repeated = len(picked_names(picks, proposed)) < MIN_LANDMARKS
    given = GivenLandmarks(picked=len(picks), left=0, followed=len(picks))
    found = judge(posterior, last.status, given, doubts, clearness, repeats=lambda: repeated)
    said, compared = found.verdict, found.compared
    error = 1e3 * float(scene.landmark_errors(rig, vertices).mean())
    at = rig.landmark_points().positions(vertices, rig.faces)
    surface = surface_summary_mm(compared.distances.model)["mean"]
    answer = {
        "level": said.level,
        "error_mm": round(error, 2),
        "surface_mm": surface,
        "reasons": list(said.reasons),
    }
    return answer, dict(zip(rig.landmark_names, at, strict=True))


def head_down(rig: Rig, scene: Scene, right: Similarity) -> RigParameters:
    """The start turned by half a turn about the way it faces, around the middle of the scan."""
    turn = right.rotation @ np.diag([-1.0, -1.0, 1.0]) @ right.rotation.T
    middle = scene.target.vertices.mean(axis=0)
    shift = turn @ (right.translation - middle) + middle
    return similar_parameters(rig, Similarity(right.scale, turn @ right.rotation, shift))

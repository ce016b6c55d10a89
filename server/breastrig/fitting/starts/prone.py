"""Where a prone body starts without landmarks: on what its hanging breasts show (relief/prone.py), the head on either
side; each is fitted for two stages, and the one with the least energy goes on (docs/decisions/0019)."""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import PRONE
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import fit_iterates
from breastrig.fitting.starts.orientation import Start
from breastrig.fitting.starts.part_of_body import judge
from breastrig.fitting.task import FitTask
from breastrig.relief.prone import ProneView, prone_views
from breastrig.rig.model import Rig
from breastrig.rig.similarity import Similarity, similar_parameters
from breastrig.rig.stance_priors import mean_weights

USUAL_SCALE = 1.05  # of the trunk; hanging breasts say nothing of it


def prone_start(rig: Rig, target: ScanTarget, front: Array) -> Start | None:
    """For a scan whose front is about the unit (3,) `front`; None where it shows no two breasts."""
    starts = [_placed(rig, view) for view in prone_views(target.vertices, target.faces, front)]
    tried = sorted(((_energy(rig, target, each), k) for k, each in enumerate(starts)), key=lambda pair: pair[0])
    tried = [pair for pair in tried if np.isfinite(pair[0])]
    if not tried:
        return None
    best = starts[tried[0][1]]
    margin = tried[1][0] / tried[0][0] - 1.0 if len(tried) > 1 else 1.0
    return Start(similar_parameters(rig, best), best, best.rotation, margin)


def _placed(rig: Rig, view: ProneView) -> Similarity:
    """The rest pose with the stance's breasts on the view's landmarks."""
    body = rig.template + np.tensordot(mean_weights(rig, PRONE), rig.blendshapes, axes=1)
    names = tuple(name for name in view.places if name in rig.landmark_names)
    model = rig.landmark_points(names).positions(body, rig.faces).mean(axis=0)
    seen = np.mean([view.places[name] for name in names], axis=0)
    return Similarity(USUAL_SCALE, view.axes, seen - USUAL_SCALE * view.axes @ model)


def _energy(rig: Rig, target: ScanTarget, start: Similarity) -> float:
    *_, last = fit_iterates(FitTask(rig, target, similar_parameters(rig, start), judge(), {}, PRONE))
    return last.energy if last.is_finite else np.inf

"""Picks that are explained by a mistake with a name: sides exchanged, or another landmark's place.

What was meant is asked by evidence: where the picks' landmarks are expected as they are named and as they may have been
meant, or anywhere; the density is a Student t's, for some bodies are unlike all others.  A pick is rejected only where
one other meaning is nearly certain.  Whether all sides are exchanged is seen in the picks alone, before anything is
fitted; others show at the fitted model, as long as its stages doubt picks.  Decision 0011.
"""

import numpy as np
from scipy.spatial.distance import cdist
from scipy.special import softmax

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.picks.leave_one_out import LeaveOneOut, log_student, meant_evidence
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import Outliers
from breastrig.fitting.starts.orientation import MIN_LANDMARKS, trusted_similarity
from breastrig.fitting.task import FitTask, PickIssue
from breastrig.geometry.normals import face_normals
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose

FRAME = 10.0  # nats, times the cosine of the turn from known axes: 30 degrees cost 1.3, the wrong way round 20


def partner(rig: Rig, name: str) -> str:
    """The landmark on the other side."""
    return next(landmark.mirror for landmark in rig.landmarks if landmark.name == name)


def sides_exchanged(
    rig: Rig, landmarks: dict[str, Array], target: ScanTarget, outliers: Outliers, known: Array | None = None
) -> bool:
    """Whether the picks ((3,) m by name) as a whole make sense only with left and right exchanged.

    Few picks nearly in one plane fit the model's back as well as its front; which way the skin under them faces tells,
    and (3, 3) `known` axes of the body.
    """
    names = tuple(landmarks)
    if len(names) < MIN_LANDMARKS:
        return False
    picked = np.array([landmarks[name] for name in names])
    skin, normals = target.normals[target.vertex_tree.query(picked)[1]], face_normals(rig.template, rig.faces)
    nats = []
    for order in (names, tuple(partner(rig, name) for name in names)):
        points = rig.landmark_points(order)
        found, away = trusted_similarity(points.positions(rig.template, rig.faces), picked)
        cosines = np.einsum("mi,mi->m", normals[points.faces] @ found.rotation.T, skin)
        nats.append(float(log_student(away / outliers.template, 3).sum() + outliers.facing * cosines.sum()))
        if known is not None:
            nats[-1] += FRAME * 0.5 * (float(np.sum(found.rotation * known)) - 1.0)
    return bool(softmax([nats[0], np.log(outliers.slip) + nats[1]])[1] > outliers.sure)


def mistaken(task: FitTask, x: RigParameters, most: int) -> tuple[PickIssue, ...]:
    """The picks that are not to be followed, at most so many; certain ones are not among them."""
    rig, rules = task.rig, task.recipe.outliers
    places = rig.landmark_points().positions(pose(rig, x), rig.faces)
    nearest = {name: rig.landmark_names[int(cdist(at[None], places).argmin())] for name, at in task.landmarks.items()}
    elsewhere = [name for name, other in nearest.items() if other != name and name not in task.certain]
    if not elsewhere:
        return ()
    posterior = Posterior(task, x, partners=False)
    as_named, chances = LeaveOneOut(posterior).evidence(), dict[tuple[str, ...], float]()
    slip, anywhere = np.log(rules.slip), np.log(rules.anywhere)
    for name in elsewhere:
        other = nearest[name]
        both = nearest.get(other) == name == partner(rig, other) and other in elsewhere
        if other in as_named and not both and as_named[other] < anywhere:
            continue  # nobody knows where that one is
        names = tuple(sorted((name, other))) if both else (name,)
        as_other = sum(meant_evidence(posterior, task.given[each], nearest[each]) for each in names)
        as_meant = sum(as_named[each] for each in names)
        chances[names] = float(softmax([as_meant, slip + as_other, len(names) * anywhere])[1])
    found: list[PickIssue] = []
    for names in sorted((names for names in chances if chances[names] > rules.sure), key=lambda names: -chances[names]):
        if sum(len(doubt.names) for doubt in found) + len(names) > most:
            continue
        exchanged = len(names) == 2
        what = "look exchanged; they were" if exchanged else f"lies where {nearest[names[0]]} is expected; it was"
        found.append(PickIssue(names, f"{' and '.join(names)} {what} not followed.", exchanged=exchanged))
    return tuple(found)

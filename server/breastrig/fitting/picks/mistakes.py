"""Picks that are explained by a mistake with a name: sides exchanged, or another landmark's place.

Only such picks are ever rejected, and only when they are farther from where all else expects them than any right pick
was found to be.  Whether all sides are exchanged is seen in the picks alone, before anything is fitted; single ones
show at the fitted model, as long as its stages doubt picks.  Few
picks nearly in one plane fit the model's back as well as its front; the skin under them tells, but not surely enough
to let right ones go (breasts hang, scans are turned inside out): it explains only why a fit has failed.
"""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.picks.leave_one_out import LeaveOneOut
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import Outliers
from breastrig.fitting.starts.orientation import MIN_LANDMARKS, trusted_similarity
from breastrig.fitting.task import Doubt, FitTask
from breastrig.geometry.normals import face_normals
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose

CLOSE = 2.5  # times `near_other`: two places that are hardly further apart than what is near to one
EXCHANGE = "Left and right of the landmarks look exchanged; exchange them and fit again."


def partner(rig: Rig, name: str) -> str:
    """The landmark on the other side."""
    return next(landmark.mirror for landmark in rig.landmarks if landmark.name == name)


def sides_exchanged(rig: Rig, landmarks: dict[str, Array], outliers: Outliers) -> bool:
    """Whether the picks ((3,) m by name) as a whole make sense only with left and right exchanged."""
    names = tuple(landmarks)
    if sum(partner(rig, name) != name for name in names) < 4:
        return False
    picked = np.array([landmarks[name] for name in names])
    medians, means = [], []
    for order in (names, tuple(partner(rig, name) for name in names)):
        model = rig.landmark_points(order).positions(rig.template, rig.faces)
        residuals = trusted_similarity(model, picked)[1]
        medians.append(float(np.median(residuals)))
        means.append(float(np.sqrt(np.mean(residuals**2))))  # of few picks the median alone says little
    return (
        means[0] > outliers.exchanged_least
        and medians[1] < outliers.exchanged_gain * medians[0]
        and means[1] < outliers.exchanged_gain_of_all * means[0]
    )


def explained(task: FitTask, reasons: tuple[str, ...]) -> tuple[str, ...]:
    """Why a fit is of no use, with the mistake that explains it before all else, where there is one."""
    return (EXCHANGE, *reasons) if _back_to_front(task.rig, task.landmarks, task.target) else reasons


def _back_to_front(rig: Rig, landmarks: dict[str, Array], target: ScanTarget) -> bool:
    """Whether the picks ((3,) m by name) turn the model's back to their skin, and its front when exchanged."""
    names = tuple(landmarks)
    has_pair = any(partner(rig, name) in landmarks for name in names if partner(rig, name) != name)
    if len(names) < MIN_LANDMARKS or not has_pair:
        return False
    picked = np.array([landmarks[name] for name in names])
    skin = target.normals[target.vertex_tree.query(picked)[1]]
    faces = face_normals(rig.template, rig.faces)
    agree = []
    for order in (names, tuple(partner(rig, name) for name in names)):
        points = rig.landmark_points(order)
        found, _ = trusted_similarity(points.positions(rig.template, rig.faces), picked)
        cosines = np.einsum("mi,mi->m", faces[points.faces] @ found.rotation.T, skin)
        agree.append((float(np.median(cosines)), float(np.mean(cosines))))  # of few the median alone says little
    return max(agree[0]) < 0.0 < min(agree[1])


def _near(rig: Rig, name: str, pick: Array, fitted: dict[str, Array], rules: Outliers) -> set[str]:
    """The landmarks for which a pick of this name could have been meant.

    Where two are close together, as the nipple of a breast that hangs and its fold, a place says of neither that it is
    the other.
    """
    wide = {name, partner(rig, name)}
    return {
        each
        for each, place in fitted.items()
        if np.linalg.norm(place - pick) < (rules.near_partner if each in wide else rules.near_other)
        and (each in wide or np.linalg.norm(place - fitted[name]) > CLOSE * rules.near_other)
    }


def mistaken(task: FitTask, x: RigParameters, most: int) -> tuple[Doubt, ...]:
    """The picks that are not to be followed, at most so many; certain ones are not among them."""
    rig, rules = task.rig, task.recipe.outliers
    places = rig.landmark_points().positions(pose(rig, x), rig.faces)
    fitted = dict(zip(rig.landmark_names, places, strict=True))
    near = {name: _near(rig, name, at, fitted, rules) for name, at in task.landmarks.items()}
    strays = [name for name in task.landmarks if name not in near[name] and name not in task.certain]
    if not strays:
        return ()
    deviations = LeaveOneOut(Posterior(task, x, partners=False)).deviations()
    strays = sorted((n for n in strays if deviations[n] > rules.impossible), key=deviations.__getitem__, reverse=True)
    found: list[Doubt] = []
    for name in strays:
        gone = {each for doubt in found for each in doubt.names}
        other = partner(rig, name)
        if name in gone or not near[name]:
            continue
        if other in strays and other in near[name] and name in near[other]:
            if len(gone) + 2 <= most:
                left, right = sorted((name, other))
                reason = f"{left} and {right} look exchanged; they were not followed."
                found.append(Doubt((left, right), reason, exchanged=True))
        elif len(gone) < most:
            taken = min(near[name], key=lambda each: float(np.linalg.norm(fitted[each] - task.landmarks[name])))
            found.append(Doubt((name,), f"{name} lies where {taken} is expected; it was not followed."))
    return tuple(found)

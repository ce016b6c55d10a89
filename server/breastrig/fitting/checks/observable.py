"""What a finished fit's landmarks would tell if a person checked them: the input of choose.py.

A pick replaces what colours, form or its partner showed of the landmark, and tells of its own partner on the other side
(fitting/body/landmarks.py), as in the fit that would follow.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from breastrig.colour.features.observation import Observation
from breastrig.core.arrays import Array, Booleans
from breastrig.core.stances import PRONE, split_side
from breastrig.fitting.body.landmarks import UNSHOWN_ERROR, expected_gaps
from breastrig.fitting.checks.choose import Observable
from breastrig.fitting.fit import along
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.propose import laid_on_scan
from breastrig.fitting.uncertainty.radii import HOLDS_90, Radii, radii


@dataclass(frozen=True, eq=False)
class Places:
    """Where a fit expects the rig's L landmarks on the scan."""

    points: Array  # (L, 3) m, on the scan's skin
    normals: Array  # (L, 3) unit, of the scan there
    radii: Array  # (L,) m, that hold the true places with 90 %
    shown: Booleans  # (L,) which of them the scan shows


def places_of(posterior: Posterior, known: Radii, seen: Mapping[str, Observation]) -> Places:
    """The places of landmarks around which a person looks for them; `known` radii of the fit, `seen` in the colours."""
    target, around = posterior.task.target, radii(posterior, expected=True)
    assert around is not None
    sizes = {name: float(np.hypot(radius, known.lost)) for name, radius in around.landmarks.items()}
    sizes |= {name: HOLDS_90 * each.error for name, each in seen.items()}
    points, shown = laid_on_scan(posterior, {name: each.place for name, each in seen.items()})
    nearest = target.search.query(points)
    normals = target.face_normals[nearest.faces]
    return Places(nearest.points, normals, np.array([*sizes.values()]), shown)


def observable_landmarks(posterior: Posterior, shown: Booleans, checked: Collection[str]) -> Observable:
    """The landmarks that the scan shows ((L,) `shown`) and a person has not `checked` yet."""
    task, rig = posterior.task, posterior.task.rig
    recipe, stage, names = task.recipe, task.recipe.stages[-1], tuple(rig.landmark_names)
    index = {name: k for k, name in enumerate(names)}
    temperature = along(stage.temperature, 1.0)
    replaced = np.zeros((len(names), 3, 3))
    if posterior.picks is not None:
        for each, root in zip(posterior.picks.observations, posterior.picks.whitening, strict=True):
            replaced[index[each.name]] += root.T @ root
    if stage.looks_at_form or task.stance == PRONE:
        for name, each in posterior.relief.items():
            replaced[index[name]] += np.linalg.inv(each.covariance) / (temperature * recipe.observed.form) ** 2
    shared = {each.name: np.linalg.inv(each.covariance) / temperature**2 for each in posterior.partners or ()}
    for name, information in shared.items():
        replaced[index[name]] += information
    partners = {}
    for landmark in rig.landmarks if stage.looks_at_form or task.stance == PRONE else ():
        alike, other = recipe.partners.get(split_side(landmark.name)[0]), landmark.mirror
        if alike is None or other == landmark.name or other in task.landmarks:
            continue
        error = math.hypot(alike, 0.0 if shown[index[other]] else UNSHOWN_ERROR)
        more = 1.0 / (temperature * error) ** 2 - np.trace(shared.get(other, np.zeros((3, 3)))) / 3.0
        partners[index[landmark.name]] = index[other], max(float(more), 0.0)
    gaps = expected_gaps(posterior.state, task.stance)
    beside = np.array([gaps[name].covariance for name in names])
    still = np.array([name not in checked for name in names]) & shown
    return Observable(names, still, 1.0 / (temperature * recipe.observed.landmark) ** 2, replaced, partners, beside)

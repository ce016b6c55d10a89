"""What is tried with each case: all landmarks, half of them, none, and shaky clicks.

Every random number comes from a generator seeded by the case's own name, so results neither depend on the order
of the work nor on which other cases there are.
"""

import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from breastrig.core.arrays import Array
from breastrig.core.errors import FitFailed
from breastrig.evaluation.cohort import Case
from breastrig.evaluation.measures import all_measures, landmarks_mm, stands_wrong, surface_mean_mm, truth_mm
from breastrig.evaluation.registration import Registration, registered
from breastrig.evaluation.subject import Subject, moved
from breastrig.fitting.recipe import Recipe
from breastrig.rig.model import Rig

CLICK_ERROR = 0.005  # m along the skin, in a random direction
CLICKABLE = 0.010  # m; a landmark farther from the scan lies in a hole, where nobody can click
SHIFT = 0.5  # m, at most, along each axis


@dataclass(frozen=True)
class Plan:
    """How often the random experiments are repeated."""

    rotations: int = 3
    clicks: int = 3


@dataclass(frozen=True, eq=False)
class Measured:
    """A case's numbers, and the surface of the fit with all landmarks."""

    numbers: dict[str, Any]
    fitted: Registration


def measured(rig: Rig, case: Case, subject: Subject, recipe: Recipe, plan: Plan) -> Measured:
    """All experiments with one case; FitFailed when the fit with all landmarks fails."""
    fitted = registered(rig, subject, recipe, subject.landmarks)
    numbers = table_row(rig, subject, fitted) | {
        "half": _half(rig, subject, recipe),
        "none": [_none(rig, subject, recipe, _random(case, "turn", k)) for k in range(plan.rotations)],
        "clicks": [_clicks(rig, subject, recipe, _random(case, "click", k)) for k in range(plan.clicks)],
    }
    return Measured(numbers, fitted)


def table_row(rig: Rig, subject: Subject, fitted: Registration) -> dict[str, Any]:
    """The numbers of Table 1."""
    return {
        "time_s": round(fitted.solve_s, 4),
        "iterations": fitted.iterations,
        "stop_reason": fitted.stop_reason,
        **all_measures(rig, subject, fitted.vertices),
    }


def halves(rig: Rig) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """A fixed split of the rig's landmarks: each pair is parted, its sides alternate, so do those of the midline."""
    sets: tuple[list[str], list[str]] = ([], [])
    middle = pairs = 0
    placed = set()
    for landmark in rig.landmarks:
        if landmark.name in placed:
            continue
        if landmark.mirror == landmark.name:
            sets[middle % 2].append(landmark.name)
            middle += 1
        else:
            sets[(pairs + 1) % 2].append(landmark.name)
            sets[pairs % 2].append(landmark.mirror)
            pairs += 1
        placed |= {landmark.name, landmark.mirror}
    return tuple(sets[0]), tuple(sets[1])


def _random(case: Case, what: str, number: int) -> np.random.Generator:
    return np.random.default_rng([zlib.crc32(f"{case.patient}/{case.name}/{what}".encode()), number])


def _half(rig: Rig, subject: Subject, recipe: Recipe) -> list[dict[str, Any]]:
    """Two fits: each is given one half and measured at the other."""
    results: list[dict[str, Any]] = []
    known = [tuple(name for name in half if name in subject.landmarks) for half in halves(rig)]
    for given, other in (known, known[::-1]):
        if not other:
            continue
        try:
            fitted = registered(rig, subject, recipe, {name: subject.landmarks[name] for name in given})
        except FitFailed as error:
            results.append({"failed": str(error)})
            continue
        results.append(
            {
                "given": list(given),
                "surface_mean_mm": surface_mean_mm(rig, subject, fitted.vertices),
                "landmarks": landmarks_mm(rig, subject, fitted.vertices, other),
            }
        )
    return results


def _none(rig: Rig, subject: Subject, recipe: Recipe, rng: np.random.Generator) -> dict[str, Any]:
    """A fit without landmarks of the scan turned over the whole sphere and shifted."""
    turn, shift = Rotation.random(rng=rng).as_matrix(), rng.uniform(-SHIFT, SHIFT, 3)
    try:
        fitted = registered(rig, moved(subject, turn, shift), recipe, {})
    except FitFailed as error:
        return {"failed": str(error)}
    vertices = (fitted.vertices - shift) @ turn
    return {
        "surface_mean_mm": surface_mean_mm(rig, subject, vertices),
        "landmarks": landmarks_mm(rig, subject, vertices),
        "stands_wrong": stands_wrong(rig, subject, vertices),
    }


def clicked(subject: Subject, rng: np.random.Generator) -> dict[str, Array]:
    """Each landmark that the scan shows, moved by CLICK_ERROR along the skin and put onto the scan."""
    target = subject.target
    picks = {}
    for name, place in subject.landmarks.items():
        direction = rng.normal(size=3)
        at = target.search.query(place[None], 16)
        if at.distances[0] > CLICKABLE:
            continue
        normal = target.normals_at(at.faces, at.barycentric)[0]
        direction -= (direction @ normal) * normal
        shaky = at.points[0] + CLICK_ERROR * direction / np.linalg.norm(direction)
        picks[name] = target.search.query(shaky[None], 16).points[0]
    return picks


def _clicks(rig: Rig, subject: Subject, recipe: Recipe, rng: np.random.Generator) -> dict[str, Any]:
    """A fit to shaky clicks, measured against the truth."""
    picks = clicked(subject, rng)
    try:
        fitted = registered(rig, subject, recipe, picks)
    except FitFailed as error:
        return {"failed": str(error)}
    return {
        "given": len(picks),
        "surface_mean_mm": surface_mean_mm(rig, subject, fitted.vertices),
        "truth": truth_mm(rig, subject, fitted.vertices),
        "landmarks": landmarks_mm(rig, subject, fitted.vertices),
    }

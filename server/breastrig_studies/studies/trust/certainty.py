"""Do the 90 % radii hold nine of ten true places, and are right picks believed?

Two fits, with the landmarks that the scan shows picked truly and 5 mm off along the skin, and two with half of them
each.  The true place of a model vertex is that of the reference fit (reference_fit.py).  Counts, so that tables can add
them up over cases.
"""

from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.fitting.picks.issues import unusual
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.task import FitTask, ended
from breastrig.fitting.uncertainty.radii import PLANNED_ON, Radii, radii, seen_vertices
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose
from breastrig_studies.studies.case import Scene
from breastrig_studies.studies.landmarks import CLICK_ERROR, FIRST_HALF
from breastrig_studies.studies.reference_fit import ReferenceFit, reference_fit
from breastrig_studies.studies.trust.reliability import add_up, covered_at_levels

SHOWN = 0.01  # m; a landmark farther from the scan cannot be picked
SEED = 17
GIVEN, NOT_GIVEN, SEEN, NOT_SEEN = "landmarks given", "landmarks not given", "skin seen", "skin not seen"
Counts = dict[str, list[int]]  # kind of place -> [covered, all]


def certainty(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """{"exact" | "clicked" | "half": {"landmarks", "skin", "lines", "levels", "picks", "dropped", "unusual"}}."""
    rng = np.random.default_rng(SEED)
    names, places = list(scene.landmarks), np.array(list(scene.landmarks.values()))
    gaps = np.atleast_1d(scene.target.vertex_tree.query(places)[0])
    shown = {name: place for name, place, gap in zip(names, places, gaps, strict=True) if gap < SHOWN}
    clicked = {name: scene.along_the_skin(place, CLICK_ERROR, rng) for name, place in shown.items()}
    halves = [{n: p for n, p in shown.items() if (n in FIRST_HALF) == first} for first in (True, False)]
    true = reference_fit(scene, rig, recipe)
    trials = {"exact": [shown], "clicked": [clicked], "half": [half for half in halves if len(half) > 2]}
    return {
        kind: _added([_judged(scene, rig, recipe, picks, true) for picks in given])
        for kind, given in trials.items()
        if all(given) and given
    }


def _judged(
    scene: Scene, rig: Rig, recipe: Recipe, picks: dict[str, Array], true: ReferenceFit | None
) -> dict[str, Any]:
    task = FitTask(rig, scene.target, scene.start(rig, picks), recipe, {}, scene.case.stance).with_picks(picks)
    *_, last = checked_iterates(task)
    posterior = Posterior(ended(task, last), last.parameters)
    vertices, known = pose(rig, last.parameters), radii(posterior)
    counts: dict[str, Any] = {
        "picks": len(picks),
        "dropped": sum(len(doubt.names) for doubt in last.not_followed),
        "unusual": sum(len(doubt.names) for doubt in unusual(posterior)),
        "landmarks": {},
        "skin": {},
        "lines": {},
        "levels": {},
    }
    if known is None:
        return counts
    errors = scene.landmark_errors(rig, vertices)
    for name, error in zip(scene.landmarks, errors.tolist(), strict=True):
        kind = f"{name.removesuffix('_L').removesuffix('_R')}, {'given' if name in picks else 'not given'}"
        radius = np.array([known.landmarks[name]])
        _count(counts["landmarks"], kind, np.array([error]), radius)
        group = GIVEN if name in picks else NOT_GIVEN
        add_up(counts["levels"], group, covered_at_levels(np.array([error]), radius))
    if true is not None:
        gaps = np.linalg.norm(vertices - true.vertices, axis=1)
        _skin(counts["skin"], rig, posterior, known, gaps)
        seen = seen_vertices(posterior)
        breasts = np.unique([v for name, its in rig.regions.items() if name.startswith(PLANNED_ON) for v in its])
        lines = breasts[seen[breasts]]
        off = across(vertices[lines] - true.vertices[lines], posterior.state.normals[lines])
        _count(counts["lines"], "breasts, across the line", off, np.full(len(off), known.lines))
        for group, part in ((SEEN, seen), (NOT_SEEN, ~seen)):
            add_up(counts["levels"], group, covered_at_levels(gaps[part], known.vertices[part]))
    return counts


def across(gaps: Array, normals: Array) -> Array:
    """(N,) m: how far off a line is, across it, whose (N, 3) places are (N, 3) m off on skin with these normals.

    Its direction on the skin is drawn at each place.
    """
    directions = np.cross(normals, np.random.default_rng(SEED).normal(size=normals.shape))
    return np.asarray(np.abs(np.einsum("ni,ni->n", gaps, directions)) / np.linalg.norm(directions, axis=1))


def _skin(counts: Counts, rig: Rig, posterior: Posterior, known: Radii, errors: Array) -> None:
    seen = seen_vertices(posterior)
    for name, vertices in rig.regions.items():
        for part, words in ((vertices[seen[vertices]], "seen"), (vertices[~seen[vertices]], "not seen")):
            if len(part):
                kind = f"{name.removesuffix('_L').removesuffix('_R')}, {words}"
                _count(counts, kind, errors[part], known.vertices[part])


def _count(counts: Counts, kind: str, errors: Array, radius: Array) -> None:
    covered, total = counts.get(kind, [0, 0])
    counts[kind] = [covered + int((errors <= radius).sum()), total + len(errors)]


def _added(trials: list[dict[str, Any]]) -> dict[str, Any]:
    result: dict[str, Any] = {key: sum(trial[key] for trial in trials) for key in ("picks", "dropped", "unusual")}
    for part in ("landmarks", "skin", "lines", "levels"):
        kinds = dict.fromkeys(kind for trial in trials for kind in trial[part])
        result[part] = {
            kind: np.sum([trial[part][kind] for trial in trials if kind in trial[part]], axis=0).tolist()
            for kind in kinds
        }
    return result

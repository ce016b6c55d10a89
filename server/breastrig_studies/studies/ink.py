"""Recall and precision of the ink found on a scan, and its error when transferred to the other scan.

Found and true lines are sampled every SAMPLE and moved to the nearest place of the true surface, so that the depth
error of the scan is not counted. Letters are ink but no part of a plan: they count neither as found nor as missed.
Numbers are measured with the thresholds as they are, and with all of them larger and smaller by a common factor: for
each patient the table takes the factor that is best for the others.
"""

import json
import time
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from breastrig.colour.ink.find_ink import InkLine, find_ink
from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadInput
from breastrig.core.units import METRES_PER_UNIT
from breastrig.drawings.transfer import points_carried
from breastrig.fitting.recipe import Recipe
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.polyline import resampled
from breastrig.rig.model import Rig
from breastrig.scan.read import read_scan
from breastrig_studies.cohort import Case
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.transfer import fitted

SAMPLE = 0.5e-3  # m
REACH = 3e-3  # m within which found and true lines are the same
LETTERS = "text"  # how names of true shapes begin that are no part of a plan
FACTORS = (0.7, 0.85, 1.0, 1.2, 1.45)  # of all thresholds of density


@dataclass(frozen=True, eq=False)
class TrueLines:
    """The true ink of one case, all lines together."""

    places: Array  # (M, 3) m on the true skin
    wanted: Booleans  # (M,) inked, seen by the scan, and no letter
    beyond: Array | None  # (M, 3) m the same skin in the other stance, in that scan's frame


def ink_study(cases: tuple[Case, ...], rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """{factor: {recall, precision, off_mm, false_mm, true_mm, lines, colours}}, and the time of one search."""
    (case,) = cases
    scan = read_scan(case.scan, None, case.unit, for_display=False)
    truth = _surface(case, scan.unit)
    lines = true_lines(case, None)
    answer: dict[str, Any] = {}
    for factor in FACTORS:
        start = time.process_time()
        found = find_ink(scan, factor)
        seconds = time.process_time() - start
        answer[f"{factor:g}"] = compared(found, lines, truth) | {"time_s": round(seconds, 3)}
    return answer


def compared(found: tuple[InkLine, ...], lines: TrueLines, truth: ClosestPointSearch) -> dict[str, Any]:
    """The numbers of one search; None for shares of nothing."""
    places = _sampled(found)
    on_true = truth.query(places).points if len(places) else places
    wanted = lines.places[lines.wanted]
    hit = _near(wanted, on_true)[0] < REACH
    gap = _near(on_true, lines.places)[0]
    same = gap < REACH
    return {
        "recall": _share(hit),
        "precision": _share(same),
        "off_mm": round(1e3 * float(gap[same].mean()), 3) if same.any() else None,
        "false_mm": round(1e3 * SAMPLE * float((~same).sum()), 1),
        "true_mm": round(1e3 * SAMPLE * len(wanted), 1),
        "lines": len(found),
    }


def ink_transfer_study(cases: tuple[Case, ...], rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """{"rows": for each pair of a standing, inked scan and a lying one}: found and true lines, both carried."""
    rows = []
    pairs = product(*([case for case in cases if case.stance == stance] for stance in ("standing", "supine")))
    for standing, lying in pairs:
        if not (standing.folder / f"ink_in_{lying.name}.json").is_file():
            continue
        scenes = read_scene(standing), read_scene(lying)
        lines = true_lines(standing, lying)
        fit, goal_fit = (fitted(rig, recipe, scene, scene.landmarks) for scene in scenes)
        scan = read_scan(standing.scan, None, standing.unit)
        truth = scenes[0].truth
        assert truth is not None
        assert lines.beyond is not None
        found = _sampled(find_ink(scan))
        gap, nearest = _near(truth.query(found).points, lines.places)
        same = (gap < REACH) & lines.wanted[nearest]
        carried = points_carried(rig, fit, goal_fit, _on_skin(scenes[0], found[same]))[0]
        ideal = points_carried(rig, fit, goal_fit, _on_skin(scenes[0], lines.places[nearest[same]]))[0]
        goal = lines.beyond[nearest[same]]
        rows.append(
            {
                "from": standing.name,
                "to": lying.name,
                "points": int(same.sum()),
                "found_mm": _mean_mm(carried - goal),
                "true_mm": _mean_mm(ideal - goal),
            }
        )
    return {"rows": rows}


def true_lines(case: Case, other: Case | None) -> TrueLines:
    """The true lines of the case's ink.json; BadInput when it is not there."""
    shapes = _shapes(case.folder / "ink.json")
    beyond = None if other is None else _shapes(case.folder / f"ink_in_{other.name}.json")
    parts = [np.zeros((0, 7))]
    for number, (shape, unit) in enumerate(shapes):
        points = unit * np.asarray(shape["points"], dtype=np.float64)
        plan = not str(shape["name"]).startswith(LETTERS)
        inked = np.asarray(shape.get("inked", [True] * len(points)), dtype=np.bool_)
        inked &= np.asarray(shape.get("seen", [True] * len(points)), dtype=np.bool_)
        there = points if beyond is None else beyond[number][1] * np.asarray(beyond[number][0]["points"])
        columns = np.column_stack([points, there, (inked & plan).astype(np.float64)])
        parts.append(resampled(columns, SAMPLE, bool(shape.get("closed"))))
    whole = np.concatenate(parts)
    return TrueLines(whole[:, :3], whole[:, 6] > 0.99, None if other is None else whole[:, 3:6])


def _shapes(path: Path) -> list[tuple[dict[str, Any], float]]:
    """Each shape with metres per unit."""
    try:
        document = json.loads(path.read_text("utf-8"))
        return [(shape, METRES_PER_UNIT[document["unit"]]) for shape in document["shapes"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path} cannot be read as a drawing; a coloured case of a cohort needs it.") from error


def _surface(case: Case, unit: str) -> ClosestPointSearch:
    clear = read_scan(case.folder / "truth.ply", None, unit, texture=False)
    return ClosestPointSearch(clear.vertices, np.asarray(clear.faces))


def _sampled(found: tuple[InkLine, ...]) -> Array:
    """(M, 3) m"""
    lines = [resampled(each.line.points, SAMPLE, each.line.closed) for each in found]
    return np.concatenate([np.zeros((0, 3)), *lines])


def _near(places: Array, others: Array) -> tuple[Array, Any]:
    """((M,) m to the nearest of (K, 3) others, inf where there is none, (M,) its number)."""
    if not len(others) or not len(places):
        return np.full(len(places), np.inf), np.zeros(len(places), dtype=np.int64)
    distance, nearest = cKDTree(others).query(places)
    return np.asarray(distance), np.asarray(nearest)


def _on_skin(scene: Scene, places: Array) -> Array:
    return np.asarray(scene.target.search.query(places).points)


def _share(hits: Booleans) -> float | None:
    return round(float(hits.mean()), 4) if len(hits) else None


def _mean_mm(gaps: Array) -> float | None:
    return round(1e3 * float(np.linalg.norm(gaps, axis=1).mean()), 3) if len(gaps) else None

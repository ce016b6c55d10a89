"""Measures the error of a drawing transferred to another scan of the same patient.

truth.ply of one patient has the same triangles in every stance. A line is put on scan A's true surface; the same places
of the same triangles are its true place on B. Only places count that both scans saw (a scan point within 15 mm whose
normal is within 60 degrees), and only what lies on the skin of A is given to the transfer.

Lines: `lumpectomy` and the breasts' `meridians` as the model draws them on scan A, and `strokes`: short lines in all
directions over chest and breasts. Picks: the true landmarks; each 5 mm off along the skin; and the true ones but for
one nipple, 30 mm off. Picks that the fits doubt are left out, as in a fit's folder.

Ways: `skin`, the program's; `model`, through the fitted models alone; and what a user could have instead: `rigid`
motion and thin-plate `spline` through all landmarks snapped to the scans, then to the nearest skin.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from breastrig.core.arrays import Array, Booleans
from breastrig.drawings.line_error import carried_errors
from breastrig.drawings.project_drawing import on_scan
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.drawings.transfer import points_carried
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.task import FitTask, without
from breastrig.fitting.uncertainty.radii import radii
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import ModelDrawing, Rig
from breastrig_studies.cohort import Case
from breastrig_studies.studies.case import SEEN_COSINE, SEEN_DISTANCE, Scene, read_scene
from breastrig_studies.studies.trust.reliability import covered_at_levels

PICKS = ("true", "5 mm off", "one 30 mm off")
ALL = "all"  # lines, or regions, together
WAYS = ("skin", "model", "rigid", "spline")
CLICK, WRONG = 0.005, 0.03  # m
WRONG_PICK = "nipple_L"
STROKES, SHORTEST, LONGEST, STEP = 200, 0.02, 0.05, 0.005  # how many, and in m
SEED = 11
CHEST = 0.13  # m from the line between the nipples

Picks = dict[str, Array]


@dataclass(frozen=True, eq=False)
class Places:
    """Points of lines on scan A and their true places on B."""

    points: Array  # (M, 3) m, on A's skin
    true: Array  # (M, 3) m, in B's frame
    lines: tuple[str, ...]  # (M,) lumpectomy, meridians or strokes
    on_breast: Booleans  # (M,)


def seen(scene: Scene) -> Booleans:
    """(V,) vertices of the truth that the scan shows."""
    assert scene.truth is not None
    distance, nearest = scene.target.vertex_tree.query(scene.truth.vertices)
    normals = vertex_normals(scene.truth.vertices, scene.truth.triangles)
    facing = np.einsum("vi,vi->v", normals, scene.target.normals[nearest])
    return np.asarray((distance < SEEN_DISTANCE) & (facing > SEEN_COSINE))


def on_the_chest(scene: Scene) -> Booleans:
    """(V,) vertices of the truth within CHEST of the line between the nipples."""
    assert scene.truth is not None
    left, right = scene.landmarks["nipple_L"], scene.landmarks["nipple_R"]
    across, vertices = right - left, scene.truth.vertices
    share = np.clip((vertices - left) @ across / (across @ across), 0.0, 1.0)
    return np.asarray(np.linalg.norm(vertices - left - share[:, None] * across, axis=1) < CHEST)


def transfer_study(cases: tuple[Case, ...], rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """{"rows": one for each pair of stances, direction, kind of picks, kind of line and region}."""
    stances = [[case for case in cases if case.stance == stance] for stance in ("standing", "supine")]
    rows: list[dict[str, Any]] = []
    for pair in product(*stances):
        if all((case.folder / "truth.ply").is_file() for case in pair):
            rows.extend(_rows(rig, recipe, (read_scene(pair[0]), read_scene(pair[1]))))
    return {"rows": rows}


def _rows(rig: Rig, recipe: Recipe, scenes: tuple[Scene, Scene]) -> Iterator[dict[str, Any]]:
    rng = np.random.default_rng(SEED)
    off = [
        {name: scene.along_the_skin(place, CLICK, rng) for name, place in scene.landmarks.items()} for scene in scenes
    ]
    moved = scenes[0].along_the_skin(scenes[0].landmarks[WRONG_PICK], WRONG, rng)
    wrong = scenes[0].landmarks | {WRONG_PICK: moved}
    asked: list[Places] = []
    for kind, picks in zip(PICKS, ([s.landmarks for s in scenes], off, [wrong, scenes[1].landmarks]), strict=True):
        fits = [fitted(rig, recipe, scene, given) for scene, given in zip(scenes, picks, strict=True)]
        asked = asked or [places(rig, scenes, fits[0]), places(rig, scenes[::-1], fits[1])]
        for question, (a, b) in zip(asked, ((0, 1), (1, 0)), strict=True):
            carried = points_carried(rig, fits[a], fits[b], question.points)[0]
            said = carried_errors(rig, fits[a], fits[b], question.points, carried)
            errors = {
                "skin": carried,
                "model": points_carried(rig, fits[a], fits[b], question.points, other_patient=True)[0],
            } | by_landmarks((scenes[a], scenes[b]), (picks[a], picks[b]), question.points)
            gaps = {way: 1e3 * np.linalg.norm(found - question.true, axis=1) for way, found in errors.items()}
            about = {"from": scenes[a].case.name, "to": scenes[b].case.name, "picks": kind}
            for line, region in product((ALL, *dict.fromkeys(question.lines)), (ALL, "breasts", "chest")):
                part = np.array([line in (ALL, each) for each in question.lines])
                part &= (region == ALL) | (question.on_breast == (region == "breasts"))
                if part.any():
                    what: dict[str, Any] = {"line": line, "region": region, "points": int(part.sum())}
                    if said is not None:
                        what["levels"] = covered_at_levels(1e-3 * gaps["skin"][part], said[part])
                    yield about | what | {way: _summary(gap[part]) for way, gap in gaps.items()}


def _summary(gaps: Array) -> dict[str, float]:
    return {"mean_mm": round(float(gaps.mean()), 3), "p95_mm": round(float(np.percentile(gaps, 95)), 3)}


def fitted(rig: Rig, recipe: Recipe, scene: Scene, picks: Picks) -> FittedScan:
    """The program's fit; picks that it doubts are left out of the transfer."""
    fit = scene.fitted(rig, recipe, picks)
    doubted = {name for doubt in fit.doubts for name in doubt.names}
    trusted = {name: place for name, place in picks.items() if name not in doubted}
    task = FitTask(rig, scene.target, fit.parameters, recipe, {}, scene.case.stance).with_picks(picks)
    rejected = tuple(doubt for doubt in fit.doubts if not doubt.followed)
    known = radii(Posterior(without(task, rejected), fit.parameters))
    return FittedScan(scene.target, fit.vertices, trusted, scene.case.stance, None if known is None else known.vertices)


def places(rig: Rig, scenes: tuple[Scene, Scene], fit: FittedScan) -> Places:
    """All lines that both scans saw, from the first scan (with its fit) to the second."""
    truth_a, truth_b = scenes[0].truth, scenes[1].truth
    assert truth_a is not None
    assert truth_b is not None
    drawings = {drawing.name: drawing for drawing in rig.drawings}
    parts = [
        ("lumpectomy", _drawn(rig, fit, drawings.get("lumpectomy"), "")),
        ("meridians", _drawn(rig, fit, drawings.get("anatomy"), "meridian")),
        ("strokes", strokes(scenes[0], np.random.default_rng(SEED))),
    ]
    points = np.concatenate([part for _, part in parts])
    lines = [name for name, part in parts for _ in part]
    found = truth_a.query(points)
    both = seen(scenes[0]) & seen(scenes[1])
    kept = np.asarray(both[truth_a.triangles[found.faces]].all(axis=1))
    at = SurfacePoints(found.faces[kept], found.barycentric[kept])
    on_skin = scenes[0].target.search.query(at.positions(truth_a.vertices, truth_a.triangles)).points
    vertex = cKDTree(fit.vertices).query(on_skin)[1]
    breasts = np.concatenate([rig.regions[name] for name in ("breast_L", "breast_R")])
    return Places(
        on_skin,
        at.positions(truth_b.vertices, truth_b.triangles),
        tuple(line for line, keep in zip(lines, kept.tolist(), strict=True) if keep),
        np.isin(vertex, breasts),
    )


def _drawn(rig: Rig, fit: FittedScan, drawing: ModelDrawing | None, start: str) -> Array:
    """(M, 3) m: the points on skin of the drawing's shapes whose names start so, as the model draws them."""
    if drawing is None:
        return np.zeros((0, 3))
    lines = [line for line in on_scan(rig, fit.vertices, drawing, fit.target) if line.name.startswith(start)]
    return np.concatenate([np.zeros((0, 3)), *(line.points[~line.bridged] for line in lines)])


def strokes(scene: Scene, rng: np.random.Generator) -> Array:
    """(M, 3) m: short straight lines in random directions over chest and breasts, on the true surface."""
    truth = scene.truth
    assert truth is not None
    normals = vertex_normals(truth.vertices, truth.triangles)
    near = np.flatnonzero(on_the_chest(scene) & seen(scene))
    result = []
    for vertex in rng.choice(near, STROKES):
        way = np.cross(normals[vertex], rng.normal(size=3))
        way /= np.linalg.norm(way)
        length = rng.uniform(SHORTEST, LONGEST)
        along = np.arange(-0.5 * length, 0.5 * length, STEP)[:, None] * way
        result.append(truth.query(truth.vertices[vertex] + along).points)
    return np.concatenate(result)


def by_landmarks(scenes: tuple[Scene, Scene], picks: tuple[Picks, Picks], points: Array) -> dict[str, Array]:
    """(M, 3) m each: rigid and spline through the landmarks snapped to the scans, then on the nearest skin."""
    names = [name for name in picks[0] if name in picks[1]]
    source, goal = (
        scene.target.search.query(np.array([given[name] for name in names])).points
        for scene, given in zip(scenes, picks, strict=True)
    )
    turn = Rotation.align_vectors(goal - goal.mean(axis=0), source - source.mean(axis=0))[0]
    moved = {
        "rigid": np.asarray(turn.apply(points - source.mean(axis=0)) + goal.mean(axis=0)),
        "spline": np.asarray(RBFInterpolator(source, goal, kernel="thin_plate_spline")(points)),
    }
    return {way: scenes[1].target.search.query(found).points for way, found in moved.items()}

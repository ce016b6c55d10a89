"""Speed of the fit and of its parts, as ratios in the same run (`make bench`; never part of `make test`).

Everything is measured on one scan of 50,000 triangles.  Absolute times drift with the machine; ratios hold: to
`floor`, the bare kernels of one iteration with the full Jacobian, and to peers.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
import trimesh
from helpers.finer_rig import finer

from breastrig.correspondence.match import MatchRules, match
from breastrig.fitting.fit import FitIterate, FitTask, fit_iterates
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.geometry.normals import VertexNormals
from breastrig.rig.normal_equations import normal_equations
from breastrig.rig.skinning import in_pose, pose

Row = Callable[..., None]
Floor = Callable[[], Any]
InTurn = Callable[..., Any]
END = 0.015  # m, as far as the last stages of the default preset search
ROUNDS = 60  # of things that take a few milliseconds


def fitted(task: FitTask, recipe: Recipe) -> FitIterate:
    """The end of one whole fit."""
    return list(fit_iterates(replace(task, recipe=recipe)))[-1]


@pytest.fixture(scope="module")
def near(task: FitTask) -> FitTask:
    """The same task one step before its end, where all parts have their usual work."""
    return replace(task, start=list(fit_iterates(task))[-2].parameters)


def test_floor_of_one_iteration(benchmark: Any, row: Row, floor: Floor, task: FitTask) -> None:
    benchmark.pedantic(floor, rounds=ROUNDS, warmup_rounds=5)
    row(f"scan: {len(task.target.faces):,} triangles; model: {len(task.rig.template):,} vertices", "")
    row("floor of one iteration: pose, rays, syrk, Cholesky", benchmark, "1.00 floors")


def part(benchmark: Any, row: Row, yardstick: Any, name: str, run: Callable[[], Any]) -> None:
    benchmark.pedantic(run, setup=yardstick, rounds=ROUNDS, warmup_rounds=5)
    row("  " + name, benchmark, f"{yardstick.ratio(benchmark):.2f} floors")


def test_posing(benchmark: Any, row: Row, in_turn: InTurn, floor: Floor, near: FitTask) -> None:
    part(benchmark, row, in_turn(floor), "posing", lambda: pose(near.rig, near.start))


def test_normals(benchmark: Any, row: Row, in_turn: InTurn, floor: Floor, near: FitTask) -> None:
    vertices, normals_of = pose(near.rig, near.start), VertexNormals(near.rig.faces, len(near.rig.template))
    part(benchmark, row, in_turn(floor), "normals", lambda: normals_of(vertices))


@pytest.mark.parametrize("method", ["rays", "tree", "nearest_vertex"])
def test_matching(benchmark: Any, row: Row, in_turn: InTurn, floor: Floor, near: FitTask, method: str) -> None:
    vertices = pose(near.rig, near.start)
    normals, rules = VertexNormals(near.rig.faces, len(vertices))(vertices), MatchRules(method, max_distance=END)
    part(benchmark, row, in_turn(floor), f"matching by {method}", lambda: match(near.target, vertices, normals, rules))


def test_rows_of_the_jacobian(benchmark: Any, row: Row, in_turn: InTurn, floor: Floor, near: FitTask) -> None:
    everyone = np.arange(len(near.rig.template))
    normals, posed = np.tile([0.0, 0.0, 1.0], (len(everyone), 1)), in_pose(near.rig, near.start)
    part(benchmark, row, in_turn(floor), "rows of the Jacobian, all vertices", lambda: posed.rows(everyone, normals))


def test_normal_equations(benchmark: Any, row: Row, in_turn: InTurn, floor: Floor, near: FitTask) -> None:
    everyone, residual = np.arange(len(near.rig.template)), np.ones(len(near.rig.template))
    normals, posed = np.tile([0.0, 0.0, 1.0], (len(everyone), 1)), in_pose(near.rig, near.start)
    name = "normal equations by structure, all vertices"
    part(benchmark, row, in_turn(floor), name, lambda: normal_equations(posed, everyone, normals, residual))


def one_iteration(task: FitTask) -> Callable[[], FitIterate]:
    """One iteration of the last stage: pose, normals, matches, terms, step."""
    recipe = load_recipe("default")
    last = recipe.stages[-1].model_copy(update={"iterations": 1})
    alone = replace(task, recipe=recipe.model_copy(update={"stages": (last,)}))

    def run() -> FitIterate:
        iterates = fit_iterates(alone)
        next(iterates)
        return next(iterates)

    return run


def test_one_iteration(benchmark: Any, row: Row, in_turn: InTurn, floor: Floor, near: FitTask) -> None:
    part(benchmark, row, in_turn(floor), "a fit of one last iteration: set-up, 2 matches, step", one_iteration(near))


def test_whole_fit(benchmark: Any, row: Row, in_turn: InTurn, floor: Floor, task: FitTask) -> None:
    recipe = load_recipe("default")
    end = fitted(task, recipe)
    yardstick = in_turn(floor, end.iteration)
    benchmark.pedantic(lambda: fitted(task, recipe), setup=yardstick, rounds=30, warmup_rounds=2)
    name = f"whole fit, {end.iteration} iterations, {1e3 * end.mean_distance:.2f} mm"
    row(name, benchmark, f"{yardstick.ratio(benchmark):.2f} floors of {end.iteration} iterations; aim: 80 ms, 2 floors")


def against_our_fit(
    benchmark: Any, row: Row, in_turn: InTurn, task: FitTask, name: str, run: Callable[[], Any], rounds: int
) -> None:
    yardstick = in_turn(lambda: fitted(task, load_recipe("default")))
    benchmark.pedantic(run, setup=yardstick, rounds=rounds, warmup_rounds=0)
    row("  " + name, benchmark, f"{yardstick.ratio(benchmark):.2f} of our fits")


@pytest.mark.parametrize("times", [1, 2])
def test_with_a_finer_model(benchmark: Any, row: Row, in_turn: InTurn, task: FitTask, times: int) -> None:
    """Each triangle cut in four, once and twice; the surface is the same (test_observation_weights.py)."""
    rig = finer(task.rig) if times == 1 else finer(finer(task.rig))
    fine, recipe = replace(task, rig=rig), load_recipe("default")
    name = f"with {len(rig.template):,} vertices instead of {len(task.rig.template):,}"
    against_our_fit(benchmark, row, in_turn, task, name, lambda: fitted(fine, recipe), 3)


def test_with_the_papers_correspondence(benchmark: Any, row: Row, in_turn: InTurn, task: FitTask) -> None:
    recipe = load_recipe("default")
    stages = tuple(stage.model_copy(update={"method": "nearest_vertex"}) for stage in recipe.stages)
    other = recipe.model_copy(update={"stages": stages})
    end = fitted(task, other)
    name = f"with the paper's correspondence, {end.iteration} it., {1e3 * end.mean_distance:.2f} mm"
    against_our_fit(benchmark, row, in_turn, task, name, lambda: fitted(task, other), 10)


def test_with_the_papers_preset(benchmark: Any, row: Row, in_turn: InTurn, task: FitTask) -> None:
    end = fitted(task, load_recipe("paper"))
    name = f"with the paper's preset, {end.iteration} it., {1e3 * end.mean_distance:.2f} mm"
    against_our_fit(benchmark, row, in_turn, task, name, lambda: fitted(task, load_recipe("paper")), 10)


def test_peer_nricp_amberg(benchmark: Any, row: Row, in_turn: InTurn, task: FitTask) -> None:
    """trimesh's free-form registration of the same template from the same start to the same scan."""
    source = trimesh.Trimesh(pose(task.rig, task.start), task.rig.faces, process=False)
    goal = trimesh.Trimesh(task.target.vertices, task.target.faces, process=False)
    name = "peer: trimesh nricp_amberg, same start"
    run = partial(trimesh.registration.nricp_amberg, source, goal, use_faces=False)
    against_our_fit(benchmark, row, in_turn, task, name, run, 1)

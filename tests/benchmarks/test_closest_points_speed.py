"""Closest points on a scan of 50,000 triangles for all vertices of the model: ours and trimesh's own, in one run."""

from collections.abc import Callable
from typing import Any

import numpy as np
import trimesh

from breastrig.fitting.fit import FitTask
from breastrig.rig.skinning import pose

ROUNDS = 15


def test_closest_points(benchmark: Any, row: Callable[..., None], task: FitTask) -> None:
    points = pose(task.rig, task.start)
    benchmark.pedantic(lambda: task.target.search.query(points), rounds=ROUNDS, warmup_rounds=2)
    row(f"closest points on the scan, {len(points):,} of them", benchmark)


def test_distances_alone(benchmark: Any, row: Callable[..., None], in_turn: Callable[..., Any], task: FitTask) -> None:
    points = pose(task.rig, task.start)
    yardstick = in_turn(lambda: task.target.search.query(points))
    benchmark.pedantic(lambda: task.target.search.distances(points), setup=yardstick, rounds=ROUNDS, warmup_rounds=2)
    row("  their distances alone", benchmark, f"{yardstick.ratio(benchmark):.2f} of that")


def test_peer_proximity(benchmark: Any, row: Callable[..., None], in_turn: Callable[..., Any], task: FitTask) -> None:
    points = pose(task.rig, task.start)
    mesh = trimesh.Trimesh(task.target.vertices, task.target.faces, process=False)
    yardstick = in_turn(lambda: task.target.search.query(points))
    found = benchmark.pedantic(
        lambda: trimesh.proximity.closest_point(mesh, points), setup=yardstick, rounds=5, warmup_rounds=1
    )
    np.testing.assert_allclose(found[1], task.target.search.query(points).distances, atol=1e-4)  # 0.1 mm
    row("  peer: trimesh.proximity.closest_point", benchmark, f"{yardstick.ratio(benchmark):.2f} of ours")

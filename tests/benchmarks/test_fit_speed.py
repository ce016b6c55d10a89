"""Speed of the fit and of its parts, as ratios against peers in the same run (`make bench`; never part of `make test`).

Everything is measured on the example patient's scan.  Absolute times drift with the machine; ratios hold: each
benchmark notes its ratio to `floor`, the bare kernels that no implementation of this method can do without.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.linalg as sla
import trimesh

from breastrig.core.assets import asset_folder
from breastrig.correspondence.match import MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.landmark_check import start_from_landmarks
from breastrig.fitting.recipe import load_recipe
from breastrig.geometry.normals import VertexNormals
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.skinning import Posed, pose
from breastrig.scan.clean import clean
from breastrig.scan.landmark_files import read_landmarks
from breastrig.scan.read import read_scan

EXAMPLE = asset_folder("example") / "standing"


@pytest.fixture(scope="module")
def task() -> FitTask:
    rig = read_rig(default_rig_path())
    surface = clean(read_scan(EXAMPLE / "scan.ply", None, "auto"))
    centre = surface.vertices.mean(axis=0)
    target = ScanTarget(surface.vertices - centre, surface.faces)
    _ = target.rays, target.search, target.normals, target.on_border, target.face_normals, target.vertex_tree
    places, unit = read_landmarks(EXAMPLE / "landmarks.json")
    assert unit == "mm"
    landmarks = {name: 1e-3 * np.asarray(place) - centre for name, place in places.items()}
    return FitTask(rig, target, start_from_landmarks(rig, landmarks), load_recipe("default"), landmarks)


def fitted(task: FitTask, preset: str = "default") -> int:
    """Iterations of one whole fit."""
    settings = FitTask(task.rig, task.target, task.start, load_recipe(preset), task.landmarks)
    return list(fit_iterates(settings))[-1].iteration


@pytest.fixture(scope="module")
def floor(task: FitTask) -> Callable[[], Any]:
    """One iteration of nothing but posing, rays, the symmetric product and Cholesky, for all vertices."""
    rig, x = task.rig, task.start
    normals_of = VertexNormals(rig.faces, len(rig.template))
    jacobian = Posed(rig, x).rows(np.arange(len(rig.template)), np.tile([0.0, 0.0, 1.0], (len(rig.template), 1)))
    assert task.target.rays is not None
    rays = task.target.rays

    def kernels() -> Any:
        vertices = Posed(rig, x).vertices
        normals = normals_of(vertices)
        rays.first_hits(np.concatenate([vertices, vertices]), np.concatenate([normals, -normals]), 0.02)
        product = jacobian.T @ jacobian
        return sla.cho_solve(sla.cho_factor(product + np.eye(len(product))), jacobian[0])

    return kernels


def test_floor_of_one_iteration(benchmark: Any, floor: Callable[[], Any]) -> None:
    benchmark(floor)


def test_posing(benchmark: Any, task: FitTask) -> None:
    benchmark(lambda: pose(task.rig, task.start))


@pytest.mark.parametrize("method", ["rays", "tree", "nearest_vertex"])
def test_matching(benchmark: Any, task: FitTask, method: str) -> None:
    vertices = pose(task.rig, task.start)
    normals = VertexNormals(task.rig.faces, len(vertices))(vertices)
    benchmark(lambda: match(task.target, vertices, normals, MatchRules(method, max_distance=0.02)))


def test_rows_of_the_jacobian(benchmark: Any, task: FitTask) -> None:
    everyone = np.arange(len(task.rig.template))
    normals = np.tile([0.0, 0.0, 1.0], (len(everyone), 1))
    benchmark(lambda: Posed(task.rig, task.start).rows(everyone, normals))


@pytest.mark.parametrize("preset", ["default", "paper"])
def test_whole_fit(benchmark: Any, task: FitTask, preset: str) -> None:
    benchmark.extra_info["iterations"] = benchmark.pedantic(lambda: fitted(task, preset), rounds=5, warmup_rounds=1)


def test_read_clean_and_index(benchmark: Any) -> None:
    def prepare() -> Any:
        surface = clean(read_scan(EXAMPLE / "scan.ply", None, "auto"))
        target = ScanTarget(surface.vertices, surface.faces)
        return target.rays, target.search, target.normals, target.on_border, target.vertex_tree

    benchmark.pedantic(prepare, rounds=5, warmup_rounds=1)


def test_peer_nricp_amberg(benchmark: Any, task: FitTask) -> None:
    """trimesh's free-form registration of the same template from the same start to the same scan."""
    source = trimesh.Trimesh(pose(task.rig, task.start), task.rig.faces, process=False)
    goal = trimesh.Trimesh(task.target.vertices, task.target.faces, process=False)
    benchmark.pedantic(
        lambda: trimesh.registration.nricp_amberg(source, goal, use_faces=False), rounds=1, warmup_rounds=0
    )

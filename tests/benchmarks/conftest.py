"""What the benchmarks share: the scans, the floor, and the table of ratios that ends a run of `make bench`."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as sla
from helpers.example_fit import EXAMPLE, example_task
from helpers.finer_scan import finer_scan, write_ply
from pytest_benchmark.utils import load_timer

from breastrig.fitting.fit import FitTask
from breastrig.geometry.normals import VertexNormals
from breastrig.rig.skinning import Posed

ROWS = pytest.StashKey[list[tuple[str, str, str]]]()  # (what, time, ratio)


@pytest.fixture(scope="session")
def scan_50k(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scan of 50,000 triangles, as a file."""
    return write_ply(tmp_path_factory.mktemp("scans") / "50k.ply", *finer_scan(EXAMPLE / "scan.ply", 0.00445))


@pytest.fixture(scope="session")
def scan_80k(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scan of 80,000 triangles, as a file."""
    return write_ply(tmp_path_factory.mktemp("scans") / "80k.ply", *finer_scan(EXAMPLE / "scan.ply", 0.00365))


@pytest.fixture(scope="session")
def task(scan_50k: Path) -> FitTask:
    return example_task(scan_50k)


@pytest.fixture(scope="session")
def floor(task: FitTask) -> Callable[[], Any]:
    """One iteration of nothing but posing, normals, rays, the symmetric product and Cholesky, for all vertices.

    The product is that of the full Jacobian, which the fit itself does not form (rig/normal_equations.py).
    """
    rig, x, rays = task.rig, task.start, task.target.rays
    assert rays is not None
    normals_of = VertexNormals(rig.faces, len(rig.template))
    jacobian = Posed(rig, x).rows(np.arange(len(rig.template)), np.tile([0.0, 0.0, 1.0], (len(rig.template), 1)))

    def kernels() -> Any:
        vertices = Posed(rig, x).vertices
        normals = normals_of(vertices)
        rays.hits(np.concatenate([vertices, vertices]), np.concatenate([normals, -normals]), 0.02)
        product = jacobian.T @ jacobian
        return sla.cho_solve(sla.cho_factor(product + np.eye(len(product))), jacobian[0])

    return kernels


class InTurn:
    """A yardstick that is measured before each round of a benchmark: the ratio of neighbours holds when times drift."""

    def __init__(self, timer: Callable[[], float], yardstick: Callable[[], Any], times: int = 1) -> None:
        self._timer, self._yardstick, self._times = timer, yardstick, times
        self.seconds: list[float] = []

    def __call__(self) -> None:
        """The `setup` of benchmark.pedantic."""
        began = self._timer()
        for _ in range(self._times):
            self._yardstick()
        self.seconds.append(self._timer() - began)

    def ratio(self, benchmark: Any) -> float:
        """Median over the rounds."""
        measured = np.array(benchmark.stats.stats.data)
        return float(np.median(measured / np.array(self.seconds[-len(measured) :])))


@pytest.fixture
def in_turn(request: pytest.FixtureRequest) -> Callable[..., InTurn]:
    """Makes yardsticks that are measured by the clock of the benchmarks."""
    timer = load_timer(str(request.config.getoption("benchmark_timer"))).target
    return lambda yardstick, times=1: InTurn(timer, yardstick, times)


@pytest.fixture
def row(request: pytest.FixtureRequest) -> Callable[[str, Any, str], None]:
    """Adds a line to the table: what was measured, the benchmark (or a text instead of its times), the ratio."""

    def add(what: str, measured: Any, ratio: str = "") -> None:
        times = measured
        if not isinstance(measured, str):
            stats = measured.stats.stats
            times = f"{1e3 * stats.min:9.2f} {1e3 * stats.median:9.2f}"
            measured.extra_info["ratio"] = ratio
        request.config.stash.setdefault(ROWS, []).append((what, times, ratio))

    return add


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    rows = config.stash.get(ROWS, [])
    if rows:
        terminalreporter.section("BreastRig: times and ratios, all of one run")
        terminalreporter.write_line(f"clock: {config.getoption('benchmark_timer')}")
        terminalreporter.write_line(f"{'':60} {'min ms':>9} {'median ms':>9}   ratio")
        for what, times, ratio in rows:
            terminalreporter.write_line(f"{what:60} {times:>19}   {ratio}")

"""Fixtures that every test may use, one BLAS thread, rare garbage collection, and signals as on a terminal.

One thread: at the sizes of this project more are slower, and times and last digits wander.
Modules and thousands of collected tests last as long as the process; they are looked through once instead of over and
over, and young objects more rarely than elsewhere: of every 80 s of work 6 went into that, now 3.
A shell starts what runs in the background with SIGINT ignored, and programs that tests start would inherit that.
Files are not synced to the disk: processes are killed here and machines are not, so that waiting for it shows nothing.
They are in memory where there is room (helpers/temporary.py).
"""

import gc
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg  # noqa: F401  loads SciPy's own BLAS, so that the limit below meets it too
from helpers import remembered
from helpers.batch_here import Here
from helpers.temporary import keep_in_memory
from hypothesis import HealthCheck, settings
from threadpoolctl import threadpool_limits

from breastrig.execution.worker import preload
from breastrig.rig.model import Rig

gc.set_threshold(50_000, 20, 20)
settings.register_profile("untimed", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("untimed")  # how long an example takes is the machine's affair
threadpool_limits(limits=1)  # this process
os.environ["OPENBLAS_NUM_THREADS"] = "1"  # and those that tests start

os.fsync = lambda _descriptor: None
keep_in_memory()

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

REPOSITORY = Path(__file__).resolve().parents[1]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files marked `long` first, so that no worker is left with one at the end; the others as they were found."""
    items.sort(key=lambda item: item.get_closest_marker("long") is None)


def pytest_collection_finish() -> None:
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def remembered_answers(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """This process, and tasks of services that it starts, compute once in a run what helpers.remembered lists."""
    if request.config.getoption("benchmark_only"):
        yield
        return
    folder = tmp_path_factory.getbasetemp()
    shared = folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder
    os.environ[remembered.FOLDER] = str(shared / "remembered")
    remembered.install()
    preload(["helpers.remembering"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pytest.MonkeyPatch, "setattr", _setattr)
        patch.setattr(pytest.MonkeyPatch, "undo", _undo)
        yield


_plain_setattr, _plain_undo = pytest.MonkeyPatch.setattr, pytest.MonkeyPatch.undo


def _setattr(patch: pytest.MonkeyPatch, target: Any, *more: Any, **named: Any) -> None:
    """As ever; while the program is another one, nothing is remembered."""
    place = (
        target if isinstance(target, str) else getattr(target, "__module__", None) or getattr(target, "__name__", "")
    )
    if remembered.computes(place):
        remembered.changed.add(patch)
    _plain_setattr(patch, target, *more, **named)


def _undo(patch: pytest.MonkeyPatch) -> None:
    _plain_undo(patch)
    remembered.changed.discard(patch)


@pytest.fixture
def computed_anew() -> Iterator[None]:
    """Nothing is remembered in this test: it compares what is computed twice, or counts."""
    remembered.changed.add(computed_anew)
    yield
    remembered.changed.discard(computed_anew)


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers that are the same in every run."""
    return np.random.default_rng(20_240_511)


@pytest.fixture(scope="session")
def toy_rig() -> Rig:
    """A small rig made in memory: the same form as ours, a hundredth of its size."""
    from helpers.toy_rig import toy_rig as make_toy_rig

    return make_toy_rig()


@pytest.fixture(scope="session")
def torso() -> Rig:
    """The rig of the package."""
    from breastrig.gltf.read_rig import default_rig_path, read_rig

    return read_rig(default_rig_path())


@pytest.fixture(scope="session")
def rig(torso: Rig) -> Rig:
    """The same, by the name of tests that have no other."""
    return torso


@pytest.fixture(scope="session")
def repository() -> Path:
    """The root of the checkout (or of the unpacked sdist)."""
    return REPOSITORY


@pytest.fixture
def batch_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """`breastrig batch` makes its fits in this process."""
    monkeypatch.setattr("breastrig.cli.batch_command._executor", lambda *_: Here())

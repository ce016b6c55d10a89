"""What the fork server makes ready before any fit is what fits then find."""

import gc
import importlib
import re
import shutil
from collections import Counter
from functools import _lru_cache_wrapper
from pathlib import Path

import pytest
from helpers.coarse_example import coarse_example

from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.use import default_model
from breastrig.use.fit import run_fit
from breastrig.use.steps.prepare import read_model
from breastrig.use.steps.settings import FitJob


def _caches() -> dict[str, "_lru_cache_wrapper[object]"]:
    """All functions of ours that remember what they returned, but those for colours, which few scans have."""
    found = (each for each in gc.get_objects() if type(each) is _lru_cache_wrapper)
    ours = (each for each in found if re.match(r"breastrig\.(?!colour\.)", str(getattr(each, "__module__", None))))
    return {f"{each.__module__}.{each.__name__}": each for each in ours}


def _computed(caches: dict[str, "_lru_cache_wrapper[object]"]) -> Counter[str]:
    """How often each of them had to compute something."""
    return Counter({name: cache.cache_info().misses for name, cache in caches.items()})


def test_the_model_of_a_job_is_there_already() -> None:
    importlib.reload(default_model)
    assert read_model(FitJob(Path("scan.ply"), Path("out"), {})) is read_rig(default_rig_path())


@pytest.mark.slow
@pytest.mark.usefixtures("computed_anew")
def test_the_first_fit_computes_nothing_that_the_second_one_finds(tmp_path: Path) -> None:
    coarse_example(tmp_path / "example")
    model = shutil.copytree(default_rig_path().parent, tmp_path / "model") / default_rig_path().name  # one of its own
    jobs = [FitJob(scan, tmp_path / "out", {}, model=model) for scan in (tmp_path / "example").glob("supine/scan.ply")]
    caches = _caches()
    for cache in caches.values():
        if cache is not read_rig:
            cache.cache_clear()
    default_model.precompute(read_rig(model))
    rounds = [_computed(caches)]
    for _ in range(2):
        for job in jobs:
            assert job.scan.is_file()
            list(run_fit(job))
        rounds.append(_computed(caches))
    first, second = rounds[1] - rounds[0], rounds[2] - rounds[1]
    assert first - second == Counter()

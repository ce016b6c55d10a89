"""All cases with all presets, over processes; finished ones are kept and not done again.

A generator of results in the order in which they are done; the caller shows progress and sorts.  One process a
core, each with one BLAS thread; with one job everything happens in the calling process.
"""

import hashlib
import multiprocessing
import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from breastrig import __version__
from breastrig.core.errors import FitFailed
from breastrig.evaluation.cohort import Case, fingerprint
from breastrig.evaluation.experiments import Plan, measured, table_row
from breastrig.evaluation.kept import Kept
from breastrig.evaluation.peers import PEERS, Peer
from breastrig.evaluation.subject import read_subject
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig


@dataclass(frozen=True)
class Order:
    """What is asked for, as plain values that travel between processes."""

    cases: tuple[Case, ...]
    presets: tuple[str, ...]  # presets, or names of peers
    model: Path | None
    out: Path
    plan: Plan = Plan()
    again: bool = False


@dataclass(frozen=True)
class Outcome:
    """One case with one preset: its numbers, or the reason why there are none."""

    case: Case
    preset: str  # as shown
    numbers: dict[str, Any]
    failed: str | None = None
    kept: bool = False  # from an earlier run


def preset_label(preset: str) -> str:
    """The name of a preset in tables and folders; a file's is its stem."""
    return Path(preset).stem if preset.endswith(".toml") else preset


def key_of(case: Case, preset: str, rig: Rig, plan: Plan) -> str:
    """What a result depends on, but the machine."""
    recipe = preset if preset in PEERS else load_recipe(preset).model_dump_json()
    parts = (fingerprint(case), rig.sha256, recipe, repr(asdict(plan)), __version__)
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def outcomes(order: Order, jobs: int) -> Iterator[Outcome]:
    """Results as they are done.  Raises BadInput for a case that cannot be read, FitFailed when a process dies."""
    tasks = [(order, case, preset) for preset in order.presets for case in order.cases]
    if jobs == 1:
        with threadpool_limits(1):
            for task in tasks:
                yield _one(*task)
        return
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(jobs, len(tasks)), mp_context=context, initializer=_one_thread)
    try:
        for future in as_completed([pool.submit(_one, *task) for task in tasks]):
            yield future.result()
    except BrokenProcessPool as error:
        raise FitFailed("A worker process died, perhaps for lack of memory; try again with fewer --jobs.") from error
    finally:
        pool.shutdown(cancel_futures=True)


def _one_thread() -> None:
    threadpool_limits(1)


@cache
def _rig(model: Path | None) -> Rig:
    return read_rig(model or default_rig_path())


def _one(order: Order, case: Case, preset: str) -> Outcome:
    rig, label, kept = _rig(order.model), preset_label(preset), Kept(order.out / "cases")
    key = key_of(case, preset, rig, order.plan)
    numbers = None if order.again else kept.load(case, label, key)
    if numbers is not None:
        return Outcome(case, label, numbers, numbers.get("failed"), kept=True)
    subject = read_subject(case, rig)
    try:
        if preset in PEERS:
            peer: Peer = PEERS[preset]
            fitted = peer(rig, subject)
            numbers = table_row(rig, subject, fitted)
        else:
            result = measured(rig, case, subject, load_recipe(preset), order.plan)
            numbers, fitted = result.numbers, result.fitted
    except FitFailed as error:
        kept.save(case, label, key, {"failed": str(error)}, None)
        return Outcome(case, label, {}, str(error))
    kept.save(case, label, key, numbers, fitted.vertices + subject.centre)
    return Outcome(case, label, numbers)

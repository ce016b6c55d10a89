"""All cases with all presets, over processes; what is finished is kept and not done again.

DIR/cases/PATIENT-STANCE-KEY.json holds a case's numbers (KEY: of the bytes of scan, landmarks and truth, of model,
preset and program version), the .npz beside it the fitted surface.  One process a core, one BLAS thread each.
"""

import hashlib
import json
import multiprocessing
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from breastrig import __version__
from breastrig.core.arrays import Array
from breastrig.core.errors import BadInput, FitFailed
from breastrig.evaluation.cohort import Case
from breastrig.evaluation.measure import evaluate_case, evaluate_peer
from breastrig.evaluation.peers import PEERS
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig


@dataclass(frozen=True)
class Task:
    """One case with one preset or peer, as plain values that travel between processes."""

    case: Case
    preset: str  # name, TOML file, or name of a peer
    model: Path | None
    kept: Path  # folder of finished cases

    @property
    def label(self) -> str:
        return self.preset if self.preset in PEERS else load_recipe(self.preset).name

    def file(self) -> Path:
        """Where the numbers are kept: other inputs have another name."""
        recipe = self.preset if self.preset in PEERS else load_recipe(self.preset).model_dump_json()
        parts = (self.case.fingerprint(), rig_of(self.model).sha256, recipe, __version__)
        key = hashlib.sha256("\n".join(parts).encode()).hexdigest()[:12]
        return self.kept / f"{self.case.patient}-{self.case.name}-{key}.json"


@cache
def rig_of(model: Path | None) -> Rig:
    """The rig of a file, or the package's."""
    return read_rig(model or default_rig_path())


def loaded(task: Task) -> dict[str, Any] | None:
    """The kept numbers of a task, or None."""
    try:
        return dict(json.loads(task.file().read_text("utf-8")))
    except (OSError, ValueError):
        return None


def fitted_surface(task: Task) -> Array:
    """(V, 3) m, in the scan's own frame."""
    with np.load(task.file().with_suffix(".npz")) as archive:
        return np.asarray(archive["vertices_m"], dtype=np.float64)


def carried_out(tasks: Sequence[Task], jobs: int) -> Iterator[Task]:
    """Each task once its numbers are kept, in the order of completion.

    Raises BadInput for a case that cannot be read, FitFailed when a process dies.  A fit without a usable result
    is a result, too: {"failed": sentence}.
    """
    if jobs == 1:
        for task in tasks:
            _carry_out(task)
            yield task
        return
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the processes inherit it
    pool = ProcessPoolExecutor(min(jobs, max(1, len(tasks))), mp_context=multiprocessing.get_context("spawn"))
    try:
        running = {pool.submit(_carry_out, task): task for task in tasks}
        for future in as_completed(running):
            future.result()
            yield running[future]
    except BrokenProcessPool as error:
        raise FitFailed("A worker process died, perhaps for lack of memory; try again with fewer --jobs.") from error
    finally:
        pool.shutdown(cancel_futures=True)


def _carry_out(task: Task) -> None:
    about = {
        "patient": task.case.patient,
        "case": task.case.name,
        "stance": task.case.stance,
        "family": task.case.family,
        "preset": task.label,
    }
    rig, surface = rig_of(task.model), None
    with threadpool_limits(1):
        try:
            if task.preset in PEERS:
                numbers, surface = evaluate_peer(task.case, rig, PEERS[task.preset])
            else:
                numbers, surface = evaluate_case(task.case, rig, load_recipe(task.preset))
        except FitFailed as error:
            numbers = {"failed": str(error)}
        except BadInput as error:
            raise BadInput(f"{task.case.title}: {error}") from error
    file = task.file()
    try:
        if surface is not None:
            with open(file.with_suffix(".npz"), "wb") as stream:
                np.savez_compressed(stream, vertices_m=surface)
        partial = file.with_suffix(".part")
        partial.write_text(json.dumps(about | numbers, indent=1, allow_nan=False) + "\n", "utf-8")
        os.replace(partial, file)
    except OSError as error:
        raise BadInput(f"{file} cannot be written ({error.strerror}); free space or choose another folder.") from error

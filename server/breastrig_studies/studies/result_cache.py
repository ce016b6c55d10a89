"""The work of an evaluation in small units: one question to one case, answered once and kept as a JSON file.

The file's name holds a hash of everything that the answer depends on: the case's files, the model, the preset's
contents, the question's parameters and the source of the code that answers.  So an interrupted run goes on where
it was, and a changed input is measured anew.  A fit that fails is an answer, too: its sentence is kept.
"""

import hashlib
import json
import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from numpy.linalg import LinAlgError
from threadpoolctl import threadpool_limits

from breastrig.core.assets import PACKAGE
from breastrig.core.errors import BadInput, BreastRigError, FitFailed
from breastrig.fitting.recipe import Recipe
from breastrig.gltf.read_rig import read_rig
from breastrig.rig.model import Rig
from breastrig_studies.cohort import Case
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.registry import ANSWERS

FILES = (
    *("scan.ply", "scan.zip", "landmarks.json", "case.json", "truth.ply"),
    *("skin.json", "ink.json", "ink_in_standing.json", "ink_in_supine.json"),
)
ROOMS = ("core", "geometry", "least_squares", "rig", "scan", "correspondence", "energies", "gltf", "fitting", "report")
ANSWERING = (  # the code that an answer depends on, besides the module of the question
    *(f"breastrig/{room}" for room in (*ROOMS, "__init__.py")),
    "breastrig_studies/studies/case.py",
    "breastrig_studies/studies/reference_fit.py",
    "breastrig_studies/studies/trust/reliability.py",
    "breastrig_studies/cohort.py",
)
WITH_DRAWINGS = ("transfer", "other_patient", "ink_transfer")
ASKED = ("asked", "captured")
OF_COLOUR = ("colour_landmarks", "ink", "ink_transfer")


@dataclass(frozen=True, eq=False)
class Unit:
    """One question to one case (or to all scans of one patient)."""

    cases: tuple[Case, ...]
    question: str
    recipe: Recipe
    model: Path
    settings: dict[str, Any] = field(default_factory=dict)  # further parameters of the question

    @property
    def label(self) -> str:
        """A label for progress bars and file names."""
        case = self.cases[0]
        return f"{case.patient}-{case.name if len(self.cases) == 1 else 'together'}-{self.question}"


@dataclass(frozen=True, eq=False)
class Record:
    """A unit with its answer; `failed` is the sentence of a fit that was not possible."""

    unit: Unit
    answer: dict[str, Any]
    failed: str | None

    @property
    def case(self) -> Case:
        return self.unit.cases[0]


@lru_cache(maxsize=1024)
def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else "-"


@lru_cache(maxsize=64)
def source_digest(question: str) -> str:
    """Hash of the code that answers: the numerics and the question's own module, as they were when first asked."""
    total = hashlib.sha256()
    module = ANSWERS[question].__module__.replace(".", "/") + ".py"
    own: tuple[str, ...] = (module,)
    if question in WITH_DRAWINGS:
        own += ("breastrig_studies/studies/transfer.py", "breastrig/drawings")
    if question in OF_COLOUR:
        own += ("breastrig/colour",)
    if question in ASKED:
        own += (
            "breastrig/use",
            "breastrig_studies/studies/trust/asked.py",
            "breastrig_studies/virtual/as_captured.py",
        )
    for name in (*ANSWERING, *own):
        place = PACKAGE.parent / name
        files = sorted(place.rglob("*")) if place.is_dir() else [place]
        for file in files:
            if file.suffix in (".py", ".toml"):
                total.update(file.relative_to(PACKAGE.parent).as_posix().encode() + b"\n" + file.read_bytes())
    return total.hexdigest()


def key(unit: Unit) -> str:
    """A hash of everything that the answer depends on."""
    about = {
        "question": unit.question,
        "settings": unit.settings,
        "recipe": unit.recipe.model_dump(mode="json"),
        "model": [_digest(unit.model), _digest(unit.model.with_suffix(".json"))],
        "code": source_digest(unit.question),
        "cases": [[case.stance, case.unit, *(_digest(case.folder / file) for file in FILES)] for case in unit.cases],
    }
    return hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()


@lru_cache(maxsize=2)
def _rig(model: Path) -> Rig:
    return read_rig(model)


def answered(unit: Unit) -> dict[str, Any]:
    """The answer as it is kept: {"failed", "answer", ...}."""
    answer, failed = {}, None
    with threadpool_limits(1):
        try:
            answer = ANSWERS[unit.question](unit.cases, _rig(unit.model), unit.recipe, **unit.settings)
        except (LinAlgError, FloatingPointError) as error:
            failed = f"The fit broke down: {error}."
        except BreastRigError as error:
            failed = str(error)
    case = unit.cases[0]
    return {
        "patient": case.patient,
        "case": case.name if len(unit.cases) == 1 else [each.name for each in unit.cases],
        "family": case.family,
        "question": unit.question,
        "preset": unit.recipe.name,
        "settings": unit.settings,
        "failed": failed,
        "answer": answer,
    }


def _kept(file: Path) -> dict[str, Any] | None:
    """A finished answer; None when there is none, or only half of one from a crash."""
    try:
        kept = json.loads(file.read_text("utf-8"))
    except (OSError, ValueError):
        return None
    return kept if isinstance(kept, dict) and "answer" in kept else None


def _keep(file: Path, answer: dict[str, Any]) -> None:
    half = file.with_suffix(".part")
    half.write_text(json.dumps(answer, indent=1, allow_nan=False) + "\n", "utf-8")
    half.replace(file)


def _in_processes(units: Sequence[Unit], jobs: int) -> Iterator[tuple[Unit, dict[str, Any]]]:
    """Answers as they come, in this process when one is enough."""
    if jobs <= 1:
        for unit in units:
            yield unit, answered(unit)
        return
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # for the processes to come
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context) as pool:
        running = {pool.submit(answered, unit): unit for unit in units}
        try:
            for future in as_completed(running):
                yield running[future], future.result()
        except BrokenProcessPool as error:
            raise FitFailed(
                "A worker process died, probably for want of memory; run the command again with fewer --jobs, "
                "it goes on where it was."
            ) from error
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def records(units: Iterable[Unit], folder: Path, jobs: int, again: bool, done: Callable[[str], None]) -> list[Record]:
    """All units answered, in their order; `done` is called with the label of each."""
    for cached in (_digest, _rig, read_scene):  # files may have changed since the last call
        cached.cache_clear()
    folder.mkdir(parents=True, exist_ok=True)
    wanted = list(units)
    if not wanted:
        raise BadInput("There is nothing to measure.")
    files = {unit: folder / f"{unit.label}-{key(unit)[:16]}.json" for unit in wanted}
    found: dict[Unit, dict[str, Any]] = {}
    for unit, file in files.items():
        kept = None if again else _kept(file)
        if kept is not None:
            found[unit] = kept
            done(unit.label)
    for unit, answer in _in_processes([unit for unit in wanted if unit not in found], jobs):
        _keep(files[unit], answer)
        found[unit] = answer
        done(unit.label)
    return [Record(unit, found[unit]["answer"], found[unit]["failed"]) for unit in wanted]

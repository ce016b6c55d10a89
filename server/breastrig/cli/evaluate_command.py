"""`breastrig evaluate COHORT -o DIR`: the paper's Table 1 and the study of the landmarks on a folder of patients."""

import argparse
import hashlib
import json
import multiprocessing
import os
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits
from tqdm import tqdm

from breastrig.evaluation.cohort import Case, read_cohort
from breastrig.evaluation.measure import evaluate_case
from breastrig.evaluation.tables import LANDMARKS, TABLE_1, as_csv, as_text
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("evaluate", help="measure the fit on a folder of patients", description=__doc__)
    parser.add_argument("cohort", type=Path, metavar="COHORT", help="PATIENT/STANCE/{scan.ply, landmarks.json, ...}")
    parser.add_argument("--preset", default="default", metavar="NAME", help="default, paper, or a TOML file")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="cases at a time")
    parser.add_argument("--again", action="store_true", help="measure finished cases again")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")
    parser.set_defaults(run=run)


def _measured(case: Case, recipe: Recipe) -> dict[str, Any]:
    with threadpool_limits(1):
        return evaluate_case(case, read_rig(default_rig_path()), recipe)


def _kept(folder: Path, case: Case, recipe: Recipe, model: str) -> Path:
    """The file of a finished case: other input files, another model or preset give it another name."""
    key = hashlib.sha256((model + recipe.model_dump_json()).encode())
    for file in ("scan.ply", "landmarks.json", "case.json", "truth.ply"):
        key.update((case.folder / file).read_bytes() if (case.folder / file).is_file() else b"-")
    return folder / f"{case.patient}-{case.name}-{key.hexdigest()[:12]}.json"


def run(options: argparse.Namespace) -> int:
    """Measures what is not yet measured, writes the tables, prints the means; returns 0."""
    cases, recipe = read_cohort(options.cohort), load_recipe(options.preset)
    finished = options.output / "cases"
    finished.mkdir(parents=True, exist_ok=True)
    model = read_rig(default_rig_path()).sha256
    files = {case: _kept(finished, case, recipe, model) for case in cases}
    missing = [case for case in cases if options.again or not files[case].is_file()]
    context = multiprocessing.get_context("spawn")
    with (
        ProcessPoolExecutor(max(1, options.jobs), mp_context=context) as pool,
        tqdm(total=len(missing), unit="case", disable=not sys.stderr.isatty(), leave=False) as bar,
    ):
        running = {pool.submit(_measured, case, recipe): case for case in missing}
        for future in as_completed(running):
            files[running[future]].write_text(json.dumps(future.result(), indent=1) + "\n")
            bar.update()
    numbers = [json.loads(files[case].read_text()) for case in cases]
    (options.output / "table1.csv").write_text(as_csv(numbers, TABLE_1))
    (options.output / "landmarks.csv").write_text(as_csv(numbers, LANDMARKS))
    print(as_text(numbers))
    return 0

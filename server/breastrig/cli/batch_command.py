"""`breastrig batch MANIFEST.csv -o DIR`: many scans, one row per fit.

The first line of the manifest names its columns: scan, and any of landmarks, length (A|B|MM), name, units, stance,
preset, drawing, tumour (several split by blanks), refine (yes, or no for the model alone), of label maps frame and
segments (2=lesion, several split by blanks), and of images series, lesions (files, split by |) and same_place, each as
the option of `breastrig fit`.
DIR/NAME/ holds what `breastrig fit` writes; DIR/batch.csv has the numbers of all rows.  A batch that was interrupted
goes on when it is called again: only rows that failed, are missing, or whose files or settings have changed are done.
"""

import argparse
import json
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event

from tqdm import tqdm

from breastrig.batch.manifest import INPUTS, BadManifest, BatchRow, read_manifest
from breastrig.batch.run import SPARE, Batch, exclusive, run_batch
from breastrig.batch.table import FILE, MEASURES, Outcome, is_table, write_table
from breastrig.batch.task import measured_fit
from breastrig.cli.messages.say import say
from breastrig.cli.options.output_options import MISFIT, add_output_options, output_folder
from breastrig.core.assets import model_path, packaged_models
from breastrig.core.errors import BadSettings
from breastrig.core.output_files import OutputSet, check_inputs_kept, check_output
from breastrig.core.scratch import sweep_scratch
from breastrig.execution.dask_pool import DaskPool
from breastrig.execution.dask_task import RESOURCE
from breastrig.execution.executor import Executor
from breastrig.execution.limits import FitLimits
from breastrig.execution.pool import Pool
from breastrig.execution.worker import preload
from breastrig.files.result import FIT_FILES
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.cohort_prior import read_prior, with_prior

EXAMPLE = """example of a manifest:
  scan,landmarks,name,stance,tumour
  a/standing.ply,a/standing.json,a_standing,standing,"L:10,45,12"
  a/supine.ply,a/supine.json,a_supine,supine,

on two machines, beside a scheduler (dask scheduler --host ADDRESS):
  breastrig worker tcp://ADDRESS:8786
  breastrig batch manifest.csv -o results --scheduler tcp://ADDRESS:8786
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.epilog, parser.formatter_class = EXAMPLE, argparse.RawDescriptionHelpFormatter
    parser.add_argument("manifest", type=Path, metavar="MANIFEST.csv", help="one scan a row")
    add_output_options(parser, "DIR", "folder for the results")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--jobs", type=int, metavar="N", help="fits at a time (default: one a core, at most 8)")
    where.add_argument("--scheduler", metavar="ADDRESS", help="a Dask scheduler, as in tcp://host:8786")
    parser.add_argument("--model", metavar="MODEL", help="another rig for all rows: male, or the .glb of your own")
    parser.add_argument(
        "--prior", type=Path, metavar="FILE", help="for all rows what a cohort's fits say of bodies: `breastrig cohort`"
    )
    parser.add_argument("--again", action="store_true", help="do also the rows that are done")
    parser.add_argument("--no-progress", action="store_true", help="no progress bar, no line for each row")


SHOWN_FAULTS = 20  # a screenful; a table with more has one cause


def run(options: argparse.Namespace) -> int:
    """Fits, writes and counts; 0: all is done, 1: rows failed or lack a pattern, 2: a manifest of no use."""
    if options.jobs is not None and options.jobs < 1:
        raise BadSettings("--jobs must be 1 or more.")
    glb = None if options.model is None else model_path(options.model)
    if options.scheduler is not None and glb not in (None, *packaged_models().values()):
        raise BadSettings("Other machines do not have a rig of your own; run its batch here, without --scheduler.")
    rig = read_rig(glb or default_rig_path())
    prior = None if options.prior is None else read_prior(options.prior)
    if prior is not None:
        with_prior(rig, prior)
    try:
        rows = read_manifest(options.manifest, rig, options.output, options.force, options.prior)
    except BadManifest as error:
        return _report_faults(error.faults)
    _check_places(options, rows, glb)
    ahead = 0 if options.scheduler is None else SPARE  # here a process stands ready, and is given what is at hand
    batch = Batch(
        rows,
        options.output,
        rig.sha256,
        options.model,
        again=options.again,
        prior=None if prior is None else prior.content(),
        runner=measured_fit,
        force=options.force,
        is_here=options.scheduler is None,
        ahead=ahead,
    )
    with exclusive(options.output):
        executor = _executor(options, rows)
        done: dict[str, Outcome] = {}
        try:
            with _orderly_end() as stop:
                _run(batch, executor, options.no_progress, stop, done)
        except BaseException:  # whatever ended it, the rows so far have their table
            with suppress(OSError):
                write_table(_in_order(rows, done), options.output)
            raise
        else:
            write_table(outcomes := _in_order(rows, done), options.output)
        finally:
            executor.stop()
            sweep_scratch()  # of fits that were stopped
    failed = sum(outcome.reason is not None for outcome in outcomes)
    if sys.stdout.isatty():
        print(f"Done: {len(outcomes) - failed} of {len(outcomes)}; {options.output / FILE} has the numbers.")
    if failed:
        return 1
    return MISFIT if any(outcome.missing for outcome in outcomes) else 0


def _in_order(rows: Sequence[BatchRow], done: dict[str, Outcome]) -> list[Outcome]:
    return [done[row.name] for row in rows if row.name in done]


def _check_places(options: argparse.Namespace, rows: Sequence[BatchRow], model: Path | None) -> None:
    """Raises BadInput when the table of results or a result would replace what must stay."""
    presets = {row.preset_file for row in rows if row.preset_file}
    rig = [] if model is None else [model, model.with_suffix(".json")]
    of_rows = [file for row in rows for file in (row.scan, row.landmarks) if file]
    names = () if is_table(options.output / FILE) else (FILE,)
    output = output_folder(options, OutputSet(Path(), names), also_read=[*rig, *presets, *of_rows])
    check_output(output)
    results = [options.output / row.name / name for row in rows for name in (*FIT_FILES, MEASURES, INPUTS)]
    check_inputs_kept([options.output / FILE, *results], output.inputs)


def _executor(options: argparse.Namespace, rows: Sequence[BatchRow]) -> Executor:
    limits = FitLimits()
    if options.scheduler is None:
        preload(["breastrig.batch.task", "breastrig.use.default_model"])
        return Pool().queue(options.jobs or limits.workers, limits.memory_bytes)
    pool = DaskPool(options.scheduler, memory_bytes=limits.memory_bytes)
    if not pool.found_workers:
        say(
            f"The scheduler has no worker of this version ({RESOURCE}) yet; the fits wait for one. "
            f"Start it with: breastrig worker {options.scheduler}",
        )
    return pool


@contextmanager
def _orderly_end() -> Iterator[Event]:
    """An event that Ctrl-C or a request to end sets, so that neither cuts into what is being written or started.

    The second Ctrl-C has its usual effect.
    """
    stop = Event()

    def note(_number: int, _frame: object) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()

    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _run(batch: Batch, executor: Executor, silent: bool, stop: Event, done: dict[str, Outcome]) -> None:
    """Notes each row in `done` and reports it: a bar on a terminal, or a line of JSON; failures on stderr."""
    in_lines = not silent and not sys.stderr.isatty()
    with tqdm(total=len(batch.rows), unit="fit", disable=silent or in_lines, leave=False, smoothing=0.1) as bar:

        def report(outcome: Outcome) -> None:
            done[outcome.name] = outcome
            bar.update()
            if in_lines:
                line: dict[str, object] = {"name": outcome.name, "state": outcome.state, "reason": outcome.reason}
                numbers = {name: outcome.numbers.get(name) for name in ("mean_mm", "verdict", "drawing_missing")}
                line |= {**numbers, "row": len(done), "of": len(batch.rows)}
                print(json.dumps(line), flush=True)
            if (said := outcome.reason or outcome.missing) is not None:
                bar.write(f"breastrig: {outcome.name}: {said}", file=sys.stderr)

        run_batch(batch, executor, report, stop)


def _report_faults(faults: list[str]) -> int:
    say(*faults[:SHOWN_FAULTS])
    if len(faults) > SHOWN_FAULTS:
        say(f"Wrong rows that are not shown: {len(faults) - SHOWN_FAULTS}.")
    return 2

"""Many fits, one after the other as far as memory goes, side by side as far as workers go.

Workers give bytes back and only this process writes: a result is a folder that appears whole under its name, with
a record of what it was made from.  So whatever ends a batch, a second one finds only whole results and goes on.

At most a few scans more than there are workers are in memory: enough that a worker never waits for the next one.
"""

import hashlib
import json
import os
import queue
import secrets
import shutil
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from fcntl import LOCK_EX, LOCK_NB, flock
from pathlib import Path
from threading import Event
from typing import Any

from breastrig.batch.manifest import INPUTS, INPUTS_SCHEMA, BatchRow
from breastrig.batch.table import MEASURES, Outcome, numbers_of
from breastrig.batch.task import FitOfBytes, Runner, fit_of_bytes, measured_fit
from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadInput, BadSettings, BreastRigError
from breastrig.core.output_files import Output, OutputSet, check_output
from breastrig.core.private_files import private_folder, read_ordinary, write_private
from breastrig.core.version import __version__
from breastrig.execution.executor import Executor
from breastrig.execution.limits import FitLimits
from breastrig.files.result import FIT_FILES, RESULT, RESULT_SCHEMA
from breastrig.scan.images.dicom_files import may_hold_dicom, sha256_of, zip_of_folder
from breastrig.scan.landmarks.landmark_files import LIMIT_BYTES
from breastrig.scan.limits import FILE_BYTES, IMAGE_ZIP_BYTES

SPARE = 8  # scans at most that wait beside the workers; a large cluster needs no more to be kept busy
LOOK_S = 0.2  # between two looks whether to stop
DIED = "The fit's process ended unexpectedly, perhaps for want of memory; run the batch again, or give a smaller scan."
BROKEN = "The fit broke for a reason inside BreastRig ({})."
MEMORY = "The fit needed more memory than it may use; give a smaller scan."


class BatchStopped(BreastRigError):
    """The batch cannot go on; what is done is kept."""


@dataclass(frozen=True)
class Batch:
    """A batch's rows, folder and options; `model_sha256` is the hash of the rig that the workers have."""

    rows: Sequence[BatchRow]
    folder: Path
    model_sha256: str
    model: str | None = None  # as FitOfBytes has it
    prior: bytes | None = None  # likewise
    again: bool = False  # do also what is done
    runner: Runner = measured_fit
    wall_s: float = FitLimits().wall_s
    force: bool = False  # replace also what no batch has written
    is_here: bool = False  # the workers have this machine's disk
    ahead: int = SPARE  # tasks at most that the executor is given beside those that it can run at once


@contextmanager
def exclusive(folder: Path) -> Iterator[None]:
    """Makes the folder, holds it for one batch, and removes what a killed one left half-written.

    Raises BadSettings.
    """
    try:
        private_folder(folder)
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError as error:
        raise BadSettings(f"The folder {folder} cannot be made ({error.strerror}); choose another with -o.") from error
    try:
        flock(handle, LOCK_EX | LOCK_NB)
        _remove_halves(folder)
        yield
    except BlockingIOError as error:
        raise BadSettings(f"Another batch is writing into {folder}; wait for its end, or choose another.") from error
    finally:
        os.close(handle)


def run_batch(
    batch: Batch, executor: Executor, on_outcome: Callable[[Outcome], None], stop: Event | None = None
) -> list[Outcome]:
    """One outcome for each row, in the rows' order; `on_outcome` is called with each as it comes.

    Raises BatchStopped when nothing can be written, or no worker be reached, any more, and KeyboardInterrupt soon
    after `stop` is set.
    """
    asked_to_stop = stop or Event()
    outcomes: dict[str, Outcome] = {}
    ended: queue.SimpleQueue[Future[dict[str, bytes]]] = queue.SimpleQueue()
    in_flight: dict[Future[dict[str, bytes]], tuple[BatchRow, dict[str, Any]]] = {}
    at_hand: deque[_Ready] = deque()  # read and checked, so that a worker that becomes free need not wait for that
    rows = iter(batch.rows)

    def note(outcome: Outcome) -> None:
        outcomes[outcome.name] = outcome
        on_outcome(outcome)

    def schedule() -> None:
        while at_hand and len(in_flight) < executor.workers + min(executor.workers, batch.ahead):
            row, inputs, task = at_hand.popleft()
            future = executor.schedule(fit_of_bytes, (task, batch.runner), batch.wall_s)
            in_flight[future] = row, inputs
            future.add_done_callback(ended.put)

    try:
        while True:
            while len(in_flight) + len(at_hand) < executor.workers + min(executor.workers, SPARE):
                row = None if asked_to_stop.is_set() else next(rows, None)
                if row is None:
                    break
                found = _looked_at(batch, row)
                if isinstance(found, Outcome):
                    note(found)
                    continue
                at_hand.append(found)
                schedule()
            schedule()
            if asked_to_stop.is_set() and len(outcomes) < len(batch.rows):
                raise KeyboardInterrupt
            if not in_flight:
                return [outcomes[row.name] for row in batch.rows]
            with suppress(queue.Empty):
                future = ended.get(timeout=LOOK_S)
                row, inputs = in_flight.pop(future)
                schedule()
                note(_outcome(batch, row, inputs, future))
    finally:
        for future in in_flight:
            future.cancel()
        _remove_halves(batch.folder)


_Ready = tuple[BatchRow, dict[str, Any], FitOfBytes]


def _looked_at(batch: Batch, row: BatchRow) -> _Ready | Outcome:
    """The row with its inputs and its task; or its outcome, where nothing is left to do."""
    try:
        task = _fit_of(batch, row)
        inputs = _inputs(batch, row, task)
    except BadInput as error:
        return Outcome(row.name, str(error))
    except OSError as error:
        return Outcome(row.name, f"The files of this row cannot be read any more ({error.strerror}).")
    found = None if batch.again else _found(batch.folder / row.name, inputs)
    if found is not None:
        return found
    try:
        check_output(_output(batch, row))
    except BadInput as error:
        return Outcome(row.name, str(error))
    return row, inputs, task


def _fit_of(batch: Batch, row: BatchRow) -> FitOfBytes:
    return FitOfBytes(
        scan=row.scan if batch.is_here and may_hold_dicom(row.scan) else scan_bytes(row.scan),
        ending=row.scan.suffix,
        landmarks=read_ordinary(row.landmarks, LIMIT_BYTES) if row.landmarks else None,
        landmarks_ending=row.landmarks.suffix if row.landmarks else "",
        settings=row.settings,
        preset_file=read_ordinary(row.preset_file, LIMIT_BYTES) if row.preset_file else None,
        units=row.units,
        model=batch.model,
        prior=batch.prior,
        answers=row.answers,
        lesions=tuple(read_ordinary(each, FILE_BYTES) for each in row.lesions),
    )


def scan_bytes(scan: Path) -> bytes:
    """Of the file, or a zip of a folder's DICOM files.  TooLarge, BadScan, OSError."""
    if scan.is_dir():
        return zip_of_folder(scan, IMAGE_ZIP_BYTES)
    return read_ordinary(scan, IMAGE_ZIP_BYTES if may_hold_dicom(scan) else FILE_BYTES)


def _inputs(batch: Batch, row: BatchRow, task: FitOfBytes) -> dict[str, Any]:
    """Everything that a result depends on; no file names."""
    return {
        "schema": INPUTS_SCHEMA,
        "scan_sha256": sha256_of(row.scan if row.scan.is_dir() else task.scan),
        "landmarks_sha256": _sha256(task.landmarks),
        "units": task.units,
        "stance": task.settings.stance,
        "preset": task.settings.preset if task.preset_file is None else None,
        "preset_sha256": _sha256(task.preset_file),
        "drawing": task.settings.drawing,
        "refine": task.settings.refine,
        "model_sha256": batch.model_sha256,
        "prior_sha256": _sha256(task.prior),
        "breastrig": __version__,
    } | _said(task)


def _said(task: FitOfBytes) -> dict[str, Any]:
    """A length, a person's answers about volumes, and files of lesions, for the inputs' record; empty without any."""
    answers, lesions, length = task.answers, task.lesions, task.settings.length
    segments = {str(number): what for number, what in answers.segments.items()}
    said: dict[str, Any] = {"frame": answers.frame, "segments": segments} if answers else {}
    if answers.series is not None:
        said["series"] = answers.series
    if lesions:
        said |= {"lesions_sha256": [_sha256(each) for each in lesions], "same_place": answers.same_place}
    if length is not None:
        said["length"] = [length.start, length.end, length.mm]
    return said


def _output(batch: Batch, row: BatchRow) -> Output:
    """The result's folder; one of an earlier batch is replaced, also if it is damaged."""
    folder = batch.folder / row.name
    inputs = tuple(file for file in (row.scan, row.landmarks, *row.lesions) if file is not None)
    record = (INPUTS, INPUTS_SCHEMA) if (folder / INPUTS).is_file() else (RESULT, RESULT_SCHEMA)
    return Output(folder, (OutputSet(Path(), (*FIT_FILES, MEASURES, INPUTS), *record),), inputs, batch.force)


def _sha256(content: bytes | None) -> str | None:
    return None if content is None else hashlib.sha256(content).hexdigest()


def _found(folder: Path, inputs: dict[str, Any]) -> Outcome | None:
    """A whole result of the same inputs, from an earlier batch."""
    try:
        if json.loads((folder / INPUTS).read_bytes()) != inputs:
            return None
        return Outcome(folder.name, None, numbers_of((folder / RESULT).read_bytes(), (folder / MEASURES).read_bytes()))
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _outcome(batch: Batch, row: BatchRow, inputs: dict[str, Any], future: "Future[dict[str, bytes]]") -> Outcome:
    """The outcome of a fit that has ended; a result is kept. Raises BatchStopped."""
    try:
        files = future.result()
        numbers = numbers_of(files[RESULT], files[MEASURES])
    except (CancelledError, TimeoutError, BreastRigError, MemoryError, OSError, RuntimeError) as error:
        return Outcome(row.name, _why(error, batch.wall_s))
    except Exception as error:
        return Outcome(row.name, BROKEN.format(type(error).__name__))
    try:
        _keep(batch.folder, row.name, files | {INPUTS: json_bytes(inputs)})
    except OSError as error:
        raise BatchStopped(
            f"The results cannot be written ({error.strerror}); free space, then run the same command: it goes on."
        ) from error
    return Outcome(row.name, None, numbers)


def _why(error: BaseException, wall_s: float) -> str:
    """The sentence for a fit without a result. Raises BatchStopped when no later fit can have one either."""
    if isinstance(error, ConnectionError):
        raise BatchStopped("The scheduler was lost; run the same command again, it goes on where it was.") from error
    if isinstance(error, TimeoutError):
        return f"The fit took longer than {wall_s:g} s and was stopped."
    if isinstance(error, BreastRigError):
        return str(error)
    if isinstance(error, MemoryError):
        return MEMORY
    if isinstance(error, OSError) and error.errno is not None:
        return f"The fit's worker met an error of its disk or system ({error.strerror}); run the batch again."
    return DIED


def _keep(folder: Path, name: str, files: dict[str, bytes]) -> None:
    """The result's folder, whole or not at all, in the place of an older one; what others put there stays."""
    half = folder / f".part-{secrets.token_hex(8)}"
    private_folder(half)
    for file, content in files.items():
        write_private(half / file, content)
    place = folder / name
    if place.is_dir() and any(each.name not in files for each in place.iterdir()):
        write_private(place / INPUTS, json_bytes({"schema": INPUTS_SCHEMA}))  # until all are there: made again
        for file in sorted(files, key=INPUTS.__eq__):
            os.replace(half / file, place / file)
        half.rmdir()
        return
    old = folder / f".old-{secrets.token_hex(8)}"
    if place.exists():
        place.rename(old)
    half.rename(place)
    shutil.rmtree(old, ignore_errors=True)


def _remove_halves(folder: Path) -> None:
    for half in (*folder.glob(".part-*"), *folder.glob(".old-*")):
        shutil.rmtree(half, ignore_errors=True)

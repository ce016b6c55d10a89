"""What becomes of the rows of a batch, on local processes; the fits are fake ones that do as their scan says."""

import json
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from helpers import fake_batch

from breastrig.batch.manifest import BatchRow
from breastrig.batch.run import DIED, Batch, BatchStopped, _fit_of, _inputs, exclusive, run_batch
from breastrig.batch.table import Outcome, write_table
from breastrig.batch.task import FitOfBytes, fit_of_bytes
from breastrig.core.errors import BadSettings
from breastrig.execution.pool import Pool, TaskQueue
from breastrig.execution.worker import preload
from breastrig.use.steps.events import Event
from breastrig.use.steps.settings import FitJob, FitSettings


@pytest.fixture(scope="module")
def processes() -> Iterator[TaskQueue]:
    preload(["breastrig.batch.task", "helpers.fake_batch"])
    processes = Pool().queue(2, 4 * 2**30)
    yield processes
    processes.stop()


def batch_of(folder: Path, scans: dict[str, str]) -> Batch:
    rows = []
    for name, content in scans.items():
        (folder / f"{name}.ply").write_text(content)
        rows.append(BatchRow(name, folder / f"{name}.ply", None, "auto", FitSettings(drawing=None, refine=False)))
    (folder / "out").mkdir(exist_ok=True)
    return Batch(rows, folder / "out", "0" * 64, runner=fake_batch.scripted_fit, wall_s=2.0)


def silent(_outcome: Outcome) -> None:
    pass


def test_a_failing_row_stops_no_other_and_says_why(processes: TaskQueue, tmp_path: Path) -> None:
    scans = {"one": "fail", "two": "bug", "three": "die", "four": "greedy", "five": "slow 60", "six": "fine"}
    outcomes_seen: list[Outcome] = []
    outcomes = run_batch(batch_of(tmp_path, scans), processes, outcomes_seen.append)
    assert [outcome.name for outcome in outcomes] == list(scans)
    assert [outcome.reason for outcome in outcomes] == [
        "The model found no skin near it; place three landmarks.",
        "The fit broke for a reason inside BreastRig (ZeroDivisionError).",
        DIED,
        "The fit needed more memory than it may use; give a smaller scan.",
        "The fit took longer than 2 s and was stopped.",
        None,
    ]
    assert sorted(outcome.name for outcome in outcomes_seen) == sorted(scans)
    assert [entry.name for entry in (tmp_path / "out").iterdir()] == ["six"]
    assert {file.name for file in (tmp_path / "out" / "six").iterdir()} == {*fake_batch.FILES, "inputs.json"}


def test_what_a_landmark_file_calls_certain_reaches_the_fit() -> None:
    def runner(job: FitJob) -> Iterator[Event]:
        job.out.mkdir()
        (job.out / "certain").write_text(",".join(job.certain))
        return iter(())

    picks = b'{"unit": "mm", "landmarks": {"xiphoid": [1, 2, 3], "umbilicus": [4, 5, 6]}, "certain": ["umbilicus"]}'
    for landmarks, expected in ((picks, b"umbilicus"), (picks.replace(b'"umbilicus"]', b"]"), b""), (None, b"")):
        task = FitOfBytes(b"", ".ply", landmarks, "", FitSettings(), units="mm")
        assert fit_of_bytes(task, runner) == {"certain": expected}


def test_an_mri_is_read_by_the_worker_itself_where_it_has_the_same_disk(tmp_path: Path) -> None:
    """Up to nine zips of 1 GB would else be in memory."""
    mri, mesh = tmp_path / "mri.zip", tmp_path / "scan.ply"
    mri.write_bytes(b"PK\x03\x04 fine")
    mesh.write_bytes(b"ply")
    rows = [BatchRow(each.stem, each, None, "auto", FitSettings()) for each in (mri, mesh)]
    given = {
        is_here: [_fit_of(Batch(rows, tmp_path, "", is_here=is_here), row) for row in rows] for is_here in (True, False)
    }
    assert [task.scan for task in given[True]] == [mri, b"ply"]
    assert [task.scan for task in given[False]] == [mri.read_bytes(), b"ply"]
    batch = Batch(rows, tmp_path, "")
    here, elsewhere = ([_inputs(batch, *each) for each in zip(rows, tasks, strict=True)] for tasks in given.values())
    assert here == elsewhere

    def runner(job: FitJob) -> Iterator[Event]:
        job.out.mkdir()
        (job.out / "scan").write_bytes(job.scan.read_bytes())
        return iter(())

    assert fit_of_bytes(given[True][0], runner) == {"scan": mri.read_bytes()}
    assert mri.exists()


def test_only_what_failed_is_missing_or_has_changed_is_done_again(processes: TaskQueue, tmp_path: Path) -> None:
    batch = batch_of(tmp_path, {name: f"fine {name}" for name in "abcde"} | {"f": "fail"})
    out = batch.folder
    first = run_batch(batch, processes, silent)
    before = {name: (out / name / "result.json").stat().st_ino for name in "abcde"}

    (tmp_path / "a.ply").write_text("fine other")
    (tmp_path / "f.ply").write_text("fine f")
    (out / "c" / "inputs.json").unlink()
    (out / "d" / "result.json").write_text('{"half')
    changed = {"b": replace(batch.rows[1], settings=replace(batch.rows[1].settings, stance="supine"))}
    again = replace(batch, rows=[changed.get(row.name, row) for row in batch.rows])
    second = run_batch(again, processes, silent)

    assert [outcome.state for outcome in second] == ["done"] * 6
    after = {name: (out / name / "result.json").stat().st_ino for name in "abcde"}
    assert {name for name in "abcde" if before[name] != after[name]} == {"a", "b", "c", "d"}
    assert second[4] == first[4]  # what was done has the same numbers, times too
    assert second[1].numbers["stance"] == "supine"
    assert json.loads((out / "a" / "result.json").read_text())["scan"]["triangles"] == len("fine other")
    assert sorted(entry.name for entry in out.iterdir()) == list("abcdef")

    for asked in (replace(again, again=True), replace(again, prior=b"{}")):
        run_batch(replace(asked, rows=again.rows[4:5]), processes, silent)
        assert (out / "e" / "result.json").stat().st_ino != after["e"]
        after["e"] = (out / "e" / "result.json").stat().st_ino


def test_a_result_names_what_it_was_made_from_but_no_file(processes: TaskQueue, tmp_path: Path) -> None:
    batch = batch_of(tmp_path, {"one": "fine"})
    run_batch(batch, processes, silent)
    text = (batch.folder / "one" / "inputs.json").read_text()
    assert json.loads(text)["schema"] == "breastrig/batch-inputs@1"
    assert str(tmp_path) not in text
    assert "one" not in json.loads(text).values()


def test_one_batch_at_a_time_and_halves_of_a_killed_one_are_removed(tmp_path: Path) -> None:
    for half in (".part-1", ".old-2"):
        (tmp_path / half).mkdir()
        (tmp_path / half / "scan.ply").write_text("half")
    with exclusive(tmp_path):
        assert list(tmp_path.iterdir()) == []
        with pytest.raises(BadSettings, match="Another batch is writing"), exclusive(tmp_path):
            pass
    with exclusive(tmp_path):
        pass


def test_a_folder_that_cannot_be_made_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BadSettings, match="cannot be made"), exclusive(tmp_path / "file" / "out"):
        pass


class Slow:
    """An executor that ends the oldest task now and then, and counts how many wait."""

    def __init__(self, workers: int, end: Callable[["Future[Any]", tuple[Any, ...]], None]) -> None:
        self.workers = workers
        self.most = 0
        self._waiting: list[tuple[Future[Any], tuple[Any, ...]]] = []
        self._end = end
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._work)
        self._thread.start()

    def schedule(
        self, _function: object, args: tuple[Any, ...], timeout: float, key: str | None = None
    ) -> "Future[Any]":
        assert timeout > 0
        self._waiting.append((Future(), args))
        self.most = max(self.most, len(self._waiting))
        return self._waiting[-1][0]

    def _work(self) -> None:
        while not self._stopped.is_set():
            time.sleep(0.001)
            if self._waiting:
                future, args = self._waiting.pop(0)
                if future.set_running_or_notify_cancel():
                    self._end(future, args)

    def warm_up(self) -> None: ...

    def answer(self, wait_s: float) -> bool:
        return wait_s > 0

    def stop(self) -> None:
        self._stopped.set()
        self._thread.join()


def test_a_long_manifest_does_not_fill_the_memory(tmp_path: Path) -> None:
    def end(future: "Future[Any]", args: tuple[Any, ...]) -> None:
        future.set_exception(BadSettings(args[0].scan.decode()))

    executor = Slow(3, end)
    outcomes = run_batch(batch_of(tmp_path, {f"row{n}": f"scan {n}" for n in range(200)}), executor, silent)
    executor.stop()
    assert executor.most == 6
    assert [outcome.reason for outcome in outcomes] == [f"scan {n}" for n in range(200)]


def test_an_executor_with_processes_that_stand_ready_has_no_task_more_than_it_can_run(tmp_path: Path) -> None:
    def end(future: "Future[Any]", args: tuple[Any, ...]) -> None:
        future.set_exception(BadSettings(args[0].scan.decode()))

    executor = Slow(3, end)
    batch = replace(batch_of(tmp_path, {f"row{n}": f"scan {n}" for n in range(200)}), ahead=0)
    outcomes = run_batch(batch, executor, silent)
    executor.stop()
    assert executor.most == 3
    assert [outcome.reason for outcome in outcomes] == [f"scan {n}" for n in range(200)]


def test_a_batch_that_is_stopped_before_its_first_row_is_stopped(tmp_path: Path) -> None:
    stop = threading.Event()
    stop.set()
    executor = Slow(1, lambda future, args: None)
    with pytest.raises(KeyboardInterrupt):
        run_batch(batch_of(tmp_path, {"row": "scan"}), executor, silent, stop)
    executor.stop()
    assert executor.most == 0


def test_a_lost_scheduler_or_a_full_disk_ends_the_batch_with_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lost = Slow(1, lambda future, _: future.set_exception(ConnectionResetError("gone")))
    with pytest.raises(BatchStopped, match="scheduler was lost; run the same command again"):
        run_batch(batch_of(tmp_path, {"a": "fine", "b": "fine"}), lost, silent)
    lost.stop()

    def full(_self: Path, _content: bytes) -> int:
        raise OSError(28, "No space left on device")

    result = json.dumps(fake_batch.result_of("fine")).encode()
    whole = Slow(1, lambda future, _: future.set_result({"result.json": result, "measures.csv": b""}))
    batch = batch_of(tmp_path, {"a": "fine", "b": "fine"})
    monkeypatch.setattr("breastrig.batch.run.write_private", full)
    with pytest.raises(BatchStopped, match=r"No space left on device\); free space"):
        run_batch(batch, whole, silent)
    whole.stop()
    assert list(batch.folder.iterdir()) == []


def test_the_table_has_a_line_for_each_row(tmp_path: Path) -> None:
    write_table([Outcome("Zoë, 2", "It failed; try again."), Outcome("b", None, {"mean_mm": 0.5})], tmp_path)
    head, first, second = (tmp_path / "batch.csv").read_text().splitlines()
    assert head == (
        "name,state,reason,stance,unit,triangles,mean_mm,std_mm,max_mm,p95_mm,coverage,landmark_mean_mm,iterations,"
        "solve_s,total_s,verdict,model_alone_mean_mm,drawing_missing"
    )
    assert first == '"Zoë, 2",failed,It failed; try again.,,,,,,,,,,,,,,,'
    assert second == "b,done,,,,,0.5,,,,,,,,,,,"

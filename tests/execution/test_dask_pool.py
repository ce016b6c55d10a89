"""The same contract as local processes, kept by a scheduler and two worker processes on loopback."""

import json
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import wait
from pathlib import Path

import pytest
from helpers import fake_batch, in_worker
from helpers.dask_cluster import LIGHT, PLACES, Cluster, cluster, wait_until_ready
from helpers.real_server import alive
from helpers.waiting import until

from breastrig.cli import batch_command
from breastrig.cli.main import main
from breastrig.core.errors import BadScan, BadSettings, TooMany
from breastrig.execution.dask_pool import DaskPool
from breastrig.execution.dask_worker import run_worker

pytestmark = pytest.mark.long

GIB = 2**30


@pytest.fixture(scope="module")
def two_workers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with cluster(tmp_path_factory.mktemp("cluster"), LIGHT) as found:
        yield found


@pytest.fixture
def pool(two_workers: Cluster) -> Iterator[DaskPool]:
    pool = DaskPool(two_workers.address, memory_bytes=4 * GIB)
    yield pool
    pool.stop()


def signed(file: Path) -> list[int]:
    return [int(line) for line in file.read_text().split()] if file.exists() else []


def test_a_task_runs_in_a_child_of_a_worker_within_its_limits(pool: DaskPool, two_workers: Cluster) -> None:
    assert pool.workers == 2
    assert pool.answer(5.0)
    found = pool.schedule(in_worker.describe, (), 30.0).result()
    assert found["pid"] not in {worker.pid for worker in two_workers.workers}
    assert (found["memory"][0], found["core"]) == (4 * GIB, (0, 0))
    assert found["threads"] == [1]
    assert found["imported"]


def test_errors_come_back_as_they_are_with_their_sentence(pool: DaskPool) -> None:
    refused = pool.schedule(in_worker.refuse, ("This is no scan; export it again.",), 30.0)
    busy = pool.schedule(in_worker.refuse_for_now, ("Too much at once; ask again.", 7), 30.0)
    odd = pool.schedule(in_worker.raise_what_cannot_travel, (), 30.0)
    with pytest.raises(BadScan, match=r"^This is no scan; export it again\.$"):
        refused.result()
    with pytest.raises(TooMany, match="Too much at once") as found:
        busy.result()
    assert found.value.retry_after_s == 7
    with pytest.raises(RuntimeError, match="Unpicklable: half and half"):
        odd.result()


def test_time_and_crash_end_one_task_only(pool: DaskPool) -> None:
    late = pool.schedule(in_worker.rest, (60.0,), 0.2)
    dead = pool.schedule(in_worker.die, (signal.SIGKILL,), 30.0)
    fine = pool.schedule(in_worker.weigh, (b"scan",), 30.0)
    with pytest.raises(TimeoutError):
        late.result()
    with pytest.raises(OSError, match="ended unexpectedly"):
        dead.result()
    assert fine.result() == 4


def test_a_scan_of_many_megabytes_travels_without_a_warning(pool: DaskPool) -> None:
    assert pool.schedule(in_worker.weigh, (bytes(30_000_000),), 30.0).result() == 30_000_000


def test_cancelling_ends_the_future_at_once_and_kills_the_child(
    pool: DaskPool, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = tmp_path / "signed"
    future = pool.schedule(in_worker.sign_in_and_rest, (str(file), 60.0, 1), 60.0)
    ended = threading.Event()
    future.add_done_callback(lambda _: ended.set())
    until(lambda: len(signed(file)) == 1, "the task to run")
    assert future.cancel()
    assert future.cancelled()
    assert ended.is_set()
    assert wait([future], timeout=0).done == {future}
    assert future.cancel()  # again, to no effect
    assert not caplog.records
    until(lambda: not alive(set(signed(file))), "the child to be killed")
    assert pool.schedule(in_worker.weigh, (b"1",), 30.0).result() == 1  # the worker is free again


def test_stopping_kills_what_runs_and_takes_nothing_more(two_workers: Cluster, tmp_path: Path) -> None:
    pool = DaskPool(two_workers.address, memory_bytes=4 * GIB)
    file = tmp_path / "signed"
    futures = [pool.schedule(in_worker.sign_in_and_rest, (str(file), 60.0, 1), 60.0) for _ in range(4)]
    until(lambda: len(signed(file)) == 2, "two tasks to run")
    pool.stop()
    assert all(future.cancelled() for future in futures)
    until(lambda: not alive(set(signed(file))), "the children to be killed")
    assert not pool.answer(1.0)
    with pytest.raises(RuntimeError, match="stopped"):
        pool.schedule(in_worker.rest, (0.0,), 1.0)


def test_the_child_of_a_client_that_vanishes_is_killed(two_workers: Cluster, tmp_path: Path) -> None:
    file = tmp_path / "signed"
    program = (
        "from breastrig.execution.dask_pool import DaskPool; from helpers import in_worker\n"
        f"DaskPool({two_workers.address!r}, memory_bytes=2**32)"
        f".schedule(in_worker.sign_in_and_rest, ({str(file)!r}, 60.0, 1), 60.0).result()"
    )
    client = subprocess.Popen([sys.executable, "-c", program], env={"PYTHONPATH": PLACES})
    until(lambda: len(signed(file)) == 1, "the task to run")
    client.kill()
    client.wait()
    until(lambda: not alive(set(signed(file))), "the child to be killed")


def test_what_a_killed_worker_had_is_done_by_the_other_once(two_workers: Cluster, tmp_path: Path) -> None:
    newcomer = two_workers.start_worker()
    pool = DaskPool(two_workers.address, memory_bytes=4 * GIB)
    ends: list[int] = []
    file = tmp_path / "signed"
    end = tmp_path / "end"
    futures = [pool.schedule(in_worker.sign_in_and_wait_for, (str(file), str(end), n), 60.0) for n in range(5)]
    for future in futures:
        future.add_done_callback(lambda done: ends.append(done.result()))
    until(lambda: len(signed(file)) >= 2, "both workers to be at work")
    two_workers.workers[0].kill()
    end.touch()
    assert [future.result(timeout=60) for future in futures] == list(range(5))
    until(lambda: sorted(ends) == list(range(5)), "each end to be told, once")
    assert len(signed(file)) > 5  # what was lost had been begun
    until(lambda: not alive(set(signed(file))), "the killed worker's child to notice")
    wait_until_ready(newcomer)
    until(lambda: pool.workers == 2, "the loss and the new worker to be noticed")
    pool.stop()


def test_nothing_of_a_task_is_logged_or_named(two_workers: Cluster, pool: DaskPool) -> None:
    secret = "Doe_Jane_left.ply"
    futures = [
        pool.schedule(function, (secret,), 30.0) for function in (in_worker.refuse, in_worker.weigh, in_worker.die)
    ]
    wait(futures)
    assert "Register worker" in two_workers.said()  # it is the log
    assert "Doe" not in two_workers.said()


MIXED = {f"row{n}": f"slow 0.{n}" for n in range(1, 4)} | {"bad": "fail", "dead": "die"}


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch_command, "measured_fit", fake_batch.scripted_fit)


def _without_times(out: Path) -> list[dict[str, str]]:
    return [
        {column: value for column, value in row.items() if column not in ("solve_s", "total_s")}
        for row in fake_batch.table(out)
    ]


@pytest.mark.usefixtures("fake")
def test_a_batch_on_a_cluster_that_loses_a_worker_makes_the_same_table(
    two_workers: Cluster, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    manifest = fake_batch.write_manifest(tmp_path, MIXED)
    there, here = tmp_path / "there", tmp_path / "here"

    def kill_one() -> None:
        until(lambda: any(there.glob("row*")), "the first result")
        two_workers.workers[1].kill()

    killer = threading.Thread(target=kill_one)
    killer.start()
    assert main(["batch", str(manifest), "-o", str(there), "--scheduler", two_workers.address]) == 1
    killer.join()
    told = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert sorted(line["name"] for line in told) == sorted(MIXED)  # each once

    assert main(["batch", str(manifest), "-o", str(here), "--jobs", "2"]) == 1
    assert _without_times(there) == _without_times(here)
    assert [row["state"] for row in fake_batch.table(there)] == ["done"] * 3 + ["failed"] * 2
    names = {name for name in MIXED if name.startswith("row")}
    assert fake_batch.whole_results(there) == fake_batch.whole_results(here) == names
    for name in names:
        for file in fake_batch.WHOLE - {"result.json"}:
            assert (there / name / file).read_bytes() == (here / name / file).read_bytes()


@pytest.mark.usefixtures("fake")
def test_a_scheduler_that_vanishes_ends_a_batch_with_one_sentence(
    two_workers: Cluster, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """After the tests above: the third worker is left."""
    manifest = fake_batch.write_manifest(tmp_path, {f"row{n}": f"slow 0.{n}" for n in range(3, 9)})
    out = tmp_path / "out"

    def kill_it() -> None:
        until(lambda: any(out.glob("row*")), "the first result")
        two_workers.scheduler.kill()

    killer = threading.Thread(target=kill_it)
    killer.start()
    assert main(["batch", str(manifest), "-o", str(out), "--scheduler", two_workers.address]) == 1
    killer.join()
    assert capsys.readouterr().err == (
        "breastrig: The scheduler was lost; run the same command again, it goes on where it was.\n"
    )
    assert 0 < len(fake_batch.whole_results(out)) < 6
    assert two_workers.workers[2].wait(timeout=30) == 1
    assert f"The scheduler at {two_workers.address} is gone" in two_workers.said()


def test_an_address_without_a_scheduler_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("breastrig.execution.dask_pool.CONNECT_S", 0.3)
    for address in ("tcp://127.0.0.1:9", "carrier-pigeon://here"):
        with pytest.raises(BadSettings, match=r"No Dask scheduler answers at .*; check the address, or start"):
            DaskPool(address, memory_bytes=GIB)
    with pytest.raises(BadSettings, match="check the address and the certificates"):
        DaskPool("tls://127.0.0.1:9", memory_bytes=GIB)  # there are none


def test_a_worker_without_a_scheduler_says_so_and_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("breastrig.execution.dask_worker.CONNECT_S", 0.3)
    for address in ("tcp://127.0.0.1:9", "carrier-pigeon://here"):
        with pytest.raises(BadSettings, match=f"^No Dask scheduler answers at {address}; check the address"):
            run_worker(address, 1, pytest.fail)


def test_without_distributed_one_sentence_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(BadSettings, match=r"pip install 'breastrig\[dask\]'"):
        DaskPool("tcp://127.0.0.1:9", memory_bytes=GIB)

"""Scratch folders: gone with their block, and gone soon after a process that was killed."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from helpers.waiting import until

from breastrig.core.scratch import scratch_folder, sweep_scratch
from breastrig.execution.worker import scratch_swept

HOLD = """
import os, sys, time
from breastrig.core.scratch import scratch_folder
with scratch_folder() as folder:
    (folder / "scan.ply").write_bytes(b"skin")
    print(folder, flush=True)
    time.sleep(60)
"""


@pytest.fixture(autouse=True)
def place(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    return tmp_path / f"breastrig-{os.getuid()}"


def test_a_scratch_folder_is_its_owners_alone_and_is_gone_at_the_end(place: Path) -> None:
    with scratch_folder() as folder, scratch_folder() as other:
        assert folder != other
        (folder / "scan.ply").write_bytes(b"skin")
        assert folder.parent == place
        assert [path.stat().st_mode & 0o077 for path in (place, folder)] == [0, 0]
        sweep_scratch()
        assert folder.is_dir()
    assert list(place.iterdir()) == []


def test_the_folder_of_a_killed_process_is_removed_and_that_of_a_living_one_is_not(place: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", HOLD], stdout=subprocess.PIPE, text=True) as process:
        folder = Path(process.stdout.readline().strip())
        sweep_scratch()
        assert (folder / "scan.ply").is_file()
        process.send_signal(signal.SIGKILL)
        process.wait()
        assert (folder / "scan.ply").is_file()
        sweep_scratch()
    assert list(place.iterdir()) == []


def test_whoever_kills_processes_sweeps_on(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("breastrig.execution.worker.SWEEP_S", 0.01)
    with scratch_swept():
        for name in ("left", "left_again"):
            (place / name).mkdir(parents=True, mode=0o700)
            place.chmod(0o700)
            until(lambda: not list(place.iterdir()), "the sweep")
        with scratch_folder() as folder:
            time.sleep(0.05)
            assert folder.is_dir()


@pytest.mark.parametrize("kind", ["open to others", "a link", "a file", "somebody else's"])
def test_where_its_place_is_taken_another_is_found_and_swept(
    kind: str, place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    theirs = tmp_path / "theirs"
    theirs.mkdir(mode=0o700)
    if kind == "a link":
        place.symlink_to(theirs)
    elif kind == "a file":
        place.write_bytes(b"")
    else:
        place.mkdir(mode=0o700)
        place.chmod(0o755 if kind == "open to others" else 0o700)
    if kind == "somebody else's":
        ours = Path.lstat

        def lstat(self: Path) -> os.stat_result:
            facts = ours(self)
            return os.stat_result([*facts[:4], facts.st_uid + 1, *facts[5:]]) if self == place else facts

        monkeypatch.setattr(Path, "lstat", lstat)
    with scratch_folder() as folder, scratch_folder() as second:
        assert folder.parent == second.parent != place
        assert folder.parent.parent == tmp_path
        assert folder.parent.stat().st_mode & 0o077 == 0
    (folder.parent / "left").mkdir()
    sweep_scratch()
    assert [*folder.parent.iterdir(), *theirs.iterdir()] == []

"""Scratch folders: gone with their block, and gone soon after a process that was killed."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from helpers.waiting import until

from breastrig.core.errors import BadSettings
from breastrig.core.scratch import scratch_folder, sweep_scratch
from breastrig.execution.scratch_sweeper import scratch_swept

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
        assert process.stdout is not None
        folder = Path(process.stdout.readline().strip())
        sweep_scratch()
        assert (folder / "scan.ply").is_file()
        process.send_signal(signal.SIGKILL)
        process.wait()
        assert (folder / "scan.ply").is_file()
        sweep_scratch()
    assert list(place.iterdir()) == []


def test_whoever_kills_processes_sweeps_on(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("breastrig.execution.scratch_sweeper.SWEEP_S", 0.01)
    with scratch_swept():
        for name in ("left", "left_again"):
            (place / name).mkdir(parents=True, mode=0o700)
            place.chmod(0o700)
            until(lambda: not list(place.iterdir()), "the sweep")
        with scratch_folder() as folder:
            time.sleep(0.05)
            assert folder.is_dir()


def test_a_place_that_others_could_look_into_is_refused(place: Path) -> None:
    place.mkdir(mode=0o755)
    place.chmod(0o755)
    with pytest.raises(BadSettings, match="is not this user's own"):
        sweep_scratch()

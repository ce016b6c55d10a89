"""What `make test` does with its parts: side by side, each one's lines together, failed when one of them has failed."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.waiting import PATIENCE_S, until

Start = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def start(tmp_path: Path, repository: Path) -> Start:
    """Starts the program with a `make` that runs the script of each target in a group of processes of its own."""

    def start(**scripts: str) -> "subprocess.Popen[str]":
        for target, script in scripts.items():
            (tmp_path / target).write_text(script)
        make = tmp_path / "make"
        make.write_text('#!/bin/sh\nexec sh "./$1"\n')
        make.chmod(0o700)
        words = [sys.executable, str(repository / ".ci/run_targets.py"), str(make), *scripts]
        return subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, text=True, start_new_session=True)

    return start


WAIT_FOR = "echo {0} begins; touch {0}.on; while [ ! -e {1}.on ]; do sleep 0.05; done; echo {0} ends >&2"


def test_targets_run_side_by_side_and_their_lines_stand_together(start: Start) -> None:
    with start(one=WAIT_FOR.format("one", "two"), two=WAIT_FOR.format("two", "one")) as process:
        said, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0
    parts = [part.splitlines() for part in said.strip().split("\n\n")]
    assert parts == [
        ["== one", "one begins", "one ends"],
        ["== two", "two begins", "two ends"],
        ["== all passed: one, two"],
    ]


def test_a_target_that_fails_is_named_and_the_others_are_seen_to_their_end(start: Start) -> None:
    with start(one="echo broken; exit 3", two="sleep 0.3; echo whole", three="exit 1") as process:
        said, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1
    parts = [part.splitlines() for part in said.strip().split("\n\n")]
    assert parts == [["== one", "broken"], ["== two", "whole"], ["== three"], ["== failed: one, three"]]


def test_ctrl_c_ends_all_targets(start: Start, tmp_path: Path) -> None:
    endless = "trap 'touch {0}.off; exit 130' INT; touch {0}.on; while true; do sleep 0.05; done"
    with start(one=endless.format("one"), two=endless.format("two")) as process:
        until(lambda: all((tmp_path / f"{name}.on").exists() for name in ("one", "two")), "both targets")
        os.killpg(process.pid, signal.SIGINT)
        process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert {path.name for path in tmp_path.glob("*.off")} == {"one.off", "two.off"}

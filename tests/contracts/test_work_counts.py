"""A task does no more work than work_counts.toml says: counted, so that a slow or busy machine changes nothing."""

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

HERE = Path(__file__).parent
MOST = tomllib.loads((HERE / "work_counts.toml").read_text())
SPARE = 0.15  # share by which a task may do less before the number has to be lowered; versions of libraries differ


def test_every_number_has_a_task_and_every_task_its_numbers() -> None:
    from helpers.counted_work import TASKS

    assert MOST.keys() == TASKS.keys()


@pytest.fixture(scope="module")
def counted() -> dict[str, dict[str, int]]:
    words = [sys.executable, "-m", "helpers.counted_work"]
    done = subprocess.run(words, cwd=HERE.parent, capture_output=True, text=True, check=False, env=os.environ)
    assert done.returncode == 0, done.stderr
    found: dict[str, dict[str, int]] = json.loads(done.stdout.splitlines()[-1])
    return found


@pytest.mark.slow
@pytest.mark.parametrize("task", MOST)
def test_a_task_does_no_more_than_is_said(task: str, counted: dict[str, dict[str, int]]) -> None:
    found = counted[task]
    more = {name: count for name, count in found.items() if count > MOST[task].get(name, 0)}
    assert more == {}, "more work than before: mend it, or raise the number with its reason in work_counts.toml"
    less = {name: found.get(name, 0) for name, most in MOST[task].items() if found.get(name, 0) < (1 - SPARE) * most}
    assert less == {}, "less work than before: lower the numbers in work_counts.toml, so that it stays"

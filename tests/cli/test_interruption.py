"""Ctrl-C is obeyed whenever it comes: while modules load, where a library swallows it, and during the fit."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from breastrig.core.assets import asset_folder

pytestmark = pytest.mark.long

EXAMPLE = asset_folder("example") / "standing"
SCAN, PICKS = str(EXAMPLE / "scan.ply"), str(EXAMPLE / "landmarks.json")
SIGNAL_AT_IMPORT = """
import importlib.abc, os, signal, sys

class Interrupting(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), signal.{signal})

sys.meta_path.insert(0, Interrupting())
"""
SIGNAL_AT_EVENT = """
import breastrig.fitting.hypotheses, breastrig.use.fit, gc, os, signal, sys
original = breastrig.use.fit.checked_iterates

def swallowing():
    try:
        os.kill(os.getpid(), signal.SIGTERM)
        for _ in range(1000):
            pass
    except BaseException:
        pass

def interrupted(*given, **named):
    for k, iterate in enumerate(original(*given, **named)):
        if k == 3:
            swallowing()
        yield iterate

breastrig.use.fit.checked_iterates = breastrig.fitting.hypotheses.checked_iterates = interrupted
"""


def run(before: str, out: Path | None) -> subprocess.CompletedProcess[str]:
    """`breastrig fit`, or what needs no scan, in a process of its own, in which `before` is run first."""
    words = ["breastrig", "fit", SCAN, "--landmarks", PICKS, "--drawing", "none", "-o", str(out)]
    words = words if out else ["breastrig", "presets", "list"]
    start = f"\nsys.argv = {words!r}\n"
    start += "from breastrig.cli.entry import entry\nentry()\n"
    return subprocess.run([sys.executable, "-c", before + start], capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_a_signal_while_modules_load_ends_the_program_with_one_line(tmp_path: Path) -> None:
    ended = run(SIGNAL_AT_IMPORT.format(module="argparse", signal="SIGINT"), tmp_path / "out")
    assert (ended.stdout, ended.stderr, ended.returncode) == ("", "breastrig: stopped.\n", 130)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_signal_during_the_fit_leaves_nothing_behind_also_if_someone_swallows_it(tmp_path: Path) -> None:
    ended = run(SIGNAL_AT_EVENT, tmp_path / "out")
    assert (ended.stdout, ended.stderr, ended.returncode) == ("", "breastrig: stopped.\n", 143)
    assert os.listdir(tmp_path) == []


def test_a_signal_that_is_ignored_stays_ignored() -> None:
    """As under nohup, or in the background of a shell."""
    before = "import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\n"
    ended = run(before + SIGNAL_AT_IMPORT.format(module="argparse", signal="SIGINT"), None)
    assert ended.returncode == 0
    assert ended.stderr == ""
    assert "default" in ended.stdout

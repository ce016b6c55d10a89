"""The command's fits of the example patient, for tests of what is done with fits: made once in a run, then copied.

Tests of the fit itself make their own.
"""

import fcntl
import os
import shutil
from pathlib import Path

from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from helpers.remembered import FOLDER

STANCES = ("standing", "supine")


def write_example_fits(folder: Path) -> None:
    """FOLDER/standing and FOLDER/supine, each as `breastrig fit` with her landmarks writes it."""
    if FOLDER not in os.environ:
        return _fit(folder)
    known = Path(os.environ[FOLDER], "example_fits")
    known.parent.mkdir(parents=True, exist_ok=True)
    with known.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # another process may be making them
        if not known.is_dir():
            making = known.with_suffix(".making")
            shutil.rmtree(making, ignore_errors=True)
            _fit(making)
            making.rename(known)
    shutil.copytree(known, folder, dirs_exist_ok=True)
    return None


def _fit(folder: Path) -> None:
    for stance in STANCES:
        example = asset_folder("example") / stance
        scan, landmarks = str(example / "scan.ply"), str(example / "landmarks.json")
        assert main(["fit", scan, "--landmarks", landmarks, "-o", str(folder / stance)]) == 0

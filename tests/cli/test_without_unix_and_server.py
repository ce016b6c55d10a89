"""The commands that need no server work without its packages and without what only Unix has."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers import windows_like
from helpers.coarse_example import coarse_example
from helpers.inked_scan import inked_zip

from breastrig.cli.commands import COMMANDS, OF_THE_SERVER, OF_UNIX

pytestmark = pytest.mark.long

QUIET = ("-W", "error", "-W", "ignore:only soft file lock")  # filelock's own word where there is neither system's lock
FORBIDDEN = set('<>:"|?*\\')  # in names of files on Windows


def said(missing: str, *commands: str, folder: Path) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, *QUIET, "-m", windows_like.__name__, missing, " -- ".join(commands)]
    path = os.pathsep.join([str(Path(windows_like.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    surroundings = os.environ | {"PYTHONPATH": path, "TMPDIR": str(folder), "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.run(words, cwd=folder, env=surroundings, capture_output=True, text=True, timeout=300)


@pytest.mark.slow
def test_fit_to_report_work_as_they_do_on_windows(tmp_path: Path) -> None:
    coarse_example(tmp_path / "example")
    standing = tmp_path / "example" / "standing"
    (tmp_path / "inked.zip").write_bytes(inked_zip())
    run = said(
        "unix",
        f"fit {standing}/scan.ply --landmarks {standing}/landmarks.json --no-refine -o a",
        f"fit {standing}/scan.ply --landmarks {standing}/landmarks.json -o a",  # in the place of an earlier one
        "transfer --from a --to a -o there.json",
        "compare a/drawing.json there.json --on a -o both",
        "report a -o report",
        "export a -o export",
        f"landmarks {standing}/scan.ply -o proposed.json",
        "ink inked.zip --units m -o ink.json",
        "model check",
        folder=tmp_path,
    )
    done = [line for line in run.stdout.splitlines() if line.partition(":")[0] in COMMANDS]
    assert run.returncode == 0, run.stderr
    assert done == [
        *("fit: 0", "fit: 0", "transfer: 0", "compare: 0", "report: 0", "export: 0", "landmarks: 0"),
        *("ink: 0", "model: 0"),
    ], run.stderr
    files = [file for file in tmp_path.rglob("*") if file.is_file()]
    assert {"result.json", "there.json", "compare.csv", "measures.csv", "surface.json"} <= {file.name for file in files}
    assert [file for file in files if set(file.name) & FORBIDDEN or file.name.endswith((".", " "))] == []
    assert [file for file in tmp_path.rglob("*") if "part" in file.name or file.suffix == ".lock"] == []


@pytest.mark.slow
@pytest.mark.parametrize("command", OF_UNIX)
def test_what_needs_unix_says_so_in_one_sentence(command: str, tmp_path: Path) -> None:
    run = said(
        "unix",
        {"worker": "worker tcp://x:1", "purge": "purge --all", "batch": "batch x -o y"}.get(command, command),
        folder=tmp_path,
    )
    assert run.stdout == f"{command}: 2\n"
    assert (
        run.stderr
        == f"breastrig: `breastrig {command}` needs Linux or macOS; fits, reports and the library work here as well.\n"
    )


@pytest.mark.slow
@pytest.mark.parametrize("command", OF_THE_SERVER)
def test_without_the_server_it_says_how_to_install_it(command: str, tmp_path: Path) -> None:
    run = said("server", "purge --all" if command == "purge" else command, folder=tmp_path)
    assert run.stdout == f"{command}: 2\n"
    assert run.stderr == f'breastrig: `breastrig {command}` needs the server: pip install "breastrig[server]".\n'

"""What the README shows works as printed."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from breastrig.cli.main import main


def block(readme: str, section: str) -> str:
    """The first Python block below that heading."""
    found = re.search(rf"^## {section}\n.*?```python\n(.*?)```", readme, re.DOTALL | re.MULTILINE)
    assert found
    return found[1]


def test_the_lines_in_python_fit_measure_and_carry(repository: Path, tmp_path: Path) -> None:
    example = repository / "model_assets" / "example"
    for stance in ("standing", "supine"):
        shutil.copy(example / stance / "scan.ply", tmp_path / f"{stance}.ply")
    shutil.copy(example / "standing" / "landmarks.json", tmp_path)
    lines = block((repository / "README.md").read_text(), "In Python") + "assert len(there.lines) == 4\n"
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", lines], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith("good (")
    assert "'volume'" in run.stdout
    assert (tmp_path / "out" / "result.json").is_file()


def test_the_python_client_does_a_whole_fit(repository: Path, tmp_path: Path) -> None:
    for name in ("scan.ply", "landmarks.json"):
        shutil.copy(repository / "model_assets" / "example" / "standing" / name, tmp_path)
    serve = [sys.executable, "-m", "breastrig.cli.main", "serve", "--port", "0", "--data", str(tmp_path / "data")]
    with subprocess.Popen(serve, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            address = re.search(r"http://[^/\s]+", server.stdout.readline())
            assert address
            client = block((repository / "README.md").read_text(), "Over HTTP").replace(
                "http://127.0.0.1:8321", address[0]
            )
            run = subprocess.run(
                [sys.executable, "-W", "error", "-c", client], cwd=tmp_path, capture_output=True, text=True, timeout=120
            )
            scans = list((tmp_path / "data" / "scans").iterdir())
        finally:
            server.terminate()
    assert run.returncode == 0, run.stderr
    assert "iterated" in run.stdout
    for name in ("result.json", "fitted.glb", "drawing.json", "report.pdf"):
        assert (tmp_path / name).stat().st_size > 1000, name
    assert scans == []  # it deletes what it has uploaded
    assert "'mean'" in run.stdout.splitlines()[-1]


def test_every_command_of_the_readme_exists(repository: Path) -> None:
    readme = (repository / "README.md").read_text()
    for command in sorted(set(re.findall(r"^breastrig (\w+(?: (?:info|check))?)", readme, re.MULTILINE))):
        with pytest.raises(SystemExit) as left:
            main([*command.split(), "--help"])
        assert left.value.code == 0, command
    for target in re.findall(r"^make (\w+)", readme, re.MULTILINE):
        assert re.search(rf"^{target}:", (repository / "Makefile").read_text(), re.MULTILINE), target
    for picture in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", readme):
        assert (repository / picture).is_file(), picture

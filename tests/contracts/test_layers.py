"""Imports only go downwards: import-linter keeps the house in order, and is itself put to the test.

The contract stands in pyproject.toml.  A keeper that lets everything pass would go unnoticed, so each kind of
violation is written into a copy of the package, and must be found there under its contract's name.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

FROM_THE_CLI = "import sys; from importlinter.cli import lint_imports_command; sys.exit(lint_imports_command())"


def lint_imports(folder: Path) -> subprocess.CompletedProcess[str]:
    """Runs import-linter on the package and the pyproject.toml that stand in `folder`."""
    return subprocess.run(
        [sys.executable, "-c", FROM_THE_CLI, "--no-cache", "--config", "pyproject.toml"],
        cwd=folder,
        env=os.environ
        | {"PYTHONPATH": str(folder / "server"), "PYTHONDONTWRITEBYTECODE": "1", "NO_COLOR": "1", "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def copy_of_the_house(tmp_path: Path, repository: Path) -> Path:
    shutil.copy(repository / "pyproject.toml", tmp_path)
    shutil.copytree(
        repository / "server" / "breastrig",
        tmp_path / "server" / "breastrig",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    return tmp_path


def test_imports_only_go_downwards(repository: Path) -> None:
    answer = lint_imports(repository)
    assert answer.returncode == 0, answer.stdout + answer.stderr


@pytest.mark.parametrize(
    ("files", "contract"),
    [
        ({"rig/one.py": "import breastrig.service"}, "the house: imports only go downwards"),
        ({"report/one.py": "import breastrig.drawings"}, "the house: imports only go downwards"),
        ({"utils/__init__.py": ""}, "the house: imports only go downwards"),
        (
            {"energies/one.py": "import breastrig.energies.two", "energies/two.py": ""},
            "residual terms do not know each other",
        ),
        ({"rig/one.py": "import breastrig.scan", "scan/one.py": "import breastrig.rig"}, "no cycles between siblings"),
        ({"fitting/one.py": "import flask"}, "Flask stays in the entrance hall"),
        ({"storage/one.py": "import numpy"}, "storage keeps rows, not mathematics"),
        ({"interface/one.py": "import breastrig.storage"}, "programs need neither server nor database"),
        ({"interface/one.py": "import breastrig.api"}, "the house: imports only go downwards"),
        ({"scan/one.py": "import threading"}, "the numerics know neither SQL nor threads"),
    ],
    ids=lambda value: "+".join(value) if isinstance(value, dict) else "",
)
def test_a_deliberate_violation_is_caught(copy_of_the_house: Path, files: dict[str, str], contract: str) -> None:
    for name, line in files.items():
        path = copy_of_the_house / "server" / "breastrig" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(line + "\n")
    answer = lint_imports(copy_of_the_house)
    assert answer.returncode != 0
    assert f"{contract} BROKEN" in answer.stdout, answer.stdout + answer.stderr

"""Imports only go downwards: import-linter checks the layers, and is itself put to the test.

The contract stands in pyproject.toml.  A checker that lets everything pass would go unnoticed, so each kind of
violation is written into a copy of the package, and must be found there under its contract's name.
"""

import ast
import os
import re
import shutil
import subprocess
import sys
import tomllib
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
def copy_of_the_package(tmp_path: Path, repository: Path) -> Path:
    shutil.copy(repository / "pyproject.toml", tmp_path)
    for package in ("breastrig", "breastrig_studies"):
        shutil.copytree(
            repository / "server" / package,
            tmp_path / "server" / package,
            ignore=shutil.ignore_patterns("__pycache__"),
        )
    return tmp_path


def rooms_above(room: str, repository: Path) -> set[str]:
    """Those that may import it, and those beside it: all that it must not know."""
    contracts = tomllib.loads((repository / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    layers = next(each["layers"] for each in contracts if each["type"] == "layers")
    rooms = [[name.strip() for name in layer.split("|")] for layer in layers]
    level = next(k for k, layer in enumerate(rooms) if room in layer)
    return {name for layer in rooms[: level + 1] for name in layer} - {room}


def test_execution_names_no_module_of_the_rooms_above_it_not_even_in_a_string(repository: Path) -> None:
    above = rooms_above("execution", repository)
    assert {"service", "use", "storage"} <= above
    named = re.compile(rf"\bbreastrig[./]({'|'.join(sorted(above))})\b")
    found = {
        f"{file.name}:{node.lineno}: {node.value}"
        for file in (repository / "server" / "breastrig" / "execution").rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and named.search(node.value)
    }
    assert not found


LAYERS = "layers: imports only go downwards"
VIOLATIONS = (  # contract, the module that breaks it, what it imports
    (LAYERS, "rig.one", "breastrig.service"),
    (LAYERS, "drawings.one", "breastrig.report"),
    (LAYERS, "fitting.two", "breastrig.report"),
    (LAYERS, "use.one", "breastrig.api"),
    ("residual terms do not know each other", "energies.one", "breastrig.energies.table_contact"),
    ("Flask stays in api", "fitting.one", "flask"),
    ("use knows neither processes nor the index", "use.two", "breastrig.storage.storage"),
    ("programs need neither server nor database", "use.three", "breastrig.storage"),
    ("the numerics know neither SQL nor threads", "scan.one", "threading"),
)


def test_every_deliberate_violation_is_caught_under_its_contract(copy_of_the_package: Path) -> None:
    package = copy_of_the_package / "server" / "breastrig"
    for _, module, imported in VIOLATIONS:
        (package / f"{module.replace('.', '/')}.py").write_text(f"import {imported}\n")
    answer = lint_imports(copy_of_the_package)
    assert answer.returncode != 0
    parts = re.split(r"^(.+)\n-{5,}\n", answer.stdout, flags=re.MULTILINE)  # a heading, what stands below it, and so on
    found = dict(zip(parts[1::2], parts[2::2], strict=True))
    for contract, module, imported in VIOLATIONS:
        assert f"{contract} BROKEN" in answer.stdout, answer.stdout + answer.stderr
        assert re.search(rf"-\s+breastrig\.{module} -> {imported} \(l\.1\)", found[contract]), found[contract]


@pytest.mark.parametrize(
    ("files", "contract"),
    [
        ({"utils/__init__.py": ""}, LAYERS),
        ({"rig/one.py": "import breastrig.scan", "scan/one.py": "import breastrig.rig"}, "no cycles between siblings"),
    ],
    ids=["a new room", "a cycle"],
)
def test_a_room_without_a_layer_and_a_cycle_are_caught(
    copy_of_the_package: Path, files: dict[str, str], contract: str
) -> None:
    for name, line in files.items():
        path = copy_of_the_package / "server" / "breastrig" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(line + "\n")
    answer = lint_imports(copy_of_the_package)
    assert answer.returncode != 0
    assert f"{contract} BROKEN" in answer.stdout, answer.stdout + answer.stderr

"""What the contract tests read: the files that belong to the project."""

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

NOT_OURS = {".git", ".venv", ".ci-venv", ".make", "node_modules", "dist", "__pycache__", "sources", "data"}


def walk(root: Path) -> Iterator[str]:
    """Paths of an unpacked sdist, where there is no git to ask."""
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(name for name in folders if name not in NOT_OURS and not name.endswith("_cache"))
        for name in files:
            if name != "PKG-INFO":
                yield (Path(folder) / name).relative_to(root).as_posix()


@pytest.fixture(scope="session")
def project_files(repository: Path) -> list[str]:
    """Tracked files as paths from the root; outside a git checkout, all files that are not made by tools."""
    answer = subprocess.run(["git", "ls-files", "-z"], cwd=repository, capture_output=True, text=True, check=False)
    if answer.returncode == 0 and (repository / ".git").exists():
        return [name for name in answer.stdout.split("\0") if name and (repository / name).is_file()]
    return list(walk(repository))


@pytest.fixture(scope="session")
def project_texts(repository: Path, project_files: list[str]) -> dict[str, str]:
    """The text of each text file among them, by path."""
    texts = {}
    for name in project_files:
        content = (repository / name).read_bytes()
        if b"\0" not in content[:8192]:
            texts[name] = content.decode("utf-8", errors="replace")
    return texts

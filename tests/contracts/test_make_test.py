"""All that the parts of `make test` install is there before they run: two installations exclude each other."""

import re
import tomllib
from importlib.metadata import version
from pathlib import Path

from packaging.requirements import Requirement


def _extras_of(requirement: str) -> set[str]:
    """Of our own, that it names."""
    return set(Requirement(requirement).extras) if requirement.startswith("breastrig[") else set()


def _rule(makefile: str, target: str) -> tuple[set[str], str]:
    """The target's prerequisites and its recipe."""
    found = re.search(rf"^{target}:(.*)\n((?:\t.*\n)+)", makefile, re.MULTILINE)
    assert found is not None, target
    return set(found[1].split()), found[2]


def test_every_program_of_the_parts_is_looked_for_before_they_start(repository: Path) -> None:
    makefile = (repository / "Makefile").read_text("utf-8")
    before, recipe = _rule(makefile, "test")
    parts = re.findall(r"\w+", recipe.split("$(MAKE)")[1])
    needed = {script for part in parts for script in re.findall(r"sh (\.ci/\S+\.sh)", _rule(makefile, part)[1])}
    assert {".ci/chromium.sh", ".ci/nginx.sh"} <= needed
    assert "programs" in before
    assert needed <= set(re.findall(r"sh (\.ci/\S+\.sh)", _rule(makefile, "programs")[1]))


def test_make_serve_installs_the_extras_of_all_that_the_service_reads_and_writes(repository: Path) -> None:
    """Rooms that numerics of a request enter name an extra in the sentence that says what is missing."""
    makefile = (repository / "Makefile").read_text("utf-8")
    extras = tomllib.loads((repository / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    [names] = re.findall(r"\"\.\[([\w,]+)\]\"", _rule(makefile, r"\$\(VENV\)/\.stamp-serve")[1])
    installed = set(names.split(","))
    installed |= {one for name in installed for each in extras[name] for one in _extras_of(each)}
    rooms = [repository / "server" / "breastrig" / room for room in ("scan", "volume")]
    texts = [file.read_text("utf-8") for room in rooms for file in room.rglob("*.py")]
    assert {name for text in texts for name in re.findall(r"breastrig\[(\w+)\]", text)} <= installed


def test_the_tests_have_every_library_that_they_are_promised(repository: Path) -> None:
    """So that none is left out because what it is about is not there."""
    project = tomllib.loads((repository / "pyproject.toml").read_text("utf-8"))["project"]
    lines, extras, taken = list(project["dependencies"]), {"test"}, set[str]()
    while extras - taken:
        name = (extras - taken).pop()
        taken.add(name)
        lines += project["optional-dependencies"][name]
        extras |= {one for each in project["optional-dependencies"][name] for one in _extras_of(each)}
    needed = [each for each in map(Requirement, lines) if each.marker is None or each.marker.evaluate()]
    for each in needed:
        if each.name != "breastrig":
            assert version(each.name) in each.specifier, each

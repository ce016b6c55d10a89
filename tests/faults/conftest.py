"""What happens to fits when something breaks around them; `make faults` does it longer and prints the table."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.fault_table import Outcome, lines
from helpers.toy_rig import toy_rig
from helpers.uploads import torso as torso_ply

from breastrig_studies.output.rig_files import write_rig

TABLE = pytest.StashKey[list[tuple[str, Outcome]]]()
Note = Callable[[str, Outcome], None]


@pytest.fixture(scope="session")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("model")
    write_rig(toy_rig(), folder)
    return folder / "toy.glb"


@pytest.fixture(scope="session")
def torso() -> bytes:
    return torso_ply()


@pytest.fixture
def note(request: pytest.FixtureRequest) -> Note:
    """Adds a line to the table, the fault and what became of the fits; fails when something is lost or doubled."""
    rows = request.config.stash.setdefault(TABLE, [])

    def add(fault: str, outcome: Outcome) -> None:
        rows.append((fault, outcome))
        assert outcome.nothing_is_wrong, (fault, outcome)

    return add


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    rows = config.stash.get(TABLE, [])
    if os.environ.get("BREASTRIG_FAULT_TABLE") and rows:
        terminalreporter.section("faults")
        for line in lines(rows):
            terminalreporter.write_line(line)

"""One inked scan for all tests of this folder."""

import pytest
from helpers.inked_scan import inked_zip

from breastrig.colour.ink.find_ink import InkLine, find_ink
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan


@pytest.fixture(scope="session")
def inked() -> Scan:
    return read_scan(inked_zip(), units="m", for_display=False)


@pytest.fixture(scope="session")
def ink(inked: Scan) -> tuple[InkLine, ...]:
    return find_ink(inked)

"""The page for taking scans with marks: one page, with dots of both sides that a scanner tells apart."""

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from breastrig.cli.main import main
from breastrig.report.pages.protocol import DOTS, dots, protocol_pdf
from breastrig.rig.model import Rig


def test_dots_lie_apart_and_on_both_sides_alike(torso: Rig) -> None:
    found = dots(torso)
    left, right = found[: len(DOTS)], found[len(DOTS) :]
    for one, other in zip(left, right, strict=True):
        assert one[0] > 0.02
        np.testing.assert_allclose(other, one * [-1.0, 1.0, 1.0], atol=0.01)
    assert min(np.linalg.norm(one - other) for one, other in combinations(found, 2)) > 0.02


@pytest.mark.slow
def test_the_command_writes_one_page(tmp_path: Path) -> None:
    file = tmp_path / "protocol.pdf"
    assert main(["protocol", "-o", str(file)]) == 0
    written = file.read_bytes()
    assert written == protocol_pdf()
    assert len(re.findall(rb"/Type */Page\b", written)) == 1
    assert main(["protocol", "-o", str(file)]) == 2  # not over a file that is there

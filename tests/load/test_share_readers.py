"""A smaller scan than `make load` takes, and a stand-in for its fit, which no reader reads."""

from pathlib import Path

import pytest
from helpers.real_server import PROGRAM, search_path
from helpers.toy_rig import toy_rig

from breastrig.api.share_limits import BIG_ANSWERS_EACH
from breastrig_studies.output.rig_files import write_rig
from load.share_readers import MOST_GROWTH_MB, ShareReaders, run_share_readers

pytestmark = pytest.mark.long


@pytest.mark.soak
def test_readers_of_a_large_scan_and_those_that_never_read_cost_the_server_no_memory(tmp_path: Path) -> None:
    write_rig(toy_rig(), tmp_path)
    surroundings = {"FAKE_FIT": "quick", "PYTHONPATH": search_path(), "BREASTRIG_MODEL": str(tmp_path / "toy.glb")}
    found = run_share_readers(200_000, 12, 30, [str(PROGRAM)], **surroundings)
    assert found.errors == []
    assert found.whole == 12
    assert found.silent_answers == {"200": BIG_ANSWERS_EACH, "503": 30 - BIG_ANSWERS_EACH}
    assert found.growth_mb <= MOST_GROWTH_MB


def test_the_table_says_how_far_the_memory_grew() -> None:
    found = ShareReaders(
        triangles=2_000_000, mesh_mb=48.2, before_mb=209.0, reading_mb=254.0, silent_mb=271.0, after_mb=244.0,
        seconds=8.5, whole=12, silent_answers={"503": 18, "200": 12},
    )  # fmt: skip
    assert found.growth_mb == 62.0
    assert found.table()[2:] == [
        "never read              12 x 200, 18 x 503",
        "the server's memory MB  209 before, 254 while reading, 271 with those that never read, 244 after",
    ]

"""A short run of what `make load` does for a minute."""

from pathlib import Path

import pytest

from load.measured import Measured, percentile, slow_table, table
from load.run import run
from load.slow import Kept, SlowClients
from load.watched import StoredEvents

pytestmark = pytest.mark.long


@pytest.mark.soak
def test_clients_work_while_viewers_watch_and_hundreds_are_slow_without_any_error() -> None:
    slow = SlowClients(idle=300, headers=20, bodies=20, readers=20)
    found = run(seconds=120.0, clients=2, viewers=8, slow=slow, enough_fits=2)  # patience, beside other tests
    assert found.measured.errors == []
    assert [kept.held for kept in found.slow.values()] == [300, 20, 20, 20]
    assert found.slow["idle"].sent_away == sum(kept.not_let_in for kept in found.slow.values()) == 0
    assert found.exit_status == 0
    assert "error" not in found.log
    assert found.measured.fits >= 2
    assert found.measured.streams_read >= 1
    calls = found.measured.seconds
    assert len(calls["POST scans"]) == len(calls["GET fitted.glb"]) == len(calls["DELETE scan"]) == found.measured.fits
    assert found.measured.late_s
    assert all(used.server_mb > 0 and 1 < used.threads < 200 for _, used in found.memory)


def test_the_table_counts_and_ranks() -> None:
    measured = Measured(fits=6, streams_read=9, open_streams=[4, 6], errors=["client: so it is"])
    measured.seconds["POST fits"] += [0.001 * k for k in range(1, 102)]
    assert percentile(measured.seconds["POST fits"], 95) == 0.096
    lines = table(measured, 3.0)
    assert lines[1].split() == ["POST", "fits", "101", "51", "96", "101"]
    assert "fits        6 in 3 s: 2.00 fits/s" in lines
    assert "viewers     9 whole streams, on average 5 streams open" in lines
    assert "            client: so it is" in lines


def test_the_table_of_slow_clients_counts_each_kind() -> None:
    lines = slow_table({"idle": Kept(2000, 1999, 1, 0), "slow readers": Kept(5, 0, 2, 3)})
    assert [line.split()[-4:] for line in lines[1:]] == [["2000", "1999", "1", "0"], ["5", "0", "2", "3"]]


def test_the_moment_of_a_stored_event_is_noted_once_its_line_is_whole(tmp_path: Path) -> None:
    log = tmp_path / "cases" / "a" / "scans" / "b" / "fits" / "fit" / "fit.log.jsonl"
    log.parent.mkdir(parents=True)
    with log.open("ab", buffering=0) as file:
        file.write(b"one\nhalf of")
        stored = StoredEvents(tmp_path)
        stored.start()
        while len(stored.moments) < 1:
            stored.join(0.001)
        file.write(b" two\n")
        while len(stored.moments) < 2:
            stored.join(0.001)
    stored.stop()
    assert list(stored.moments) == [("fit", 1), ("fit", 2)]
    assert stored.moments["fit", 2] > stored.moments["fit", 1]

"""Other programs' folders, full disks, damaged indexes, wrong clocks, files that cannot be removed.

No scan is lost that should be kept, none is left that should be gone, and nothing of anybody else's is touched.
"""

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest
from helpers.fault_table import Outcome, outcome, wait_for_ends
from helpers.on_disk import of_patients, overwrite
from helpers.real_server import server, starting
from helpers.small_disk import fill, small_disk, stuck
from helpers.waiting import PATIENCE_S, until

from breastrig.index.file import current

pytestmark = pytest.mark.soak

THEIRS = ("cases/p1", "incoming/p1", "rubbish/p1")
Note = Callable[[str, Outcome], None]


@dataclass(frozen=True)
class Folder:
    """A data folder, and a server on it whenever one is asked for."""

    data: Path
    model: Path
    log: Path

    @contextmanager
    def served(self, *options: str, **environment: str) -> Iterator[httpx.Client]:
        with (
            server(self.data, self.model, self.log, *options, FAKE_FIT="quick", **environment) as (process, address),
            httpx.Client(base_url=address, timeout=PATIENCE_S) as client,
        ):
            yield client
            process.terminate()
            process.wait(timeout=PATIENCE_S)

    def filled(self, client: httpx.Client, torso: bytes, fits: int = 2) -> tuple[str, list[str]]:
        """(a new scan, its fits, which are done)."""
        scan = client.post("/api/scans", files={"file": ("torso.ply", torso)}).json()["id"]
        made = [client.post("/api/fits", json={"scan": scan, "drawing": None}).json()["id"] for _ in range(fits)]
        wait_for_ends(client, made, self.log)
        return scan, made

    def purged(self, *options: str) -> subprocess.CompletedProcess[str]:
        return self.called("purge", *options, "--data", str(self.data))

    def called(self, *words: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "breastrig.cli.main", *words]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def refused(self) -> str:
        """What a server says that does not start."""
        with starting(self.data, self.model, self.log, FAKE_FIT="quick") as process:
            assert process.wait(timeout=PATIENCE_S) != 0
        return self.log.read_text().strip().splitlines()[-1]


@pytest.fixture
def folder(tmp_path: Path, model: Path) -> Folder:
    return Folder(tmp_path / "data", model, tmp_path / "log")


def contents(root: Path) -> dict[str, bytes | None]:
    return {str(path): path.read_bytes() if path.is_file() else None for path in (root, *root.rglob("*"))}


def test_a_folder_of_another_program_is_left_as_it_is(folder: Folder, note: Note) -> None:
    for place in THEIRS:
        (folder.data / place).mkdir(parents=True)
        (folder.data / place / "a").write_text("x")
    before = contents(folder.data)
    assert "is no data folder of BreastRig, so it is left as it is" in folder.refused()
    assert folder.purged("--all").returncode == 2
    missing = before.items() - contents(folder.data).items()
    note("another program's folder as data folder", Outcome(0, 0, 0, 0, lost=len(missing), doubled=0, left_over=0))
    assert contents(folder.data) == before


def test_what_another_program_puts_into_the_data_folder_stays(folder: Folder, torso: bytes, note: Note) -> None:
    with folder.served() as client:
        scan, fits = folder.filled(client, torso)
    for place in THEIRS:
        (folder.data / place).mkdir(parents=True)
        (folder.data / place / "a").write_text("x")
    with folder.served() as client:
        found = outcome(client, folder.data, fits)
        assert found.left_over == len(THEIRS)
        assert client.delete(f"/api/scans/{scan}").status_code == 204
    assert folder.purged("--all").returncode == 0
    assert sorted(str(path.relative_to(folder.data)) for path in folder.data.glob("*/*/*")) == [
        "cases/p1/a",
        "incoming/p1/a",
        "rubbish/p1/a",
    ]


def test_a_full_disk_hinders_no_deletion(tmp_path: Path, model: Path, torso: bytes, note: Note) -> None:
    """Not at work, nor after a restart, nor without a server, however often others fill what becomes free."""
    with small_disk(tmp_path / "disk", 24) as disk:
        folder = Folder(disk / "data", model, tmp_path / "log")
        with folder.served() as client:
            scans = [folder.filled(client, torso)[0] for _ in range(4)]
            _, kept = folder.filled(client, torso)
            for scan in scans[:1]:
                fill(disk)
                assert client.post("/api/scans", files={"file": ("torso.ply", torso)}).status_code in (503, 507)
                assert client.delete(f"/api/scans/{scan}").status_code == 204
                assert client.get(f"/api/scans/{scan}").status_code == 404
            fill(disk)
        [case] = folder.data.glob(f"cases/*/scans/{scans.pop()}")
        done = folder.called("case", "delete", str(case.parents[1]), "--all")
        assert (done.returncode, done.stderr, case.exists()) == (0, "", False)
        fill(disk)
        with folder.served():
            fill(disk)
        for scan in scans[1:]:
            fill(disk)
            with folder.served() as client:
                fill(disk)
                assert client.delete(f"/api/scans/{scan}").status_code == 204
                assert client.get(f"/api/scans/{scan}").status_code == 404
                note("scan deleted on a full disk", outcome(client, folder.data, kept))
        fill(disk)
        done = folder.purged("--all")
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith("1 scan deleted")
        assert not of_patients(folder.data)
    assert "Traceback" not in folder.log.read_text()


@pytest.mark.parametrize("when", ["before the start", "gone while it runs", "in place while it runs"])
def test_a_damaged_index_is_named_and_made_again_and_nothing_is_deleted_for_it(
    when: str, folder: Folder, torso: bytes, note: Note
) -> None:
    made = "the index is damaged; it is made again from the folders"
    with folder.served(FAKE_LOOK_EVERY_S="0.2") as client:
        scan, fits = folder.filled(client, torso)
        file = current(folder.data)
        assert file is not None
        if when == "gone while it runs":
            file.unlink()
            assert client.get(f"/api/scans/{scan}").status_code == 200
        if when == "in place while it runs":  # the server remembers pages that it has read
            overwrite(file, 4096, file.stat().st_size)
            until(lambda: made in folder.log.read_text(), "the look for damage")
            assert client.get(f"/api/scans/{scan}").status_code == 200
    before = {path: path.read_bytes() for path in folder.data.glob("cases/**/*") if path.is_file()}
    assert len(before) > 10
    if when == "before the start":
        overwrite(file, 4096, file.stat().st_size)
    with folder.served() as client:
        assert (made in folder.log.read_text()) is (when != "gone while it runs")
        assert client.get(f"/api/scans/{scan}").status_code == 200
        note(f"index damaged {when}", outcome(client, folder.data, fits))
    assert {path: path.read_bytes() for path in folder.data.glob("cases/**/*") if path.is_file()} == before


def test_starts_with_a_clock_that_is_40_days_ahead_lose_no_scan(folder: Folder, torso: bytes, note: Note) -> None:
    with folder.served() as client:
        scan, fits = folder.filled(client, torso)
    for _ in range(2):
        with folder.served(FAKE_DAYS_AHEAD="40") as client:
            until(lambda: "they are deleted from" in folder.log.read_text(), "the announcement")
            assert client.get(f"/api/scans/{scan}").status_code == 200
        with folder.served() as client:
            until(lambda: "not as old as the clock said before" in folder.log.read_text(), "the withdrawal")
            assert client.get(f"/api/scans/{scan}").status_code == 200
            note("clock 40 days ahead at a start", outcome(client, folder.data, fits))
        folder.log.write_text("")
    with folder.served(FAKE_DAYS_AHEAD="40") as client:
        until(lambda: "they are deleted from" in folder.log.read_text(), "the announcement")
    with folder.served(FAKE_DAYS_AHEAD="41.1") as client:  # so it is really as late
        until(lambda: client.get(f"/api/scans/{scan}").status_code == 404, "the deletion")
    assert not of_patients(folder.data)


@pytest.mark.parametrize("alone", [False, True])
def test_files_that_cannot_be_removed_are_named_until_they_are_gone(
    alone: bool, folder: Folder, torso: bytes, note: Note
) -> None:
    with folder.served() as client:
        other, kept = folder.filled(client, torso)
        scan, _ = folder.filled(client, torso)
        patient = client.get(f"/api/scans/{other}").json()["patient"]
        if not alone:
            moved = client.put(f"/api/scans/{scan}/patient", json={"patient": patient, "again": True})
            assert moved.status_code == 200, moved.text
    (place,) = folder.data.glob(f"cases/*/scans/{scan}")
    files = within(place)
    assert files
    with stuck(place):
        with folder.served() as client:
            for _ in range(2):
                answer = client.delete(f"/api/scans/{scan}")
                assert answer.status_code == 500
                assert "1 of the folders with its files could not be removed" in answer.json()["detail"]
                assert client.get(f"/api/scans/{scan}").status_code == 404
            assert outcome(client, folder.data, kept).left_over == 1
        done = folder.purged("--older-than", "1000")
        assert done.returncode == 1
        left = folder.data / "rubbish" / place.parents[1].name if alone else place
        assert done.stderr.startswith(f"breastrig: {left} cannot be removed (")
        assert within(left / "scans" / scan if alone else left) == files
    with folder.served() as client:
        note("file that could not be removed before", outcome(client, folder.data, kept))
    assert not left.exists()


def within(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}

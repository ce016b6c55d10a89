"""No command writes over what it reads, nor over what somebody else made, and what it writes is for its user only."""

import json
import os
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.blank_pictures import blank_pictures
from helpers.cohort import write_patient
from helpers.example_fits import write_example_fits

from breastrig.cli import fit_command, landmarks_command
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.files.result import FIT_FILES
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig_studies.output import publish

pytestmark = pytest.mark.long

EXAMPLE = asset_folder("example")
PICKS = ["--landmarks", str(EXAMPLE / "standing" / "landmarks.json")]


@pytest.fixture(autouse=True, scope="module")
def open_umask() -> Iterator[None]:
    """The most careless one."""
    before = os.umask(0)
    yield
    os.umask(before)


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fits")
    write_example_fits(folder)
    return folder


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """The patient's only scan, in a folder of the user's."""
    shutil.copy(EXAMPLE / "standing" / "scan.ply", tmp_path / "scan.ply")
    return tmp_path / "scan.ply"


@pytest.fixture
def without_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever starts to work fails: the refusal comes first."""

    def work(*_: object, **__: object) -> None:
        raise AssertionError("the work began")

    monkeypatch.setattr(fit_command, "iterates", work)
    monkeypatch.setattr("breastrig.use.report.write_three_files", work)
    monkeypatch.setattr(landmarks_command, "propose_landmarks", work)


def refused(command: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """The sentence of a command that is refused."""
    assert main(command) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("breastrig: ")
    assert said.err.count("\n") == 1
    return said.err


def files(folder: Path) -> dict[str, bytes]:
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def modes(folder: Path) -> tuple[set[int], set[int]]:
    """Of the folders and of the files in it, the folder among them."""
    every = [folder, *folder.rglob("*")]
    found: tuple[set[int], set[int]] = set(), set()
    for path in every:
        found[path.is_file()].add(stat.S_IMODE(path.stat().st_mode))
    return found


@pytest.mark.usefixtures("without_work")
@pytest.mark.parametrize("more", [[], ["--force"]])
def test_a_fit_never_replaces_its_scan(more: list[str], scan: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = files(scan.parent)
    for out in (".", "x/..", str(scan.parent)):
        place = str(scan.parent / out)
        assert "which this command reads" in refused(["fit", str(scan), "-o", place, *more], capsys)
    assert "which this command reads" in refused(["landmarks", str(scan), "-o", str(scan), *more], capsys)
    assert files(scan.parent) == before


@pytest.mark.usefixtures("without_work")
def test_a_fit_does_not_replace_what_the_user_has_there(scan: Path, capsys: pytest.CaptureFixture[str]) -> None:
    own = scan.rename(scan.with_name("monday.ply"))
    for name in ("drawing.json", "fitted.glb"):
        (own.parent / name).write_text('{"schema": "breastrig/drawing@1", "shapes": []}')
    before = files(own.parent)
    said = refused(["fit", str(own), "-o", str(own.parent)], capsys)
    assert "fitted.glb, drawing.json" in said
    assert "--force" in said
    assert files(own.parent) == before


@pytest.mark.slow
def test_a_fit_replaces_an_earlier_one_and_nothing_else(
    fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    shutil.copytree(fits / "standing", out)
    command = ["fit", str(EXAMPLE / "supine" / "scan.ply"), "--drawing", "none", "--no-refine", "-o", str(out)]
    (out / "notes.txt").write_text("mine")
    assert main(command) == 0
    assert json.loads((out / "result.json").read_text())["stance"] == "supine"
    assert set(os.listdir(out)) == {*FIT_FILES, "notes.txt"}
    (out / "result.json").unlink()
    before = files(out)
    capsys.readouterr()
    assert "already" in refused(command, capsys)
    assert files(out) == before


def test_a_fit_that_fails_leaves_the_earlier_result_whole(
    fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    shutil.copytree(fits / "standing", out)
    before = files(out)
    (tmp_path / "empty.ply").write_bytes(b"")
    refused(["fit", str(tmp_path / "empty.ply"), "-o", str(out)], capsys)

    def full(*_: object) -> bytes:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("breastrig.core.private_files.write_private", full)
    command = ["fit", str(EXAMPLE / "supine" / "scan.ply"), "--drawing", "none", "-o", str(out)]
    assert "No space left on device" in refused(command, capsys)
    assert files(out) == before


def test_a_transfer_replaces_neither_fit_nor_a_drawing_that_is_not_its_own(
    fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pair = ["transfer", "--from", str(fits / "standing"), "--to", str(fits / "supine")]
    before = files(fits)
    for name in ("result.json", "drawing.json"):
        for folder in ("standing", "supine"):
            assert "which this command reads" in refused([*pair, "-o", str(fits / folder / name), "--force"], capsys)
    own = tmp_path / "mine.json"
    shutil.copy(fits / "standing" / "drawing.json", own)
    command = [*pair, "--drawing", str(own), "-o"]
    assert "which this command reads" in refused([*command, str(own), "--force"], capsys)
    assert files(fits) == before

    there = tmp_path / "new" / "there.json"
    assert main([*command, str(there)]) == 0
    assert modes(there.parent) == ({0o700}, {0o600})
    assert "there.json already" in refused([*command, str(there)], capsys)
    assert main([*command, str(there), "--force"]) == 0


@pytest.mark.slow
def test_exports_and_comparisons_replace_their_own_files_only(
    fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    blank_pictures(monkeypatch)
    fit, drawing = str(fits / "standing"), str(fits / "standing" / "drawing.json")
    commands = {
        "drawing.obj": ("surface.json", ["export", fit]),
        "compare.png": ("compare.json", ["compare", "--on", fit, drawing, drawing]),
    }
    for name, (record, words) in commands.items():
        out = tmp_path / words[0]
        command = [*words, "-o", str(out)]
        assert main(command) == 0
        assert modes(out) == ({0o700}, {0o600})
        assert main(command) == 0
        (out / record).write_text("mine")
        before = files(out)
        assert name in refused(command, capsys)
        assert files(out) == before
    assert modes(fits / "standing") == ({0o700}, {0o600})


@pytest.mark.usefixtures("batch_here")
@pytest.mark.slow
def test_a_batch_keeps_its_manifest_its_scans_and_what_lies_beside_its_results(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    shutil.copy(EXAMPLE / "standing" / "scan.ply", tmp_path / "a.ply")
    (out / "batch.csv").write_text("scan,drawing\n../a.ply,none\n")
    assert "which this command reads" in refused(["batch", str(out / "batch.csv"), "-o", str(out)], capsys)
    (tmp_path / "m.csv").write_text("scan,name,drawing\na.ply,one,none\n")
    assert "holds batch.csv" in refused(["batch", str(tmp_path / "m.csv"), "-o", str(out)], capsys)
    (out / "batch.csv").unlink()

    command = ["batch", str(tmp_path / "m.csv"), "-o", str(out), "--jobs", "1", "--no-progress"]
    assert main(command) == 0
    assert modes(out / "one") == ({0o700}, {0o600})
    assert modes(out)[1] == {0o600}
    (out / "one" / "notes.txt").write_text("mine")
    assert main([*command, "--again"]) == 0
    assert (out / "one" / "notes.txt").read_text() == "mine"
    assert len(os.listdir(out / "one")) == len(FIT_FILES) + 3

    (out / "one" / "inputs.json").write_text("{}")
    before = files(out / "one")
    assert main([*command, "--again"]) == 1
    assert "already" in capsys.readouterr().err
    assert files(out / "one") == before

    (tmp_path / "m.csv").write_text("scan,name,drawing\nout/one/scan.ply,one,none\n")
    assert "which this command reads" in refused([*command, "--force"], capsys)


def test_an_evaluation_removes_no_table_that_is_not_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(publish, "have_plots", lambda: False)
    monkeypatch.setattr(publish, "fit_pictures", lambda *_: [])
    write_patient(tmp_path / "cohort" / "patient_x", read_rig(default_rig_path()), 3, "made", stances=("standing",))
    (tmp_path / "cohort/patient_x/standing/scan.ply").write_text("ply\n")  # nothing is measured: files are the question
    out = tmp_path / "out"
    out.mkdir()
    (out / "table1.csv").write_text("mine")
    quick = ["--quick", "--rotations", "0", "--jobs", "1", "--preset", "default"]
    command = ["evaluate", str(tmp_path / "cohort"), *quick, "-o", str(out)]
    assert "table1.csv" in refused(command, capsys)
    (out / "table1.csv").rename(out / "notes.csv")
    for _ in range(2):
        assert main(command) == 0
        assert (out / "notes.csv").read_text() == "mine"
    written = {file.name for file in out.iterdir()} - {"notes.csv"}
    assert {stat.S_IMODE((out / name).stat().st_mode) for name in written - {"work"}} == {0o600}
    assert modes(out / "work") == ({0o700}, {0o600})
    assert {name.removesuffix(".csv") for name in written if name.endswith(".csv")} <= set(publish.TABLES)

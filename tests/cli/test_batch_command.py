"""`breastrig batch` as a user calls it: killed, interrupted, called again (see execution for clusters)."""

import csv
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from helpers import fake_batch
from helpers.dask_cluster import ENVIRONMENT
from helpers.fake_women import prior_of
from helpers.real_server import alive, children
from helpers.same_files import timeless
from helpers.waiting import PATIENCE_S, until

from breastrig.batch import table as batch_table
from breastrig.cli import batch_command
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder

EXAMPLE = asset_folder("example") / "standing"


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batch_command, "measured_fit", fake_batch.scripted_fit)


@pytest.mark.slow
def test_a_batch_leaves_what_fit_leaves_and_the_numbers_of_all(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "prior.json").write_bytes(prior_of(30).content())
    prior = ["--prior", str(tmp_path / "prior.json")]
    (tmp_path / "bad.ply").write_bytes(b"Dear surgeon, please find attached the scan.\n")
    manifest, out = tmp_path / "manifest.csv", tmp_path / "out"
    manifest.write_text(f"scan,landmarks,name\n{EXAMPLE}/scan.ply,{EXAMPLE}/landmarks.json,standing\nbad.ply,,bad\n")
    assert main(["batch", str(manifest), "-o", str(out), "--jobs", "2", *prior]) == 1

    said = capsys.readouterr()
    told = {line["name"]: line for line in map(json.loads, said.out.splitlines())}
    assert {name: line["state"] for name, line in told.items()} == {"standing": "done", "bad": "failed"}
    assert sorted(line["row"] for line in told.values()) == [1, 2]
    assert said.err == f"breastrig: bad: {told['bad']['reason']}\n"

    rows = {row["name"]: row for row in fake_batch.table(out)}
    assert list(rows) == ["standing", "bad"]
    assert rows["bad"]["reason"] == told["bad"]["reason"]
    assert not (out / "bad").exists()
    assert {file.name for file in (out / "standing").iterdir()} == fake_batch.WHOLE
    result = json.loads((out / "standing" / "result.json").read_text())
    assert float(rows["standing"]["mean_mm"]) == result["surface_distance_mm"]["mean"]
    assert float(rows["standing"]["landmark_mean_mm"]) == result["landmark_distance_mm"]["mean"]
    assert any("what 30 patients" in note for note in result["notes"])
    assert rows["standing"]["stance"] == result["stance"] == "standing"
    with (out / "standing" / "measures.csv").open(newline="") as file:
        measured = {(row["measure"], row["kind"]): row for row in csv.DictReader(file)}
    for column, measure, cell in (
        ("notch_nipple_skin_left_mm", ("notch_nipple", "along the skin"), "left"),
        ("notch_nipple_straight_right_high_mm", ("notch_nipple", "straight"), "right_high"),
        ("nipple_nipple_straight_value_mm", ("nipple_nipple", "straight"), "value"),
        ("volume_left_low_ml", ("volume", "volume"), "left_low"),
    ):
        assert float(rows["standing"][column]) == float(measured[measure][cell]) > 0.0
        assert rows["bad"][column] == ""
    assert batch_table.is_table(out / "batch.csv")

    alone = ["fit", f"{EXAMPLE}/scan.ply", "--landmarks", f"{EXAMPLE}/landmarks.json", *prior]
    assert main([*alone, "-o", str(tmp_path / "alone")]) == 0
    for file in ("fitted.ply", "drawing.json", "distances.bin", "scan.ply"):
        assert timeless(out / "standing" / file) == timeless(tmp_path / "alone" / file), file


def test_a_prior_that_is_not_for_the_batch_runs_nothing(
    tmp_path: Path, fake: None, capsys: pytest.CaptureFixture[str]
) -> None:
    manifest, prior = fake_batch.write_manifest(tmp_path, {"a": "fine"}), tmp_path / "prior.json"
    other_preset = "name,scan,preset\na,a.ply,\nb,a.ply,paper\n"
    for written, table, why in (
        (prior_of(2), other_preset, "manifest.csv, line 3: The preset paper expects nothing of bodies"),
        (replace(prior_of(2), rig_sha256="0" * 64), manifest.read_text(), "This prior is of another rig"),
    ):
        prior.write_bytes(written.content())
        manifest.write_text(table)
        assert main(["batch", str(manifest), "--prior", str(prior), "-o", str(tmp_path / "out")]) == 2
        said = capsys.readouterr().err
        assert said.startswith(f"breastrig: {why}")
        assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_name_that_spreadsheets_would_run_is_a_text_in_the_table(tmp_path: Path, fake: None) -> None:
    manifest, out = tmp_path / "manifest.csv", tmp_path / "out"
    (tmp_path / "scan.ply").write_text("fine")
    manifest.write_text('scan;name\nscan.ply;"=HYPERLINK(""x"",""y"")"\nscan.ply;-5\n')
    assert main(["batch", str(manifest), "-o", str(out)]) == 0
    assert [row["name"] for row in fake_batch.table(out)] == ['\'=HYPERLINK("x","y")', "-5"]


def test_a_wrong_manifest_runs_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    manifest = fake_batch.write_manifest(tmp_path, {"fine": "fine"})
    manifest.write_text(manifest.read_text() + "".join(f"x{n},missing.ply\n" for n in range(30)))
    assert main(["batch", str(manifest), "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.splitlines()[0] == (
        "breastrig: manifest.csv, line 3: There is no scan missing.ply; paths are relative to the manifest."
    )
    assert said.err.splitlines()[20:] == ["breastrig: Wrong rows that are not shown: 10."]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("option", [["--jobs", "0"], ["--scheduler", "carrier-pigeon://here"]])
def test_a_wrong_option_is_one_line(option: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    manifest = fake_batch.write_manifest(tmp_path, {"fine": "fine"})
    assert main(["batch", str(manifest), "-o", str(tmp_path / "out"), *option]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.fixture
def temporary() -> Iterator[Path]:
    """A folder for temporary files; its name is short, because processes have sockets there."""
    with TemporaryDirectory(prefix="b", dir="/tmp") as folder:
        yield Path(folder)


@pytest.fixture
def program(tmp_path: Path, temporary: Path) -> Iterator["subprocess.Popen[str]"]:
    """A batch of six rows in a process group of its own, once its first result is there."""
    manifest = fake_batch.write_manifest(tmp_path, {f"row{n}": f"slow 0.{n}" for n in range(3, 9)})
    command = [sys.executable, fake_batch.__file__, str(manifest), "-o", str(tmp_path / "out"), "--jobs", "2"]
    with subprocess.Popen(
        command,
        env=ENVIRONMENT | {"TMPDIR": str(temporary)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            until(lambda: any((tmp_path / "out").glob("row*")) or process.poll() is not None, "the first result")
            yield process
        finally:
            process.kill()


@pytest.mark.slow
def test_a_killed_batch_goes_on_where_it_was(
    program: "subprocess.Popen[str]", temporary: Path, fake: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    below = children(program.pid)
    program.kill()
    program.wait()
    out = tmp_path / "out"
    done = {name: (out / name).stat().st_ino for name in fake_batch.whole_results(out)}
    assert 0 < len(done) < 6
    assert not (out / "batch.csv").exists()
    until(lambda: not alive(below), "its processes to notice")

    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    assert main(["batch", str(tmp_path / "manifest.csv"), "-o", str(out), "--jobs", "2"]) == 0
    assert (
        fake_batch.whole_results(out)
        == {row["name"] for row in fake_batch.table(out)}
        == {f"row{n}" for n in range(3, 9)}
    )
    assert {name: (out / name).stat().st_ino for name in done} == done
    assert {entry.name for entry in out.iterdir()} == {*fake_batch.whole_results(out), "batch.csv"}
    (scratch,) = temporary.glob("breastrig-*")
    assert list(scratch.iterdir()) == []  # nor is anything left of the scans that were being fitted


@pytest.mark.slow
def test_ctrl_c_is_one_line_and_leaves_nothing_half_written(program: "subprocess.Popen[str]", tmp_path: Path) -> None:
    below = children(program.pid)
    os.killpg(program.pid, signal.SIGINT)
    _, said = program.communicate(timeout=PATIENCE_S)
    assert (program.returncode, said) == (130, "breastrig: stopped.\n")
    until(lambda: not alive(below), "the server of its processes to notice")
    out = tmp_path / "out"
    assert {entry.name for entry in out.iterdir()} == {*fake_batch.whole_results(out), "batch.csv"}
    assert {row["name"] for row in fake_batch.table(out)} == fake_batch.whole_results(out)

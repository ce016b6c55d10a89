"""Folders of fits whose files were exchanged or changed: no command takes them for the patient's."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.blank_pictures import blank_pictures
from helpers.example_fits import write_example_fits
from helpers.results import without_hashes, write_patient

import breastrig
from breastrig.cli.main import main
from breastrig.files.result import HASHED


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fits")
    write_example_fits(folder)
    return folder


def commands(fit: Path, fits: Path, out: Path) -> list[list[str]]:
    """Everything that reads a result folder, without -o."""
    drawing, other = str(fits / "standing" / "drawing.json"), str(fits / "supine")
    return [
        ["report", str(fit), "-o", str(out / "report")],
        ["report", other, "--with", str(fit), "-o", str(out / "both")],
        ["transfer", "--from", str(fit), "--to", other, "--drawing", drawing, "-o", str(out / "there.json")],
        ["transfer", "--from", other, "--to", str(fit), "-o", str(out / "back.json")],
        ["predict", str(fit), "--stance", "supine", "-o", str(out / "predicted")],
        ["compare", drawing, drawing, "--on", str(fit), "-o", str(out / "compared")],
        ["export", str(fit), "-o", str(out / "exported")],
        ["volume", str(fit), "-o", str(out / "torso.vtu")],
        ["cohort", "learn", str(fit), "-o", str(out / "prior.json")],
    ]


def move(fit: Path, by: float, mirrored: bool) -> None:
    """The scan moved, or mirrored, as another program writes it."""
    mesh = trimesh.load(fit / "scan.ply", process=False)
    mesh.vertices = np.asarray(mesh.vertices) * ([-1.0, 1.0, 1.0] if mirrored else 1.0) + [by, 0.0, 0.0]
    if mirrored:
        mesh.faces = mesh.faces[:, ::-1]
    mesh.export(fit / "scan.ply")


def edit(**changes: object) -> Callable[[Path], None]:
    def edited(fit: Path) -> None:
        document = json.loads((fit / "result.json").read_text())
        (fit / "result.json").write_text(json.dumps(document | changes, indent=4))

    return edited


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda fit: move(fit, 0.03, False), "fit/scan.ply is not the file that this fit wrote"),
        (lambda fit: move(fit, 0.0, True), "fit/scan.ply is not the file that this fit wrote"),
        (edit(stance="supine"), "fit/result.json was changed since it was written (stance)"),
    ],
    ids=["moved", "mirrored", "stance"],
)
def test_every_command_refuses_a_folder_whose_files_were_exchanged(
    change: Callable[[Path], None], said: str, fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fit = shutil.copytree(fits / "standing", tmp_path / "fit")
    change(fit)
    for command in commands(fit, fits, tmp_path):
        assert main(command) == 2, command
        error = capsys.readouterr().err
        assert error.count("\n") == 1, command
        assert said in error, command
    with pytest.raises(breastrig.BadInput, match="since"):
        breastrig.Fit.load(fit)
    assert {file.name for file in tmp_path.iterdir()} == {"fit"}


@pytest.mark.parametrize("name", HASHED)
def test_each_file_that_is_read_again_is_known(name: str, fits: Path, tmp_path: Path) -> None:
    fit = shutil.copytree(fits / "standing", tmp_path / "fit")
    shutil.copy(fits / "supine" / name, fit / name)
    with pytest.raises(breastrig.BadInput, match=f"fit/{name} is not the file"):
        breastrig.Fit.load(fit)


@pytest.mark.parametrize(
    "changes",
    [{"predicted": True}, {"lesions": []}, {"landmarks_picked": {}}, {"verdict": None}, {"schema": "breastrig/x@1"}],
)
def test_a_field_that_was_changed_added_or_emptied_is_named_or_damaged(
    changes: dict[str, object], fits: Path, tmp_path: Path
) -> None:
    fit = shutil.copytree(fits / "standing", tmp_path / "fit")
    edit(**changes)(fit)
    with pytest.raises(breastrig.BadInput, match=next(iter(changes))):
        breastrig.Fit.load(fit)


def test_what_other_programs_do_without_changing_what_is_said_is_no_exchange(fits: Path, tmp_path: Path) -> None:
    """Written again with other spaces, with 5 for 5.0, in another order, and with fields of their own."""

    def shorter(value: object) -> object:
        if isinstance(value, dict):
            return {key: shorter(each) for key, each in reversed(value.items())}
        if isinstance(value, list):
            return [shorter(each) for each in value]
        return int(value) if isinstance(value, float) and value.is_integer() else value

    fit = shutil.copytree(fits / "standing", tmp_path / "fit")
    document = json.loads((fit / "result.json").read_text())
    (fit / "result.json").write_text(json.dumps(shorter(document | {"clinic_room": 4})))
    breastrig.Fit.load(fit).save(tmp_path / "saved")
    breastrig.Fit.load(tmp_path / "saved")
    write_patient(tmp_path / "saved", "K7M-4QX", None)
    assert breastrig.Fit.load(tmp_path / "saved").in_metres.result.patient.code == "K7M-4QX"


def test_a_fit_in_memory_and_a_prediction_leave_hashes_too(fits: Path, tmp_path: Path) -> None:
    found = breastrig.predict(breastrig.Fit.load(fits / "standing"), "supine")
    found.save(tmp_path / "predicted")
    move(tmp_path / "predicted", 0.03, False)
    with pytest.raises(breastrig.BadInput, match=r"predicted/scan\.ply is not the file"):
        breastrig.Fit.load(tmp_path / "predicted")


def test_folders_of_earlier_versions_are_read_and_it_is_said(
    fits: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    blank_pictures(monkeypatch)
    fit = without_hashes(shutil.copytree(fits / "standing", tmp_path / "fit"))
    for command in (each for each in commands(fit, fits, tmp_path) if each[0] in ("compare", "export", "volume")):
        assert main(command) == 0, command
        said = capsys.readouterr().err
        assert "fit is a fit of an earlier version, which kept no hashes" in said, command
    assert main(["report", str(fit), "-o", str(tmp_path / "report")]) == 0
    doubts = json.loads((tmp_path / "report" / "report.json").read_text())["doubts"]
    assert any(doubt.startswith("fit is a fit of an earlier version") for doubt in doubts)
    assert breastrig.Fit.load(fit).stance == "standing"

"""An image with the lesions of another file on the command line: `fit`, `batch` and `case`."""

import json
import zipfile
from pathlib import Path

import pytest
from helpers.example_image import LANDMARKS, LESIONS, example_image, example_segmentation

from breastrig.cli.main import main
from breastrig.core.assets import asset_folder

pytestmark = pytest.mark.slow
STANDING = asset_folder("example") / "standing" / "scan.ply"


@pytest.fixture
def image(tmp_path: Path) -> Path:
    (tmp_path / "mri.zip").write_bytes(example_image())
    return tmp_path / "mri.zip"


def lesions_of(folder: Path) -> list[str]:
    return [each["name"] for each in json.loads((folder / "result.json").read_text())["lesions"]]


@pytest.mark.usefixtures("batch_here")
def test_a_fit_and_a_row_of_a_batch_have_them(image: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    words = ["fit", str(image), "--landmarks", str(LANDMARKS), "-o", str(out), "--no-refine"]
    assert main([*words, "--lesions", str(LESIONS), str(LESIONS), "--segment", "3=tissue"]) == 0
    assert lesions_of(out) == ["Lesion 1"]
    assert "segment 2: lesion (Lesion 1" in capsys.readouterr().err
    assert main([*words, "--lesions", str(tmp_path / "none"), "--force"]) == 2
    assert "no scan file" in capsys.readouterr().err
    (tmp_path / "lesions of hers.nii.gz").write_bytes(LESIONS.read_bytes())
    rows = (
        f"scan,landmarks,lesions,segments,refine\nmri.zip,{LANDMARKS},lesions of hers.nii.gz | {LESIONS},3=tissue,no\n"
    )
    (tmp_path / "table.csv").write_text(rows)
    batch = tmp_path / "batch"
    assert main(["batch", str(tmp_path / "table.csv"), "-o", str(batch), "--jobs", "1"]) == 0
    assert lesions_of(batch / "0001-mri") == ["Lesion 1"]
    inputs = json.loads((batch / "0001-mri" / "inputs.json").read_text())
    assert len(inputs["lesions_sha256"]) == 2
    assert "hers" not in json.dumps(inputs)


def test_a_folder_with_the_lesion_of_another_file(
    image: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As docs/how-to/mri.md has it."""
    monkeypatch.chdir(tmp_path)
    zipfile.ZipFile(image).extractall("mri")
    Path("lesion.dcm").write_bytes(example_segmentation("another"))
    Path("nipples.json").write_bytes(LANDMARKS.read_bytes())
    words = ["fit", "mri/", "--lesions", "lesion.dcm", "--landmarks", "nipples.json", "-o", "prone/", "--no-refine"]
    assert main(words) == 2
    assert "another frame of reference" in (said := capsys.readouterr().err)
    assert "--same-place yes" in said
    assert main([*words, "--same-place", "yes"]) == 0
    assert lesions_of(tmp_path / "prone") == ["Lesion 1"]


def test_a_surface_has_no_place_for_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", str(STANDING), "-o", str(tmp_path / "out"), "--lesions", str(LESIONS)]) == 2
    assert "made of no image" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_case_takes_them_into_its_plan(image: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = str(tmp_path / "hers")
    assert main(["case", "create", case]) == 0
    assert main(["case", "add", case, str(image)]) == 0
    capsys.readouterr()
    assert main(["case", "lesions", case, str(LESIONS)]) == 0
    assert capsys.readouterr().out.splitlines() == ["Lesion 1: 16 mm across", "Lesion 2: 10 mm across"]
    assert main(["case", "lesions", case, str(LESIONS), "--segment", "3=tissue", "--same-place", "yes"]) == 0
    said = capsys.readouterr()
    assert said.out == "Lesion 1: 16 mm across, in the plan already\n"
    assert "segment 3: tissue" in said.err
    assert main(["case", "lesions", case, str(STANDING)]) == 2

"""`breastrig ink`: a drawing in the scan's frame and unit, or one sentence and exit code 2."""

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.inked_scan import inked_zip
from helpers.label_maps import body_labels, placed_nifti

import breastrig
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("inked") / "scan.zip"
    file.write_bytes(inked_zip())
    return file


def test_lines_are_written_as_a_drawing_and_python_finds_the_same(
    scan: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "drawing.json"
    assert main(["ink", str(scan), "--units", "m", "-o", str(out)]) == 0
    assert capsys.readouterr().out.startswith("6 strokes, ")
    document = json.loads(out.read_text())
    assert (document["schema"], document["unit"]) == ("breastrig/drawing@1", "m")
    ink = breastrig.find_ink(scan, units="m")
    assert ink.document == document
    for shape, line in zip(document["shapes"], ink.strokes, strict=True):
        assert np.allclose(shape["points"], line.points, atol=1e-6)
        assert (shape["kind"], shape["marker"], shape["closed"]) == (line.kind, line.marker, line.closed)
        assert shape["length_mm"] == pytest.approx(line.length_mm, abs=0.06)
    assert ink.lines == ink.strokes
    assert breastrig.find_ink(breastrig.read_scan(scan, "m", texture=True)).strokes


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("uncoloured.stl", "no colour"),
        ("doubtful.nii", "no colour"),
        (str(asset_folder("example") / "standing" / "scan.ply"), "too coarse"),
        ("missing.zip", "no scan file"),
    ],
)
def test_what_has_no_fine_colours_is_one_sentence(
    name: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import trimesh

    monkeypatch.chdir(tmp_path)
    trimesh.creation.icosphere(subdivisions=4, radius=0.2).export(tmp_path / "uncoloured.stl")
    (tmp_path / "doubtful.nii").write_bytes(
        placed_nifti(body_labels(), (np.eye(4), 0), (np.eye(4), 0))
    )  # which side is left?
    assert main(["ink", name, "-o", "drawing.json"]) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1
    assert not (tmp_path / "drawing.json").exists()

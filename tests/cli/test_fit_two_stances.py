"""`breastrig fit A --with B`: what it leaves, and one clear line for what it refuses."""

import json
from pathlib import Path

import pytest

from breastrig.cli.main import main
from breastrig.core.assets import asset_folder

EXAMPLE = asset_folder("example")
STANDING, SUPINE = EXAMPLE / "standing", EXAMPLE / "supine"


@pytest.mark.slow
def test_two_folders_of_a_fit_and_what_they_share(tmp_path: Path) -> None:
    code = main(
        [
            *("fit", str(STANDING / "scan.ply"), "--landmarks", str(STANDING / "landmarks.json")),
            *("--with", str(SUPINE / "scan.ply"), "--with-landmarks", str(SUPINE / "landmarks.json")),
            *("--with-stance", "supine", "-o", str(tmp_path / "out")),
            *("--code", "K-17", "--scanned", "2026-11-20", "--with-scanned", "2026-11-21"),
        ]
    )
    assert code == 0
    assert {file.name for file in (tmp_path / "out").iterdir()} == {"first", "second", "pair.json"}
    pair = json.loads((tmp_path / "out" / "pair.json").read_text())
    assert pair["results"] == {"first": "first/result.json", "second": "second/result.json"}
    assert (pair["bodies"], pair["shared"]) == ("alike", None)
    results = [json.loads((tmp_path / "out" / name).read_text()) for name in pair["results"].values()]
    assert [result["stance"] for result in results] == pair["stances"] == ["standing", "supine"]
    assert results[1]["stance_reason"] == "As asked for."
    for result, day in zip(results, ("2026-11-20", "2026-11-21"), strict=True):
        assert result["patient"] == {"code": "K-17", "given": True, "scanned": day}
    for result, surface, landmarks in zip(results, (0.78, 1.05), (1.8, 3.8), strict=True):
        assert result["surface_distance_mm"]["mean"] < surface
        assert result["landmark_distance_mm"]["mean"] < landmarks
        assert len(result["landmark_distance_mm"]["each"]) == 12
    scales = [[bone["scale"] for bone in result["parameters"]["bones"]] for result in results]
    assert scales[0] != scales[1]
    assert all(abs(a - b) < 0.11 for one, two in zip(*scales, strict=True) for a, b in zip(one, two, strict=True))


@pytest.mark.slow
def test_without_landmarks_each_scan_finds_its_own_start(tmp_path: Path) -> None:
    scans = [str(STANDING / "scan.ply"), "--with", str(SUPINE / "scan.ply")]
    assert main(["fit", *scans, "--drawing", "none", "-o", str(tmp_path / "out")]) == 0
    codes = set()
    for name, stance, surface in (("first", "standing", 0.73), ("second", "supine", 0.9)):
        result = json.loads((tmp_path / "out" / name / "result.json").read_text())
        codes.add(result["patient"]["code"])
        assert result["stance"] == stance
        assert result["surface_distance_mm"]["mean"] < surface
    assert len(codes) == 1  # a random one, for both


@pytest.mark.slow
def test_one_body_is_shared_where_it_is_asked_for(tmp_path: Path) -> None:
    scans = [str(STANDING / "scan.ply"), "--landmarks", str(STANDING / "landmarks.json")]
    scans += ["--with", str(SUPINE / "scan.ply"), "--with-landmarks", str(SUPINE / "landmarks.json")]
    assert main(["fit", *scans, "--no-alike", "-o", str(tmp_path / "out")]) == 0
    pair = json.loads((tmp_path / "out" / "pair.json").read_text())
    results = [json.loads((tmp_path / "out" / name).read_text()) for name in pair["results"].values()]
    assert pair["bodies"] == "one"
    for bone in (bone for result in results for bone in result["parameters"]["bones"]):
        assert bone["scale"] == pair["shared"]["bone_scales"][bone["name"]]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--with", str(STANDING / "scan.ply")], "same file"),
        (["--with", "nowhere.ply"], "no scan file nowhere.ply"),
        (["--with-stance", "supine"], "need --with SCAN_B"),
        (["--no-alike"], "need --with SCAN_B"),
        (["--with-landmarks", str(SUPINE / "landmarks.json")], "need --with SCAN_B"),
    ],
)
def test_what_cannot_be_fitted_together_is_refused_in_one_line(
    arguments: list[str], sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fit", str(STANDING / "scan.ply"), *arguments, "-o", str(tmp_path / "out")]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert sentence in line
    assert not (tmp_path / "out").exists()

"""`breastrig evaluate` on a cohort made from the example patient, whose scan stands in for her true surface."""

import csv
import json
import shutil
from pathlib import Path

import pytest

from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.evaluation.tables import LANDMARKS, TABLE_1, groups, value


@pytest.fixture(scope="module")
def cohort(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cohort")
    place = folder / "patient_x" / "standing"
    place.mkdir(parents=True)
    for name in ("scan.ply", "landmarks.json"):
        shutil.copy(asset_folder("example") / "standing" / name, place)
    shutil.copy(place / "scan.ply", place / "truth.ply")
    (place / "case.json").write_text(json.dumps({"unit": "m", "stance": "standing"}))
    (place.parent / "patient.json").write_text(json.dumps({"family": "MakeHuman"}))
    return folder


def rows(file: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(file.read_text().splitlines()))


def test_the_tables_hold_every_number_and_means_per_family(
    cohort: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["evaluate", str(cohort), "--jobs", "1", "-o", str(tmp_path)]) == 0
    assert "makehuman, standing (1)" in capsys.readouterr().out
    for name, columns in (("table1.csv", TABLE_1), ("landmarks.csv", LANDMARKS)):
        case, *mean = rows(tmp_path / name)
        assert case["family"] == "makehuman"
        assert all(float(case[heading]) >= 0.0 for heading, _ in columns)
        assert {row["case"] for row in mean} == {"standing", "all"}
        assert all(row[heading] == case[heading] for row in mean for heading, _ in columns)
    numbers = rows(tmp_path / "table1.csv")[0]
    assert float(numbers["surface_mean_mm"]) < 2.35
    assert float(numbers["truth_mean_mm"]) < 2.35
    (kept,) = (tmp_path / "cases").iterdir()
    before = kept.stat().st_mtime_ns
    assert main(["evaluate", str(cohort), "--jobs", "1", "-o", str(tmp_path)]) == 0
    assert kept.stat().st_mtime_ns == before  # a finished case is not measured again


def test_means_leave_out_what_is_not_known() -> None:
    cases = [{"family": "independent", "stance": "supine", "truth_mm": {"mean": number}} for number in (1.0, None)]
    assert [(family, stance, len(chosen)) for family, stance, chosen in groups(cases)] == [
        ("independent", "supine", 2),
        ("independent", "all", 2),
    ]
    assert value(cases[1], "truth_mm.mean") is None


def test_a_folder_that_is_no_cohort_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", str(tmp_path), "-o", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err.count("\n") == 1

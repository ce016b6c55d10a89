"""A case with visits: days are said and never guessed, and what changed is the same through each door."""

import csv
import io
import json
import shutil
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import pytest
from helpers.cases import data_folder, new_case, new_fit, new_scan
from PIL import Image

import breastrig
from breastrig.cases.fits import end_abandoned
from breastrig.cases.layout import fit_part
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.core.errors import BadInput, NotFound
from breastrig.core.glb import split_glb
from breastrig.core.model_choice import model_choice
from breastrig.use.cases.visits import visits_job
from breastrig.use.visits.over_time import change_map_of, visits_svg_of

EXAMPLE = asset_folder("example")
DAYS = {"2026-03-01": "before", "2026-09-01": "6 months"}


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Of the example, standing and supine."""
    folder = tmp_path_factory.mktemp("fits")
    for stance in ("standing", "supine"):
        place = EXAMPLE / stance
        breastrig.fit(place / "scan.ply", landmarks=place / "landmarks.json", drawing=None).save(folder / stance)
    return {stance: folder / stance for stance in ("standing", "supine")}


@pytest.fixture
def case(tmp_path: Path, fits: dict[str, Path]) -> breastrig.Case:
    """The patient standing three times and supine once, all fitted; nothing changed, and no day is known."""
    case = new_case(data_folder(tmp_path / "data"), "K7M-4QX")
    for stance in ("standing", "standing", "standing", "supine"):
        scan = new_scan(case)
        fit = new_fit(case, scan)
        for file in fits[stance].iterdir():
            shutil.copy(file, case.path / fit_part(scan, fit) / file.name)
        end_abandoned(case, scan, fit, {"kind": "done", "result": {"stance": stance, "verdict": {"level": "good"}}})
    return breastrig.Case(case.path)


@pytest.fixture
def dated(case: breastrig.Case) -> breastrig.Case:
    for scan, (day, label) in zip(of_stance(case, "standing"), DAYS.items(), strict=False):
        case.put_visit(scan, day, label)
    return case


def of_stance(case: breastrig.Case, stance: str) -> list[str]:
    return [scan.id for scan in case.scans if case.fits(scan.id)[0].stance == stance]


def test_a_day_is_kept_with_its_name_and_taken_back(case: breastrig.Case) -> None:
    scan = case.scans[0].id
    assert (case.scans[0].visit.date, case.scans[0].visit.label) == (None, "")
    case.put_visit(scan, "2026-03-01", " before ")
    assert (case.scans[0].visit.date, case.scans[0].visit.label) == ("2026-03-01", "before")
    case.put_visit(scan, None)
    assert case.scans[0].visit.date is None


@pytest.mark.parametrize(
    ("day", "label", "says"),
    [
        ("1 March 2026", "", "is no day"),
        ("20260301", "", "is no day"),
        ("2026-02-30", "", "is no day"),
        ("2999-01-01", "", "is in the future"),
        ("2026-03-01", "x" * 61, "may have 60 characters"),
        ("2026-03-01", "\U0001f600", "name of the visit"),
    ],
)
def test_what_is_no_visit_is_refused_and_changes_nothing(case: breastrig.Case, day: str, label: str, says: str) -> None:
    with pytest.raises(BadInput, match=says):
        case.put_visit(case.scans[0].id, day, label)
    assert case.scans[0].visit.date is None


def test_scans_without_a_day_are_asked_about_and_left_out(case: breastrig.Case) -> None:
    found = case.visits()
    assert found["stances"] == []
    assert [each["stance"] for each in found["asked"]] == 3 * ["standing"]  # supine there is only one
    job = visits_job(case._folder, model_choice(None))
    first, second, _ = of_stance(case, "standing")
    [supine] = of_stance(case, "supine")
    with pytest.raises(BadInput, match="say the day of each first"):
        change_map_of(job, (first, second), "png")
    with pytest.raises(BadInput, match="choose two scans of one stance"):
        change_map_of(job, (first, supine), "png")
    with pytest.raises(NotFound, match="Fewer than two standing scans"):
        visits_svg_of(job, "standing", "en")


def check_document(found: dict[str, Any]) -> None:
    """Of the patient who did not change."""
    [standing] = found["stances"]
    assert [(each["days"], each["label"], each["verdict"]) for each in standing["visits"]] == [
        (0, "before", "good"),
        (184, "6 months", "good"),
    ]
    [change] = standing["changes"]
    assert (change["earlier"], change["later"], change["doubts"]) == (0, 1, [])
    for side in ("left", "right"):
        assert change["map"][side]["said_share"] == 0.0
        assert change["map"][side]["largest_mm"] is None
    for row in change["measures"]:
        for cell in ("left", "right", "value"):
            assert row[cell] is None or row[cell] == pytest.approx(0.0, abs=0.01)
    measured = {row["measure"]: row for row in standing["measures"] if row["visit"] == 1}
    volumes = [measured["volume"][side] for side in ("left", "right")]
    assert measured["volume_symmetry"]["value"] == pytest.approx(min(volumes) / max(volumes), abs=1e-3)
    assert [each["measure"] for each in found["published"]] == ["volume_symmetry", "shape_symmetry"]
    assert all("200 women" in each["said"] and "PMC5487698" in each["said"] for each in found["published"])
    assert len(found["asked"]) == 1


def test_a_patient_who_did_not_change_has_no_change_through_any_door(
    dated: breastrig.Case, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["visits", str(dated.path), "-o", str(out)]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("standing, 2026-03-01 to 2026-09-01: left 0 ±")
    number = [scan.id for scan in dated.scans].index(of_stance(dated, "standing")[2]) + 1
    assert f"The day of scan {number} (standing) is not known" in said.err
    check_document(json.loads((out / "visits.json").read_text()))
    rows = list(csv.DictReader(io.StringIO((out / "visits.csv").read_text())))
    assert {row["visit"] for row in rows} == {"2026-03-01 before", "2026-09-01 6 months"}
    assert {row["less"] for row in rows} == {"", "2026-03-01 before"}
    words = words_in((out / "visits_standing.svg").read_bytes())
    assert {"Volume symmetry (%)", "Notch to nipple, straight (mm)", "2026-03-01", "before"} <= words
    assert any("200 women" in word for word in words)
    assert Image.open(io.BytesIO((out / "change_standing_1.png").read_bytes())).size == (1260, 476)
    document, _ = split_glb((out / "change_standing_1.glb").read_bytes())
    extras = document["asset"]["extras"]
    assert max(abs(mm) for mm in extras["change_mm"] if mm is not None) < 0.1
    assert extras["half_band_mm"] >= 2.0
    ply = (out / "change_standing_1.ply").read_bytes()
    assert b"property float change_mm" in ply[:500]
    check_document(dated.visits())


def test_plots_speak_german_and_keep_what_a_person_has_typed(dated: breastrig.Case, tmp_path: Path) -> None:
    assert main(["visits", str(dated.path), "-o", str(tmp_path / "out"), "--language", "de"]) == 0
    words = words_in((tmp_path / "out" / "visits_standing.svg").read_bytes())
    assert {"Symmetrie des Volumens (%)", "Jugulum – Mamille, gerade (mm)", "01.03.2026", "before", "L", "R"} <= words
    assert any(word.startswith("Median 5,9 mm, mittlere Hälfte 4,2 bis 8: 200 Frauen") for word in words)
    job = visits_job(dated._folder, model_choice(None))
    assert words_in(visits_svg_of(job, "standing", "de")) == words


def words_in(svg: bytes) -> set[str]:
    return {each.text for each in ElementTree.fromstring(svg).iter() if each.text}


def test_days_are_said_on_the_command_line(case: breastrig.Case, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["case", "visit", str(case.path), "--scan", "2", "--date", "2026-09-01", "--label", "6 months"]
    assert main(words) == 0
    assert "visit 2026-09-01, 6 months" in capsys.readouterr().out
    assert main(["case", "visit", str(case.path), "--scan", "2", "--date", "yesterday"]) == 2
    assert "is no day" in capsys.readouterr().err
    assert main(["case", "visit", str(case.path), "--scan", "2", "--remove"]) == 0
    assert case.scans[1].visit.date is None

"""`breastrig report` and `breastrig export` on the example patient, as a user calls them."""

import csv
import itertools
import json
import re
from collections.abc import Iterator
from datetime import UTC, date, datetime
from pathlib import Path

import numpy as np
import pypdf
import pytest
import trimesh
from helpers.blank_pictures import blank_pictures, coarse_pictures
from helpers.example_fits import STANCES, write_example_fits
from helpers.results import NOTHING, without_hashes, write_patient

from breastrig.cli.main import main
from breastrig.core import wall_clock
from breastrig.core.assets import asset_folder
from breastrig.core.glb import split_glb
from breastrig.core.identity import LETTERS
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.geometry.self_intersections import crossing_faces
from breastrig.report.table import Value, with_margin

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("fits")
    write_example_fits(folder)
    return {stance: folder / stance for stance in STANCES}


@pytest.fixture(scope="module", autouse=True)
def quick_pictures() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        coarse_pictures(patch)
        yield


@pytest.fixture
def quick_reports(monkeypatch: pytest.MonkeyPatch) -> None:
    """No picture is drawn, and no fit is measured again."""
    blank_pictures(monkeypatch)


@pytest.fixture(scope="module")
def report(fits: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("report")
    assert main(["report", str(fits["standing"]), "--with", str(fits["supine"]), "-o", str(out)]) == 0
    return out


def document(folder: Path, name: str) -> dict:
    return json.loads((folder / name).read_text())


@pytest.mark.slow
def test_csv_and_json_hold_the_same_rows(report: Path) -> None:
    rows = document(report, "report.json")["measures"]
    table = list(csv.DictReader((report / "measures.csv").read_text().splitlines()))
    for_people = ("paths", "label", "printed_step", "said")
    flat = [{k: "" if v is None else str(v) for k, v in row.items() if k not in for_people} for row in rows]
    levels = {each["name"]: each["verdict"]["level"] for each in document(report, "report.json")["stances"]}
    assert [row.pop("verdict") for row in table] == [levels.get(row["stance"], "good") for row in rows]
    assert set(levels.values()) == {"good"}
    assert flat == table  # lines on the body and sentences have no place in a table
    assert {row["stance"] for row in rows} == {"standing", "supine", "supine - standing"}
    for row in rows:
        assert row["landmarks"]
        assert row["method"]
        if row["left"] is not None and row["unit"] == "mm":
            assert row["difference"] == pytest.approx(row["left"] - row["right"], abs=0.011)


def test_changes_are_the_second_stance_less_the_first(report: Path) -> None:
    rows = {(r["stance"], r["measure"], r["kind"]): r for r in document(report, "report.json")["measures"]}
    for (stance, measure, kind), row in rows.items():
        if stance == "supine - standing":
            before, after = rows["standing", measure, kind], rows["supine", measure, kind]
            for cell in ("left", "right", "value"):
                if row[cell] is not None:
                    assert row[cell] == pytest.approx(after[cell] - before[cell], abs=0.11)


def test_straight_lengths_are_those_between_the_picks(report: Path, fits: dict[str, Path]) -> None:
    picks = document(asset_folder("example") / "standing", "landmarks.json")["landmarks"]
    doubted = document(fits["standing"], "result.json")["landmarks_not_followed"]
    assert doubted == []
    rows = {(r["stance"], r["measure"], r["kind"]): r for r in document(report, "report.json")["measures"]}
    row = rows["standing", "nipple_fold", "straight"]
    for side, key in (("L", "left"), ("R", "right")):
        apart = np.linalg.norm(np.subtract(picks[f"nipple_{side}"], picks[f"inframammary_fold_{side}"]))
        assert row[key] == pytest.approx(apart, abs=0.02)


def pdf_of(folder: Path) -> Path:
    [file] = folder.glob("*_report.pdf")
    return file


def test_the_pdf_has_the_numbers_the_settings_a_tape_sheet_of_each_stance_and_the_limits_of_use(report: Path) -> None:
    pdf = pypdf.PdfReader(pdf_of(report))
    texts = [" ".join(page.extract_text().split()) for page in pdf.pages]
    assert all(LIMITS_OF_USE in text for text in texts)
    for text, stance in zip(texts[-2:], ("standing", "supine"), strict=True):
        assert f"Tape sheet, {stance}" in text
        assert all(word in text for word in ("Breast, left", "Sternum upper", "picked"))
    found = document(report, "report.json")
    whole = " ".join(texts)
    said = 0
    for row in found["measures"]:
        if row["unit"] == "mm" and row["stance"] in STANCES:
            for cell in ("left", "right", "value"):
                if row[cell] is not None and cell not in row["vague"].split("; "):
                    said += 1
                    value = Value(*(row[f"{cell}{end}"] for end in ("", "_low", "_high")))
                    near = [value]
                    if value.low is not None and value.high is not None:  # the file's numbers are rounded
                        low, high, nudges = value.low, value.high, itertools.product((-0.006, 0.0, 0.006), repeat=2)
                        near = [Value(value.value + a, low + b, high - b) for a, b in nudges]
                    assert any(with_margin(each, "mm") in whole for each in near), row
    assert said > 10
    assert any(row["vague"] for row in found["measures"])
    assert whole.count("not known well enough") >= 1
    for stance in found["stances"]:
        assert stance["model"]["sha256"][:12] in whole
        assert stance["scan"]["sha256"][:12] in whole
        assert f"{stance['surface_distance_mm']['mean']:.2f} mm" in whole
        assert stance["preset"] in whole
    assert sum(len(page.images) for page in pdf.pages) == 9  # two scans, four maps, their colours, two tape sheets


@pytest.mark.usefixtures("quick_reports")
def test_the_code_stands_on_every_page_and_in_the_name_of_the_file(
    fits: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(wall_clock, "now", lambda: datetime(2026, 11, 25, 9, 0, 0, tzinfo=UTC))
    asked = ["report", str(fits["supine"]), "-o", str(tmp_path)]
    assert main([*asked, "--code", "Klinik Süd/7 ; x"]) == 0
    assert pdf_of(tmp_path).name == "Klinik-Sud-7-x_supine_2026-11-25_report.pdf"
    reader = pypdf.PdfReader(pdf_of(tmp_path))
    assert all("Klinik Süd/7 ; x" in page.extract_text() for page in reader.pages)
    assert reader.metadata is not None
    assert reader.metadata.creation_date == datetime(2026, 11, 25, 9, 0, 0, tzinfo=UTC)
    assert main(asked) == 0  # the one under the other name is gone: it is of the same command
    name = pdf_of(tmp_path).name
    assert re.fullmatch(rf"[{LETTERS}]{{3}}-[{LETTERS}]{{3}}_supine_2026-11-25_report.pdf", name)


@pytest.mark.slow
@pytest.mark.usefixtures("quick_reports")
def test_a_fit_keeps_the_code_and_the_day_of_its_scan(copy_of_a_fit: Path, tmp_path: Path) -> None:
    assert write_patient(copy_of_a_fit, " K7M-4QX ", date(2026, 11, 20)) == "K7M-4QX"
    out = tmp_path / "out"
    assert main(["report", str(copy_of_a_fit), "-o", str(out)]) == 0
    assert pdf_of(out).name == "K7M-4QX_standing_2026-11-20_report.pdf"
    assert "standing, scanned 2026-11-20" in " ".join(pypdf.PdfReader(pdf_of(out)).pages[-1].extract_text().split())


@pytest.mark.slow
@pytest.mark.usefixtures("quick_reports")
def test_the_plan_is_shown_with_its_numbers(fits: dict[str, Path], tmp_path: Path) -> None:
    plan = {
        "schema": "breastrig/plan@1",
        "items": [
            {"kind": "pattern", "id": "w", "name": "reduction", "parameters": {"areola_mm": 44.0, "side": "L"}},
            {"kind": "tumour", "id": "t", "side": "R", "clock": 10.5, "distance_mm": 45.0, "radius_mm": 12.0},
            {"kind": "note", "id": "n", "text": "Keep the scar of 2019."},
        ],
    }
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    out = tmp_path / "out"
    assert main(["report", str(fits["standing"]), "--plan", str(tmp_path / "plan.json"), "-o", str(out)]) == 0
    texts = [" ".join(page.extract_text().split()) for page in pypdf.PdfReader(pdf_of(out)).pages]
    for words in (
        "Reduction (Wise pattern), left breast New areola 44 mm Vertical limbs ",
        "mm (asked for: 0 mm; a nipple is not moved down)",
        "Tumour, right breast Hour 10:30 From the nipple 45 mm Radius 12 mm Below the skin not known",
        "Note Keep the scar of 2019.",
    ):
        assert texts[0].count(words) == 1, words
    assert not any("_L" in text or "_R" in text for text in texts)
    tape = texts[-1].partition("Tape sheet")[2]
    assert tape.count("New nipple, left") == 1
    assert tape.count("Areola to keep, left") == 1


@pytest.mark.usefixtures("quick_reports")
def test_the_folder_of_two_stances_fitted_together_is_enough(
    report: Path, fits: dict[str, Path], tmp_path: Path
) -> None:
    pair = tmp_path / "pair"
    pair.mkdir()
    (pair / "pair.json").write_text("{}")
    for name, stance in (("first", "standing"), ("second", "supine")):
        (pair / name).symlink_to(fits[stance])
    assert main(["report", str(pair), "-o", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out" / "measures.csv").read_bytes() == (report / "measures.csv").read_bytes()


@pytest.mark.parametrize("command", ["report", "export"])
def test_a_folder_that_is_no_fit_is_one_line(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, str(tmp_path), "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "fit" in error


@pytest.fixture
def copy_of_a_fit(fits: dict[str, Path], tmp_path: Path) -> Path:
    copy = tmp_path / "fit"
    copy.mkdir()
    for file in fits["standing"].iterdir():
        (copy / file.name).write_bytes(file.read_bytes())
    return copy


@pytest.mark.parametrize("command", ["report", "export"])
def test_a_damaged_drawing_is_one_line(command: str, copy_of_a_fit: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (without_hashes(copy_of_a_fit) / "drawing.json").write_text('{"shapes": [{"name": "x"}]}')
    assert main([command, str(copy_of_a_fit), "-o", str(copy_of_a_fit / "out")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "fit/drawing.json is damaged" in error


def test_a_result_without_what_is_shown_is_one_line(copy_of_a_fit: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = document(without_hashes(copy_of_a_fit), "result.json")
    alone = NOTHING | {"mean": 1.0}
    damages = (
        ("versions", None),
        ("scan_to_model_mm", alone),
    )
    for key, damaged in damages:
        (copy_of_a_fit / "result.json").write_text(json.dumps(result | {key: damaged}))
        assert main(["report", str(copy_of_a_fit), "-o", str(copy_of_a_fit / "out")]) == 2
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        assert key in error


def test_a_place_that_cannot_be_written_is_one_line(
    fits: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("in the way")
    assert main(["export", str(fits["standing"]), "-o", str(tmp_path / "file")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_the_exported_surface_is_ready_for_tetrahedra(fits: dict[str, Path], tmp_path: Path) -> None:
    stance = "supine"
    assert main(["export", str(fits[stance]), "-o", str(tmp_path)]) == 0
    mesh = trimesh.load(tmp_path / "surface.ply", process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0.0
    assert len(crossing_faces(np.asarray(mesh.vertices), np.asarray(mesh.faces))) == 0
    assert np.degrees(mesh.face_angles.min()) > 5.0
    sets = document(tmp_path, "surface.json")
    fitted = trimesh.load(fits[stance] / "fitted.ply", process=False)
    assert (mesh.faces[: len(fitted.faces)] == fitted.faces).all()
    assert sets["volume_ml"] == pytest.approx(1e6 * mesh.volume * (1.0 if sets["unit"] == "m" else 1e-9), rel=1e-3)
    assert len(sets["caps"]) == 4
    landmarks = document(fits[stance], "result.json")["landmarks"]
    per_mm = 1e-3 if sets["unit"] == "m" else 1.0
    for name, place in landmarks.items():
        found = sets["landmarks"][name]
        exact = np.array(found["barycentric"]) @ mesh.vertices[mesh.faces[found["face"]]]
        assert np.linalg.norm(exact - place) < 0.02 * per_mm + sets["smoothed_by_mm"] * per_mm
        apart = np.linalg.norm(mesh.vertices[found["vertex"]] - exact) / per_mm
        assert apart == pytest.approx(found["distance_mm"], abs=0.02)
    shapes = {shape["name"]: shape for shape in document(fits[stance], "drawing.json")["shapes"]}
    assert sets["lines"].keys() == shapes.keys()
    for name, line in sets["lines"].items():
        assert len(line["surface_points"]) == len(shapes[name]["points"])
        gaps = [
            np.linalg.norm(mesh.vertices[line["vertices"]] - point, axis=1).min() for point in shapes[name]["points"]
        ]
        assert max(gaps) / per_mm <= line["distance_mm"] + 0.02
    stl = trimesh.load(tmp_path / "surface.stl")
    assert stl.is_watertight
    document_glb, _ = split_glb((tmp_path / "drawing.glb").read_bytes())
    assert [node["name"] for node in document_glb["nodes"]] == list(shapes)

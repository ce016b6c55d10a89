"""A pattern that does not fit on this breast costs the pattern, never the fit; wherever it was asked for it is said."""

import json
from pathlib import Path

import pypdf
import pytest
from helpers import fake_batch
from helpers.blank_pictures import blank_pictures

import breastrig
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.report.pages.names import plainly

EXAMPLE = asset_folder("example") / "standing"
GIVEN = [str(EXAMPLE / "scan.ply"), "--landmarks", str(EXAMPLE / "landmarks.json")]
TOO_LONG = "reduction:limb_mm=80"  # of the most that can be asked for
ROWS = {"long": TOO_LONG}
SAID = "Not drawn: Reduction (Wise pattern). No room on the left: limbs of 80 mm reach the fold. Choose shorter"


def fitted(out: Path, *options: str, code: int = 4) -> dict[str, object]:
    """The result.json of `breastrig fit` of the example."""
    assert main(["fit", *GIVEN, *options, "-o", str(out)]) == code
    return dict(json.loads((out / "result.json").read_text("utf-8")))


def shape_names(out: Path) -> list[str]:
    return [shape["name"] for shape in json.loads((out / "drawing.json").read_text("utf-8"))["shapes"]]


def test_the_fit_is_the_same_the_rest_is_drawn_and_the_reason_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plain, asked = tmp_path / "plain", tmp_path / "asked"
    without = fitted(plain, "--drawing", "lumpectomy", "--tumour", "L:10,45,12", code=0)
    assert "drawing_missing" not in without
    assert "Not drawn" not in capsys.readouterr().err
    found = fitted(asked, "--drawing", f"lumpectomy+{TOO_LONG}", "--tumour", "L:10,45,12")
    (missing,) = found.pop("drawing_missing")
    assert missing.startswith(SAID)
    assert f"breastrig: {missing}\n" in capsys.readouterr().err
    changing = {"timing_s", "patient", "files", "fields"}  # codes are random, and stand in the drawing
    assert found.keys() == without.keys()
    assert all(found[key] == without[key] for key in found.keys() - changing)
    assert (asked / "fitted.ply").read_bytes() == (plain / "fitted.ply").read_bytes()
    assert shape_names(asked) == shape_names(plain)
    assert "tumour_L" in shape_names(asked)


@pytest.mark.slow
def test_alone_it_leaves_an_empty_drawing_that_the_report_and_a_program_explain(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blank_pictures(monkeypatch)
    out, report = tmp_path / "out", tmp_path / "report"
    (missing,) = fitted(out, "--drawing", TOO_LONG)["drawing_missing"]
    assert shape_names(out) == []
    fit = breastrig.Fit.load(out)
    assert fit.drawing_missing == (missing,)
    assert fit.drawing.lines == ()
    assert main(["report", str(out), "-o", str(report)]) == 4
    [pdf] = report.glob("*_report.pdf")
    printed = " ".join(page.extract_text() for page in pypdf.PdfReader(pdf).pages)
    assert plainly(missing) in " ".join(printed.split())
    (stance,) = json.loads((report / "report.json").read_text("utf-8"))["stances"]
    assert stance["drawing_missing"] == [missing]


@pytest.mark.slow
def test_a_tumour_that_is_nowhere_on_the_skin_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tumour, why = "at:1e308,0,0,10", "off the skin; check its frame and unit."
    (missing,) = fitted(tmp_path, "--drawing", "mastectomy", "--tumour", tumour)["drawing_missing"]
    assert missing.startswith("Not drawn: Tumour. ")
    assert missing.endswith(why)
    assert capsys.readouterr().err.splitlines().count(f"breastrig: {missing}") == 1
    names = shape_names(tmp_path)
    assert names
    assert "tumour_L" not in names


@pytest.mark.usefixtures("batch_here")
@pytest.mark.slow
def test_a_row_of_a_batch_is_done_once_and_its_line_says_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    manifest, out = tmp_path / "manifest.csv", tmp_path / "out"
    rows = (f'{EXAMPLE}/scan.ply,{EXAMPLE}/landmarks.json,{name},"{drawing}"' for name, drawing in ROWS.items())
    manifest.write_text("\n".join(("scan,landmarks,name,drawing", *rows)) + "\n", "utf-8")
    assert main(["batch", str(manifest), "-o", str(out)]) == 4
    found = {row["name"]: row for row in fake_batch.table(out)}
    assert {name: row["state"] for name, row in found.items()} == {"long": "done"}
    missing = found["long"]["drawing_missing"]
    assert missing.startswith(SAID)
    assert capsys.readouterr().err == f"breastrig: long: {missing}\n"
    written = (out / "long" / "result.json").stat().st_mtime_ns
    assert main(["batch", str(manifest), "-o", str(out)]) == 4
    assert capsys.readouterr().err == f"breastrig: long: {missing}\n"
    assert (out / "long" / "result.json").stat().st_mtime_ns == written

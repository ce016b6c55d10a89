"""The template in true size: measured back on the body and on the printed page, and what it refuses."""

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pypdf
import pytest
from helpers.written_fit import write_fit
from PIL import Image

from breastrig.cli.main import main
from breastrig.core.errors import BadDrawing, BadInput
from breastrig.core.identity import Identity
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.polyline import Polyline, length, point_along
from breastrig.report.guides import template as module
from breastrig.report.guides import template_pdf as pages
from breastrig.report.guides.template import Piece, template
from breastrig.report.pages.typeset import typeset
from breastrig.report.stance import Stance, places
from breastrig.rig.model import Rig


def with_circle(stance: Stance, name: str, share: float, radius: float) -> Stance:
    """The stance with one line: a circle along the skin, so far on the way from her left nipple to the notch."""
    tape, known = Geodesics(stance.vertices, stance.rig.faces), places(stance)
    nipple, notch = (stance.on_model(known[each].point[None]) for each in ("nipple_L", "suprasternal_notch"))
    way = tape.path(nipple, notch)
    centre = stance.on_model(point_along(way, share * length(way))[None])
    around = tape.circle(int(centre.faces[0]), centre.barycentric[0], radius)
    return replace(stance, lines=(Polyline(name, True, "#101010", around, np.zeros(len(around), dtype=bool)),))


@pytest.fixture(scope="module")
def flat_enough(at_rest: Stance) -> Stance:
    """A circle above the breast, through which the way to the notch goes."""
    return with_circle(at_rest, "cut_L", 0.6, 0.02)


@pytest.fixture(scope="module")
def piece(flat_enough: Stance) -> Piece:
    [found], said = template(flat_enough)
    assert said == ()
    return found


def test_every_hole_and_line_is_where_a_tape_along_the_skin_finds_it(flat_enough: Stance, piece: Piece) -> None:
    """The body's own geodesics are measured here, not those of the piece that was laid flat."""
    nipple, notch = piece.holes
    assert (nipple.place.name, notch.place.name) == ("nipple_L", "suprasternal_notch")
    [line] = piece.lines
    assert piece.slits == ()
    assert line.error <= 0.001
    tape = Geodesics(flat_enough.vertices, flat_enough.rig.faces)
    chosen = np.arange(0, len(line.line), len(line.line) // 6)
    skin = flat_enough.on_model(np.concatenate([line.line.points[chosen], notch.place.point[None]]))
    paper = np.concatenate([line.points[chosen], notch.at[None]])
    for one in range(len(paper)):
        for other in range(one):
            on_paper = float(np.linalg.norm(paper[one] - paper[other]))
            assert on_paper == pytest.approx(tape.distance(skin[[one]], skin[[other]]), abs=0.001)
    way = tape.distance(flat_enough.on_model(nipple.place.point[None]), skin[[-1]])
    assert np.linalg.norm(nipple.at - notch.at) == pytest.approx(way, abs=0.0025), "less what the nipple stands out"


def test_a_ring_on_a_curved_breast_is_slit_and_as_long_as_on_the_skin(at_rest: Stance) -> None:
    stance = with_circle(at_rest, "cut_L", 0.0, 0.045)
    [ring], _ = template(stance)
    [line] = ring.lines
    assert len(ring.slits) == line.ends.sum() == 1
    steps = np.linalg.norm(np.diff(line.points, axis=0), axis=1)[~line.ends]
    skin = np.linalg.norm(np.diff(stance.lines[0].outline, axis=0), axis=1)[~line.ends]
    assert steps.sum() == pytest.approx(skin.sum(), abs=0.001)
    assert line.error <= 0.001


def test_the_head_is_up_and_the_printed_side_outside(piece: Piece) -> None:
    nipple, notch = piece.holes
    assert notch.at[1] - nipple.at[1] > 0.1
    assert notch.at[0] < nipple.at[0], "from the front, her left breast is to the right of the notch"
    assert piece.name == "Patient's left side"


def longest_run(dots: np.ndarray) -> int:
    steps = np.diff(np.concatenate([[0], dots.astype(np.int8), [0]]))
    return int((np.flatnonzero(steps == -1) - np.flatnonzero(steps == 1)).max(initial=0))


def test_the_printed_page_is_in_true_size(piece: Piece) -> None:
    identity = Identity("K7M-4QX", scanned=("2026-11-25",), planned="2026-11-28", plan_version=3)
    content = pages.template_content([piece], "supine", identity)
    [shown] = content["pieces"]
    [[_, drawn]], [[_, notch]] = shown["lines"][0]["strokes"], [hole for hole in shown["holes"] if hole[0] == "Notch"]
    expected = 1e3 * np.linalg.norm(piece.lines[0].points - piece.holes[1].at, axis=1)
    np.testing.assert_allclose(np.linalg.norm(np.array(drawn) - notch, axis=1), expected, atol=0.02)
    per_mm = 4.0
    sheets = typeset("guides", "template.typ", content, format="png", ppi=25.4 * per_mm)
    image = np.asarray(Image.open(io.BytesIO(sheets[0])).convert("L")) < 100
    assert image.shape == ((297 * per_mm, 210 * per_mm) if not shown["lying"] else (210 * per_mm, 297 * per_mm))
    for bars in (image, image.T):
        assert max(map(longest_run, bars)) == pytest.approx(100 * per_mm, abs=1)
    text = " ".join(
        page.extract_text()
        for page in pypdf.PdfReader(io.BytesIO(pages.template_pdf([piece], "supine", identity))).pages
    )
    for words in (
        "K7M-4QX",
        "Patient's left side",
        "supine",
        "2026-11-25",
        "version 3",
        "2026-11-28",
        "100 mm",
        "Research use",
    ):
        assert words in text.replace("\n", " "), words


def test_a_line_that_is_off_is_dashed_and_where_no_skin_was_seen_dotted(piece: Piece) -> None:
    [line] = piece.lines
    off, bridged = np.zeros(len(line.points)), np.zeros(len(line.line), dtype=bool)
    off[3:6], bridged[20:25] = 0.0015, True
    shown = replace(piece, lines=(replace(line, off=off, line=replace(line.line, bridged=bridged)),))
    [drawn] = pages.template_content([shown], "supine", Identity())["pieces"][0]["lines"]
    looks = [look for look, _ in drawn["strokes"]]
    assert looks == ["solid", "dashed", "solid", "dotted", "solid"]
    assert drawn["row"][2:] == ["1.5", "as drawn"]


def test_what_is_not_laid_flat_says_why(at_rest: Stance, piece: Piece, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(BadDrawing, match="Cut, right: it lies on the patient's left side"):
        template(with_circle(at_rest, "cut_R", 0.0, 0.02))
    with pytest.raises(BadInput, match="Nothing is drawn"):
        template(replace(at_rest, lines=()))
    bent = replace(piece.lines[0], stretch=0.007)
    left, said = module._without_the_farthest(replace(piece, lines=(piece.lines[0], bent)))
    assert left.lines == piece.lines
    assert said == [
        "Cut, left is left out: laid flat it is up to 7 mm off; use the report's tape sheet for it.",
    ]
    with pytest.raises(BadDrawing, match="too curved"):
        module._without_the_farthest(replace(piece, lines=(bent,)))


def test_the_command_writes_the_sheets_once(tmp_path: Path, rig: Rig) -> None:
    folder = write_fit(tmp_path / "fit", rig, np.array(rig.template), np.full(len(rig.template), 0.004))
    file = tmp_path / "template.pdf"
    assert main(["template", str(folder), "-o", str(file), "--code", "K7M-4QX"]) == 0
    text = " ".join(page.extract_text() for page in pypdf.PdfReader(file).pages)
    assert "K7M-4QX" in text
    assert "Cut" in text
    assert main(["template", str(folder), "-o", str(file)]) == 2
    worse = write_fit(
        tmp_path / "bad",
        rig,
        np.array(rig.template),
        np.full(len(rig.template), 0.004),
        verdict={"level": "unusable", "reasons": ["No."]},
    )
    assert main(["template", str(worse), "-o", str(tmp_path / "no.pdf")]) == 2

"""The guide to print in 3D: closed, two millimetres thick, on the skin, with slots where the lines are."""

import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.written_fit import write_fit

from breastrig.cli.main import main
from breastrig.core.errors import BadDrawing, BadInput
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.polyline import Polyline
from breastrig.report.body_frame import body_frame
from breastrig.report.guides import shell
from breastrig.report.guides.shell import PAPILLA, THICK, Guide, guide
from breastrig.report.stance import Stance, places
from breastrig.rig.model import Rig


@pytest.fixture(scope="module")
def planned(at_rest: Stance) -> Stance:
    """A circle of 25 mm around her left nipple."""
    nipple = at_rest.on_model(places(at_rest)["nipple_L"].point[None])
    around = Geodesics(at_rest.vertices, at_rest.rig.faces).circle(int(nipple.faces[0]), nipple.barycentric[0], 0.025)
    return replace(at_rest, lines=(Polyline("cut_L", True, "#101010", around, np.zeros(len(around), dtype=bool)),))


@pytest.fixture(scope="module")
def made(planned: Stance) -> Guide:
    return guide(planned, "L")


def in_frame(stance: Stance, points: np.ndarray) -> np.ndarray:
    frame = body_frame(stance.rig, stance.vertices)
    return (points - frame.middle) @ frame.axes


@pytest.fixture(scope="module")
def body(planned: Stance) -> ClosestPointSearch:
    return ClosestPointSearch(in_frame(planned, planned.vertices), planned.rig.faces)


def test_it_is_one_closed_body_as_thick_as_it_says(made: Guide) -> None:
    mesh = trimesh.Trimesh(made.vertices, made.faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.body_count == 1
    assert mesh.volume == pytest.approx(0.5 * THICK * mesh.area, rel=0.15), "two faces, and walls; outward normals"


def test_its_inside_lies_on_the_skin_and_its_outside_two_millimetres_above(
    made: Guide, body: ClosestPointSearch, planned: Stance
) -> None:
    nipple = in_frame(planned, places(planned)["nipple_L"].point[None])[0]
    away = np.linalg.norm(made.vertices - nipple, axis=1) > PAPILLA + 0.004  # the skin without what stands out
    gaps = body.query(made.vertices[away]).distances
    inside = gaps < 0.5 * THICK
    assert 0.3 < inside.mean() < 0.7
    assert gaps[inside].max() < 3e-4
    np.testing.assert_allclose(gaps[~inside], THICK, atol=3e-4)


def test_slots_are_on_the_line_with_bridges_between_and_the_nipple_has_its_hole(made: Guide, planned: Stance) -> None:
    shape = ClosestPointSearch(made.vertices, made.faces)
    line = in_frame(planned, planned.lines[0].points)
    is_open = shape.query(line).distances > 5e-4
    assert 0.5 < is_open.mean() < 0.9
    assert np.abs(np.diff(is_open.astype(int))).sum() >= 8, "several slots"
    np.testing.assert_allclose(shape.query(line[is_open]).distances.max(), shell.SLOT, atol=2e-4)
    nipple = in_frame(planned, places(planned)["nipple_L"].point[None])
    assert shape.query(nipple).distances[0] > PAPILLA - 0.002


def test_the_arrow_says_how_far_the_notch_is(made: Guide, planned: Stance) -> None:
    tape = Geodesics(planned.vertices, planned.rig.faces)
    frame = body_frame(planned.rig, planned.vertices)
    ends = planned.on_model(
        np.stack([made.tip @ frame.axes.T + frame.middle, places(planned)["suprasternal_notch"].point])
    )
    assert tape.distance(ends[[0]], ends[[1]]) == pytest.approx(made.to_notch, abs=1e-3)
    assert ClosestPointSearch(made.vertices, made.faces).query(made.tip[None]).distances[0] > 5e-4, "cut through"


def test_what_cannot_be_made_says_why(planned: Stance, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(BadInput, match="No line is on the patient's right side alone"):
        guide(planned, "R")
    monkeypatch.setattr(shell, "BRIDGE", 0.0)
    monkeypatch.setattr(shell, "FINER", 1)
    with pytest.raises(BadDrawing, match="into pieces"):
        guide(planned, "L")


def test_the_command_writes_millimetres_and_says_the_distance(
    tmp_path: Path,
    rig: Rig,
    planned: Stance,
    made: Guide,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(shell, "guide", lambda stance, side: {("cut_L", "L"): made}[stance.lines[0].name, side])
    folder = write_fit(tmp_path / "fit", rig, np.array(rig.template), np.full(len(rig.template), 0.004))
    drawn = {"name": "cut_L", "closed": True, "points": (1e3 * planned.lines[0].points[::3]).tolist()}
    plan = tmp_path / "plan.json"
    plan.write_text(json.dumps({"schema": "breastrig/drawing@1", "name": "own", "unit": "mm", "shapes": [drawn]}))
    file = tmp_path / "guide.stl"
    asked = ["template", str(folder), "--plan", str(plan), "-o", str(file)]
    assert main(asked) == 2
    assert "say L or R" in capsys.readouterr().err
    assert main([*asked, "--side", "L"]) == 0
    assert "Arrow's tip to notch" in capsys.readouterr().out
    mesh = trimesh.load(io.BytesIO(file.read_bytes()), file_type="stl")
    assert mesh.is_watertight
    assert 60.0 < mesh.extents.max() < 130.0
    assert main([*asked[:-1], str(tmp_path / "guide.obj")]) == 2

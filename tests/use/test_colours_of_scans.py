"""What a scan's colours are to a program: the same whether it gives the file or what it has read of it."""

from pathlib import Path

import numpy as np
import pytest
from helpers.mesh_variants import (
    BASE,
    FACES,
    JPEG,
    OF_VERTICES,
    UV_FLIPPED,
    VERTICES,
    glb,
    painted_obj,
    ply,
    vertex_colours,
)

import breastrig
from breastrig.core.assets import asset_folder
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.read import PICTURE_TOO_LARGE, UNPAINTED_ARRAYS
from breastrig.use.scan import ScanSource
from breastrig.use.values.drawing import Line, document_of, drawing_of

FILES = {
    "scan.ply": ply(vertex_colours("uchar", OF_VERTICES)),
    "scan.zip": painted_obj("newmtl skin\nmap_Kd skin.jpg\n", {"skin.jpg": JPEG}),
    "scan.glb": glb({"TEXCOORD_0": UV_FLIPPED}, material=BASE, image=(JPEG, "image/jpeg")),
}


@pytest.mark.parametrize("name", FILES)
def test_a_scan_that_was_read_has_all_that_a_fit_sees_of_its_file(name: str, tmp_path: Path) -> None:
    file = tmp_path / name
    file.write_bytes(FILES[name])
    wanted, _ = ScanSource(file, "auto").read()
    assert wanted.shows_colour
    for source in (file, FILES[name]):
        found = breastrig.read_scan(source).in_metres
        np.testing.assert_array_equal(found.vertices, wanted.vertices)
        np.testing.assert_array_equal(found.faces, wanted.faces)
        assert found.picture == wanted.picture
        for own, other in ((found.uv, wanted.uv), (found.colours, wanted.colours)):
            assert (own is None) == (other is None)
            if own is not None and other is not None:
                np.testing.assert_array_equal(own, other)


def test_a_picture_over_a_limit_is_left_out_and_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("breastrig.scan.pictures.texture.IMAGE_PIXELS", 100)
    scan = breastrig.read_scan(FILES["scan.zip"])
    assert scan.notes == (PICTURE_TOO_LARGE,)
    assert not scan.in_metres.shows_colour


def test_triangles_without_colours_say_what_is_not_looked_for() -> None:
    assert breastrig.Scan.from_arrays(VERTICES, FACES).notes == (UNPAINTED_ARRAYS,)
    assert breastrig.Scan.from_arrays(VERTICES, FACES, OF_VERTICES).notes == ()


def test_a_line_has_the_radius_of_each_point_and_keeps_it() -> None:
    shape = {"name": "a", "points": [[0, 0, 0], [1, 0, 0]], "error_mm": [7.5, None]}
    (line,) = drawing_of({"schema": "breastrig/drawing@1", "unit": "mm", "shapes": [shape]}).lines
    np.testing.assert_array_equal(line.error_mm, [7.5, np.nan])
    (written,) = document_of([line])["shapes"]
    assert written["error_mm"] == [7.5, None]
    assert Line("b", np.zeros((1, 3))).error_mm is None


@pytest.mark.slow
def test_what_colours_show_counts_beside_picks_of_other_landmarks() -> None:
    """A pick takes nothing away of what was seen: the nipples stay where the areolae are, as sure as without it."""
    place = asset_folder("example") / "standing"
    scan, (true, unit) = breastrig.read_scan(place / "scan.ply", "m"), read_landmarks(place / "landmarks.json")
    assert unit == "mm"
    alone, beside = (
        breastrig.fit(scan, {name: [1e-3 * x for x in true[name]] for name in names} or None).result
        for names in ((), ("xiphoid", "acromion_L", "acromion_R"))
    )
    assert alone["landmarks_seen"] == {"nipple_L": "areola seen", "nipple_R": "areola seen"}
    assert beside["landmarks_seen"] == alone["landmarks_seen"]
    for name in ("nipple_L", "nipple_R"):
        assert beside["landmarks"][name] == pytest.approx(alone["landmarks"][name], abs=0.002)
        radii = [each["landmark_uncertainty_mm"][name] for each in (alone, beside)]
        assert radii[1] < max(1.05 * radii[0], radii[0] + 1.0)

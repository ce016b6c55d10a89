"""Small marks in colours: dots, crosses and moles are found where they are; lines, hair and scars are none."""

import numpy as np
import pytest
from helpers.inked_scan import inked_zip, place, vertex_coloured

from breastrig.colour.spots import CROSS, MOLE, PEN, ColourSpot, find_spots
from breastrig.core.errors import BadScan
from breastrig.scan.read import read_scan, scan_of_arrays
from breastrig.scan.scan import Scan

MOLE_AT, CROSS_AT = place(np.array([[40.0, 150.0], [100.0, 30.0]]))
SKIN = (180, 140, 120)


def near(found: tuple[ColourSpot, ...], at: np.ndarray) -> list[ColourSpot]:
    return [spot for spot in found if np.linalg.norm(spot.place - at) < 1.5e-3]


def test_the_mole_and_the_cross_of_a_drawing_are_found_and_no_line_of_it(inked: Scan) -> None:
    found = find_spots(inked)
    assert len(found) == 2
    [mole], [cross] = near(found, MOLE_AT), near(found, CROSS_AT)
    assert (mole.kind, cross.kind) == (MOLE, CROSS)
    assert mole.size == pytest.approx(4e-3, abs=0.8e-3)
    assert mole.colour[0] < -15.0


@pytest.mark.parametrize("dark", [False, True])
def test_skin_with_a_mole_alone_has_nothing_else(dark: bool) -> None:
    scan = read_scan(inked_zip(bare=True, dark=dark), units="m", for_display=False)
    [mole] = find_spots(scan)
    assert mole.kind == MOLE
    assert np.linalg.norm(mole.place - MOLE_AT) < 1e-3


def sheet(marks: list[tuple[float, float, tuple[int, int, int]]]) -> Scan:
    """A flat strip of skin with a vertex every 0.7 mm, and discs (x mm, radius mm, colour) on it."""
    along, across = np.arange(-150.0, 150.0, 0.7), np.arange(-20.0, 20.0, 0.7)
    x, y = (each.ravel() for each in np.meshgrid(along, across, indexing="ij"))
    colours = np.tile(np.array(SKIN, dtype=np.uint8), (len(x), 1))
    for middle, radius, colour in marks:
        colours[np.hypot(x - middle, y) <= radius] = colour
    n = len(across)
    first = (np.arange(len(along) - 1)[:, None] * n + np.arange(n - 1)).ravel()
    low, high = [first, first + n, first + 1], [first + n, first + n + 1, first + 1]
    faces = np.concatenate([np.stack(low, axis=1), np.stack(high, axis=1)])
    return scan_of_arrays(1e-3 * np.stack([x, y, 0.0 * x], axis=1), faces, colours, "m")


def test_a_dot_is_no_mole_and_an_areola_is_neither() -> None:
    found = find_spots(sheet([(-25.0, 2.0, (60, 40, 130)), (0.0, 2.0, (90, 60, 45)), (25.0, 10.0, (140, 95, 85))]))
    assert {spot.kind: round(1e3 * spot.place[0]) for spot in found} == {PEN: -25, MOLE: 0}


def test_scans_without_fine_colours_are_refused() -> None:
    vertices, faces, colours = vertex_coloured(40)
    for scan, sentence in (
        (scan_of_arrays(vertices, faces, None, "m"), "no colour"),
        (scan_of_arrays(vertices, faces, colours, "m"), "too coarse"),
    ):
        with pytest.raises(BadScan, match=sentence):
            find_spots(scan)

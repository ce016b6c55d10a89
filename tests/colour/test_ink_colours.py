"""What a line's densities say: ink of five markers, and what else draws lines on skin."""

import numpy as np
import pytest

from breastrig.colour.ink.find_ink import MARKERS, markers_of
from breastrig.colour.ink.pieces import Ink, Measured, Piece, _measured, ink_of
from breastrig.colour.ink.ridges import OFFSETS


@pytest.mark.parametrize(
    ("what", "added", "width_mm", "ink"),
    [
        ("violet", (0.5, 0.55, 0.0), 2.3, Ink.COLOURED),
        ("blue", (0.5, 0.5, 0.2), 2.0, Ink.COLOURED),
        ("green", (0.8, 0.45, 0.6), 2.0, Ink.COLOURED),
        ("faint green", (0.25, 0.17, 0.2), 1.9, Ink.COLOURED),
        ("red", (0.4, 0.7, 0.7), 2.2, Ink.RED),
        ("black", (1.0, 1.0, 1.0), 2.0, Ink.BLACK),
        ("faint black", (0.3, 0.31, 0.3), 2.7, Ink.BLACK),
        ("thin black on brown skin", (0.5, 0.6, 0.7), 2.0, Ink.BLACK),
        ("mole or vein", (0.15, 0.28, 0.4), 3.0, None),
        ("red scar", (0.12, 0.35, 0.31), 2.5, None),
        ("rim of an areola", (0.2, 0.39, 0.57), 3.5, None),
        ("hair", (0.22, 0.25, 0.27), 1.5, None),
        ("crease", (0.3, 0.3, 0.3), 4.0, None),
        ("blue cloth", (1.86, 0.83, 0.54), 3.0, None),
        ("nothing", (0.02, 0.02, 0.02), 2.0, None),
        ("violet on the darkest skin", (0.12, 0.35, -0.7), 2.3, Ink.COLOURED),
        ("blue on the darkest skin", (0.17, 0.07, -0.7), 2.0, Ink.COLOURED),
        ("green on the darkest skin", (0.3, -0.35, -0.14), 2.9, Ink.COLOURED),
        ("green in the shade of the darkest skin", (-0.01, -0.37, -0.31), 3.9, Ink.COLOURED),
        ("violet, the skin's own green", (0.11, 0.23, -0.31), 2.8, Ink.COLOURED),
        ("red on brown skin", (0.0, 0.26, 0.24), 2.8, Ink.RED),
        ("red on the darkest skin", (-0.27, 0.2, 0.11), 3.1, Ink.RED),
        ("blood vessel on brown skin", (0.06, 0.26, 0.26), 2.0, None),
        ("pale scar on dark skin", (-0.25, -0.15, -0.1), 2.0, None),
        ("gloss", (-0.5, -0.6, -0.7), 2.0, None),
        ("bluish gloss", (-0.5, -0.6, -0.8), 2.0, None),
    ],
)
def test_ink_is_distinguished_from_skin_hair_shadow_and_cloth(
    what: str, added: tuple[float, float, float], width_mm: float, ink: Ink | None
) -> None:
    assert ink_of(np.array(added), 1e-3 * width_mm) is ink, what


@pytest.mark.parametrize(
    ("what", "added", "width_mm", "ink"),
    [
        ("worn black on brown skin", (0.21, 0.23, 0.29), 2.0, Ink.BLACK),
        ("hair", (0.22, 0.25, 0.27), 1.5, None),
        ("crease", (0.25, 0.25, 0.25), 3.6, None),
        ("mole or vein", (0.15, 0.28, 0.4), 3.0, None),
        ("red scar", (0.12, 0.35, 0.31), 2.5, None),
        ("very thin black", (0.5, 0.5, 0.5), 1.2, Ink.BLACK),
        ("violet", (0.5, 0.55, 0.0), 2.3, Ink.COLOURED),
    ],
)
def test_where_black_ink_is_sure_a_fainter_line_is_black_and_all_else_what_it_was(
    what: str, added: tuple[float, float, float], width_mm: float, ink: Ink | None
) -> None:
    assert ink_of(np.array(added), 1e-3 * width_mm, has_black=True) is ink, what
    without = None if what.startswith("worn") else ink
    assert ink_of(np.array(added), 1e-3 * width_mm) is without, what


@pytest.mark.parametrize("exposure", [0.35, 0.6, 0.9])
@pytest.mark.parametrize("share", [0.3, 0.8])
def test_each_marker_is_known_under_any_exposure_and_however_thin(exposure: float, share: float) -> None:
    skin = exposure * np.array([0.45, 0.26, 0.18])
    inks = exposure * np.array([marker.light for marker in MARKERS])
    added = -np.log(((1 - share) * skin + share * inks) / skin)
    assert markers_of(added, np.ones(len(MARKERS)), -np.log(skin)) == list(MARKERS)
    assert markers_of(added[:0], np.zeros(0), -np.log(skin)) == []


def test_a_hue_that_one_side_of_the_line_has_too_is_no_ink() -> None:
    for added, ink in (((0.17, 0.07, -0.7), Ink.COLOURED), ((-0.27, 0.2, 0.11), Ink.RED)):
        towards = np.sign(added[0])
        assert ink_of(np.array(added), 2.9e-3, hue=0.05 * towards) is None
        assert ink_of(np.array(added), 2.9e-3, hue=0.5 * towards) is ink


def piece(added: tuple[float, float, float], aside: float, length: float = 0.03) -> Piece:
    """Along y, `aside` (m) of the y axis."""
    along = np.arange(0.0, length, 5e-4)
    places = np.column_stack([np.full(len(along), aside), along, np.zeros(len(along))])
    values = np.array(added)
    hue = float(values[0] - values[1:].mean())
    return Piece(places, np.zeros(len(along), dtype=np.int64), False, length, values, np.ones(3), 2.9e-3, hue)


def test_the_rims_of_opposite_hue_that_a_compressed_picture_has_are_no_lines() -> None:
    red, rim, violet = piece((-0.4, 0.4, 0.2), 0.0), piece((0.24, -0.13, -0.09), 4e-3), piece((0.3, 0.5, -0.3), -4e-3)
    assert Measured((red, rim, violet)).pieces() == [red, violet]
    far = piece((0.24, -0.13, -0.09), 9e-3)
    assert Measured((red, far)).pieces() == [red, far]


@pytest.mark.parametrize("added", [(0.0, -0.4, -0.3), (-0.05, -0.35, -0.3), (0.7, 0.6, 0.6), (-0.3, 0.25, 0.15)])
def test_a_line_has_its_width_whether_it_is_darker_than_the_skin_or_lighter(added: tuple[float, float, float]) -> None:
    line = np.exp(-0.5 * (OFFSETS / 1.2e-3) ** 2)
    across = np.array([2.5, 3.1, 3.7]) + line[:, None] * np.array(added)
    _, _, _, (width,) = _measured(np.repeat(across[None], 5, axis=0), [np.arange(5)])
    assert 2.0e-3 < width < 4.0e-3


def test_a_line_beside_it_adds_nothing_to_its_width() -> None:
    line, other = np.exp(-0.5 * (OFFSETS / 0.8e-3) ** 2), np.abs(OFFSETS - 3.5e-3) < 0.3e-3
    widths = []
    for strength in (line, np.maximum(line, other)):
        across = np.array([2.5, 3.1, 3.7]) + strength[:, None] * np.array([0.7, 0.6, 0.6])
        widths.append(_measured(np.repeat(across[None], 5, axis=0), [np.arange(5)])[3][0])
    assert 1.5e-3 < widths[1] <= widths[0] < 2.5e-3

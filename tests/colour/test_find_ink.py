"""Lines of a pen are found on the skin, and nothing else is."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.inked_scan import inked_zip, place, strokes, vertex_coloured
from scipy.spatial import cKDTree

from breastrig.colour.ink.find_ink import InkLine, find_ink
from breastrig.colour.ink.kinds import Kind
from breastrig.core.errors import BadScan
from breastrig.geometry.polyline import resampled
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan

pytestmark = pytest.mark.long


def sampled(lines: tuple[InkLine, ...]) -> np.ndarray:
    return np.concatenate([np.zeros((0, 3)), *(resampled(each.line.points, 5e-4, each.line.closed) for each in lines)])


def missed_and_false(lines: tuple[InkLine, ...]) -> tuple[float, float, float]:
    """(Share of the true length that is missed, mm falsely drawn, mm from the middle)."""
    true = place(np.concatenate([stroke.places[stroke.drawn] for stroke in strokes()]))
    whole = place(np.concatenate([stroke.places for stroke in strokes()]))
    found = sampled(lines)
    off = cKDTree(whole).query(found)[0]
    return float((cKDTree(found).query(true)[0] > 3e-3).mean()), 0.5 * float((off > 3e-3).sum()), 1e3 * off.mean()


def test_all_of_the_drawing_is_found_across_the_seam_and_nothing_else(ink: tuple[InkLine, ...]) -> None:
    missed, false_mm, off_mm = missed_and_false(ink)
    assert missed < 0.05
    assert false_mm == 0.0
    assert off_mm < 0.4


def test_each_stroke_is_one_line_of_its_kind_and_marker(ink: tuple[InkLine, ...]) -> None:
    for stroke in strokes():
        if stroke.kind in ("line", "dashed", "closed"):
            tree = cKDTree(place(stroke.places))
            (line,) = (each for each in ink if np.median(tree.query(each.line.points)[0]) < 2e-3)
            assert (line.kind.value, line.marker.name) == (stroke.kind, stroke.marker)
            assert line.line.closed is stroke.closed
            dashes = 10 if stroke.kind == "dashed" else 1  # each is half a pen too long at both ends
            assert -1.0 < 1e3 * line.length - 0.5 * stroke.drawn.sum() < 2.5 * dashes
    marks = [each for each in ink if each.kind.is_mark]
    assert {each.kind for each in marks} == {Kind.CROSS, Kind.WRITING}
    assert {each.marker.name for each in marks if each.kind is Kind.CROSS} == {"green"}


def test_lines_lie_on_the_skin_evenly_and_are_named(ink: tuple[InkLine, ...], inked: Scan) -> None:
    assert len({each.line.name for each in ink}) == len(ink)
    assert [each.length for each in ink] == sorted((each.length for each in ink), reverse=True)
    for each in ink:
        radius = np.hypot(each.line.points[:, 0], each.line.points[:, 2])
        assert np.abs(radius - 0.15).max() < 5e-4
        assert np.linalg.norm(np.diff(each.line.points, axis=0), axis=1).max() < 1.6e-3
        assert not each.line.bridged.any()


@pytest.mark.parametrize("marker", ["black", "green"])
def test_every_marker_is_found_and_known(marker: str) -> None:
    lines = find_ink(read_scan(inked_zip(marker), units="m", for_display=False))
    assert missed_and_false(lines)[:2] < (0.06, 5.0)
    assert {each.marker.name for each in lines} == {marker}


@pytest.mark.parametrize("marker", ["violet", "red"])
def test_every_marker_is_found_and_known_on_the_darkest_skin_too(marker: str) -> None:
    lines = find_ink(read_scan(inked_zip(marker, dark=True), units="m", for_display=False))
    assert missed_and_false(lines)[:2] < (0.06, 5.0)
    assert {each.marker.name for each in lines} == {marker}


def test_a_worn_line_is_ink_where_the_scan_surely_has_black_ink_and_nowhere_else() -> None:
    across, *_ = strokes()
    for marker, is_found in (("black", True), ("violet", False)):
        lines = find_ink(read_scan(inked_zip(marker, worn=True), units="m", for_display=False))
        near = cKDTree(sampled(lines)).query(place(across.places))[0] < 3e-3
        assert bool(near.mean() > 0.95) is is_found
        assert {each.marker.name for each in lines} == {marker}
        assert missed_and_false(lines)[1] < 5.0  # neither the hair nor the scar


@pytest.mark.parametrize("dark", [False, True])
def test_moles_scars_hair_and_grain_are_no_ink(dark: bool) -> None:
    assert find_ink(read_scan(inked_zip(bare=True, dark=dark), units="m", for_display=False)) == ()


def test_lines_that_are_all_faint_are_no_ink() -> None:
    assert find_ink(read_scan(inked_zip("hint"), units="m", for_display=False)) == ()


def test_a_scan_of_one_colour_has_no_ink() -> None:
    vertices, faces, colours = vertex_coloured(120)
    assert find_ink(Scan(vertices, faces, "m", 1.0, "", "", colours=np.full_like(colours, 140))) == ()


@pytest.mark.parametrize(
    ("what", "sentence"),
    [
        ("one uv", "does not lie on its triangles"),
        ("one line", "does not lie on its triangles"),
        ("one point", "does not lie on its triangles"),
        ("huge", "too coarse for lines of a pen .* export it with a finer texture"),
        ("cut off", "cannot be decoded"),
        ("far uv", "does not lie on its triangles"),
    ],
)
def test_hostile_scans_end_in_one_sentence(what: str, sentence: str, inked: Scan) -> None:
    assert inked.uv is not None
    half = inked.picture[:5000]
    change = {
        "one uv": {"uv": np.zeros_like(inked.uv)},
        "far uv": {"uv": np.full_like(inked.uv, 1.7e308)},
        "one line": {"vertices": inked.vertices * [1.0, 0.0, 0.0]},
        "one point": {"vertices": inked.vertices * 0.0},
        "huge": {"vertices": inked.vertices * 500.0},
        "cut off": {"picture": half, "texture": half},
    }[what]
    with pytest.raises(BadScan, match=sentence):
        find_ink(replace(inked, **change))


def test_a_texture_at_random_shows_no_lines_and_a_scan_turned_inside_out_the_same(
    inked: Scan, ink: tuple[InkLine, ...]
) -> None:
    assert find_ink(replace(inked, uv=3.0 * np.random.default_rng(0).normal(size=inked.uv.shape))) == ()
    assert [each.kind for each in find_ink(replace(inked, faces=inked.faces[:, ::-1]))] == [each.kind for each in ink]


def test_a_turned_and_moved_scan_gives_the_same_lines(inked: Scan, ink: tuple[InkLine, ...]) -> None:
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    moved = replace(inked, vertices=inked.vertices @ turn.T + [3.0, -2.0, 1.0])
    there = find_ink(moved)
    assert [each.kind for each in there if each.length > 0.02] == [each.kind for each in ink if each.length > 0.02]
    back = (sampled(there) - [3.0, -2.0, 1.0]) @ turn
    assert np.percentile(cKDTree(sampled(ink)).query(back)[0], 95) < 5e-4


def test_colours_of_fine_vertices_will_do_and_coarse_ones_are_one_sentence() -> None:
    vertices, faces, colours = vertex_coloured(120)
    fine = find_ink(Scan(vertices, faces, "m", 1.0, "", "", colours=colours))
    assert missed_and_false(fine)[:2] < (0.1, 10.0)
    vertices, faces, colours = vertex_coloured(40)
    with pytest.raises(BadScan, match=r"3\.0 mm apart, too coarse") as error:
        find_ink(Scan(vertices, faces, "m", 1.0, "", "", colours=colours))
    assert str(error.value).count(".") <= 4
    with pytest.raises(BadScan, match="no colour"):
        find_ink(Scan(vertices, faces, "m", 1.0, "", ""))


def test_a_line_goes_on_behind_a_hole_of_the_scan_and_says_so(inked: Scan) -> None:
    middle = inked.vertices[inked.faces].mean(axis=1)
    hole = np.linalg.norm(middle - place(np.array([[160.0, 68.0]])), axis=1) < 7.5e-3
    holed = replace(inked, faces=inked.faces[~hole])
    longest = max(find_ink(holed), key=lambda each: np.ptp(each.line.points[:, 0]))
    across = longest.line.points
    assert np.ptp(across[:, 0]) > 0.18
    bridged = across[longest.line.bridged]
    assert len(bridged) >= 3
    assert np.linalg.norm(bridged - place(np.array([[160.0, 68.0]])), axis=1).max() < 10e-3

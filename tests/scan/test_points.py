"""Clouds of points become a surface that lies where the points are, faces the sensor, and nowhere else."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from helpers.point_files import colours_of, front, lzf, pcd, point_ply, xyz
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from breastrig.core.errors import BadScan, TooLarge
from breastrig.geometry.normals import face_normals, point_normals
from breastrig.scan.piece import Piece, PointCloud
from breastrig.scan.point_clouds import surface_from_points as surfaces
from breastrig.scan.point_clouds.pcd import pcd_points, unpack_lzf
from breastrig.scan.point_clouds.surface_from_points import FROM_POINTS, surface_from_points
from breastrig.scan.read import read_scan
from breastrig.scan.stored_scan import STORED, write_stored

pytestmark = pytest.mark.long

POINTS, NORMALS = front(0.006)
FILES = {
    "pcd as text": pcd(POINTS, "ascii"),
    "pcd": pcd(POINTS, "binary"),
    "packed pcd": pcd(POINTS, "binary_compressed"),
    "ply": point_ply(POINTS),
    "ply with normals": point_ply(POINTS, NORMALS),
    "xyz": xyz(POINTS),
    "xyz with commas": xyz(POINTS, "xyz rgb", ","),
    "pts": xyz(POINTS, "xyz intensity rgb"),
    "obj": b"".join(
        b"v %.6f %.6f %.6f %.4f %.4f %.4f\n" % (*place, *colour)
        for place, colour in zip(POINTS, colours_of(POINTS) / 255.0, strict=True)
    ),
}


@pytest.mark.parametrize("kind", FILES)
def test_a_cloud_of_points_in_any_file_becomes_a_coloured_surface_through_them(kind: str) -> None:
    scan = read_scan(FILES[kind])
    assert scan.from_points
    assert scan.notes == (FROM_POINTS,)
    assert scan.unit == "m"
    distances, who = cKDTree(POINTS).query(scan.vertices)
    assert distances.max() <= 0.015
    heights = np.abs(np.einsum("vi,vi->v", scan.vertices - POINTS[who], NORMALS[who]))
    assert np.quantile(heights, 0.99) < 0.0012  # the curve between neighbours of 6 mm is 0.1 mm high
    assert cKDTree(scan.vertices).query(POINTS)[0].max() < 0.006
    assert np.abs(scan.colours.astype(float) - colours_of(POINTS)[who]).mean() < 3.0


@pytest.mark.parametrize(("hole", "is_open"), [(0.005, False), (0.016, True), (0.03, True)])
def test_a_small_gap_is_closed_and_one_of_fifteen_millimetres_stays_open(hole: float, is_open: bool) -> None:
    points, _ = front(0.0035, hole, height=0.15)
    piece = surface_from_points(PointCloud(points), 1.0)
    across = (piece.vertices[piece.faces][:, :, 1].min(axis=1) < 0.0) & (
        piece.vertices[piece.faces][:, :, 1].max(axis=1) > 0.0
    )
    assert bool(across.any()) == (not is_open)
    assert cKDTree(points).query(piece.vertices)[0].max() < 0.0075


def test_nothing_is_continued_beyond_the_border_by_more_than_the_points_are_apart() -> None:
    points, _ = front(0.0035, height=0.2)
    piece = surface_from_points(PointCloud(points), 1.0)
    assert piece.vertices[:, 1].min() > points[:, 1].min() - 0.0036
    assert piece.vertices[:, 1].max() < points[:, 1].max() + 0.0036


@pytest.mark.parametrize("given_normals", [True, False])
def test_the_triangles_face_the_side_that_was_seen(given_normals: bool) -> None:
    cloud = PointCloud(POINTS, 3.0 * NORMALS if given_normals else None)
    piece = surface_from_points(cloud, 1.0)
    centres = piece.vertices[piece.faces].mean(axis=1)
    outwards = NORMALS[cKDTree(POINTS).query(centres)[1]]
    assert np.einsum("fi,fi->f", face_normals(piece.vertices, piece.faces), outwards).min() > 0.0


def test_a_known_sensor_decides_the_side_where_the_shape_does_not() -> None:
    """A hollow that was seen from inside: its middle would say the other side."""
    sensor = np.array([0.0, 0.0, -1.0])
    assert (np.einsum("ni,ni->n", point_normals(POINTS), NORMALS) > 0.0).all()
    assert (np.einsum("ni,ni->n", point_normals(POINTS, sensor), NORMALS) < 0.0).all()
    cloud = pcd_points(pcd(POINTS, "binary", (0.0, 0.0, -1.0)))
    assert cloud.sensor is not None
    np.testing.assert_array_equal(cloud.sensor, sensor)


def test_noise_and_strays_do_not_tear_the_surface() -> None:
    rng = np.random.default_rng(3)
    points = front(0.002, height=0.2)[0]
    noisy = np.concatenate([points + rng.normal(0.0, 0.001, points.shape), rng.uniform(-1.0, 1.0, (200, 3))])
    piece = surface_from_points(PointCloud(noisy), 1.0)
    assert cKDTree(points).query(piece.vertices)[0].max() < 0.009
    assert (cKDTree(piece.vertices).query(points)[0] < 0.006).mean() > 0.999


@pytest.mark.parametrize(("scale", "unit"), [(1000.0, "mm"), (10.0, "dm")])
def test_the_unit_of_points_is_found_as_that_of_triangles(scale: float, unit: str) -> None:
    scan = read_scan(xyz(scale * POINTS))
    assert scan.unit == unit
    assert np.ptp(scan.vertices[:, 1]) == pytest.approx(np.ptp(POINTS[:, 1]), abs=0.012)


def test_what_was_made_from_points_says_so_when_it_is_read_again(tmp_path) -> None:
    write_stored(read_scan(FILES["pcd"]), tmp_path / "kept")
    assert read_scan(tmp_path / "kept", STORED).from_points


def test_points_too_far_apart_or_too_few_make_no_skin() -> None:
    with pytest.raises(BadScan, match="12 mm apart"):
        read_scan(xyz(front(0.012)[0]))
    with pytest.raises(BadScan, match="triangle mesh"):
        read_scan(xyz(POINTS[:300]))
    rng = np.random.default_rng(1)
    with pytest.raises(BadScan):
        read_scan(xyz(rng.uniform(-0.5, 0.5, (3000, 3)), "xyz"))


def test_gaussian_splats_are_not_taken_for_a_surface() -> None:
    data = point_ply(POINTS).replace(b"property uchar red", b"property uchar f_dc_0")
    with pytest.raises(BadScan, match="Gaussian splats"):
        read_scan(data)


def test_points_that_the_sensor_did_not_see_are_left_out() -> None:
    head, rows = FILES["pcd"].split(b"DATA binary\n")
    table = np.frombuffer(rows, "<f4").reshape(-1, 4).copy()
    table[::7, :3] = np.nan
    cloud = pcd_points(head + b"DATA binary\n" + table.tobytes())
    kept = np.arange(len(POINTS)) % 7 > 0
    np.testing.assert_array_equal(cloud.points, POINTS[kept].astype(np.float32))
    np.testing.assert_array_equal(cloud.colours, colours_of(POINTS)[kept])


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"POINTS ", b"POINTS 9"),
        (b"TYPE F", b"TYPE Q"),
        (b"SIZE 4 4 4 4", b"SIZE 4 4 4"),
        (b"COUNT 1 1 1 1", b"COUNT 1 1 1 99999999999999"),
        (b"FIELDS x y z", b"FIELDS x y w"),
        (b"POINTS ", b"POINTS -"),
        (b"DATA ", b"DATA un"),
    ],
)
@pytest.mark.parametrize("kind", ["pcd as text", "pcd", "packed pcd"])
def test_a_pcd_whose_header_is_wrong_is_refused(kind: str, old: bytes, new: bytes) -> None:
    with pytest.raises((BadScan, TooLarge)):
        read_scan(FILES[kind].replace(old, new, 1))


@given(st.binary(max_size=400), st.integers(1, 6))
def test_lzf_unpacks_what_was_packed(content: bytes, times: int) -> None:
    assert unpack_lzf(lzf(content * times), len(content * times)) == content * times


@pytest.mark.parametrize("packed", [b"\x20\x05", b"\xe0", b"\xff\xff", b"\x05ab", b"\x00"])
def test_lzf_that_repeats_nothing_or_ends_early_is_refused(packed: bytes) -> None:
    with pytest.raises((ValueError, IndexError)):
        unpack_lzf(packed, 100)


def test_lzf_never_unpacks_more_than_was_announced() -> None:
    bomb = b"\x00a" + b"\xe0\xff\x00" * 100_000
    with pytest.raises(ValueError, match="another size"):
        unpack_lzf(bomb, 1000)


def table(separator: str, rows: list[str] | None = None, head: str = "", decimal: str = ".", more: str = "") -> bytes:
    """The points as a table, with whole numbers of colours behind them unless other rows are given."""
    lines = [
        f"{separator}".join([*(f"{value:.5f}".replace(".", decimal) for value in place), *extra.split()])
        for place, extra in zip(POINTS, rows or [""] * len(POINTS), strict=True)
    ]
    return (head + "\n".join(lines) + "\n" + more).encode()


WHOLE = [" ".join(str(round(value)) for value in colour) for colour in colours_of(POINTS)]
SHARES = [" ".join(f"{value / 255.0:.4f}" for value in colour) for colour in colours_of(POINTS)]
BOTH = [" ".join([*(f"{n:.6f}" for n in normal), colour]) for normal, colour in zip(NORMALS, WHOLE, strict=True)]
INDEXED = "\n".join(
    f"{k + 1} {' '.join(f'{value:.5f}' for value in place)} {colour}"
    for k, (place, colour) in enumerate(zip(POINTS, WHOLE, strict=True))
).encode()
TABLES: dict[str, Callable[[], tuple[bytes, bool]]] = {
    "semicolons and decimal commas": lambda: (table(";", None, "", ","), False),
    "semicolons, decimal commas and colours": lambda: (table(";", WHOLE, "", ","), True),
    "spaces and decimal commas": lambda: (table(" ", WHOLE, "", ","), True),
    "tabs": lambda: (table("\t", WHOLE), True),
    "tabs and decimal commas": lambda: (table("\t", WHOLE, "", ","), True),
    "commas": lambda: (table(",", WHOLE), True),
    "commas and spaces": lambda: (table(", ", WHOLE), True),
    "a trailing separator": lambda: (table(";", WHOLE).replace(b"\n", b";\n"), True),
    "a head of words": lambda: (table(" ", WHOLE, "X Y Z R G B\n"), True),
    "a head with units": lambda: (table(";", WHOLE, "X [m];Y [m];Z [m];Red;Green;Blue\n", ","), True),
    "a head in a remark": lambda: (table(",", WHOLE, "//X,Y,Z,R,G,B\n"), True),
    "several lines of words": lambda: (table(" ", WHOLE, "# made by a scanner\nPoints of a body\nx y z r g b\n"), True),
    "a count": lambda: (table(" ", WHOLE, f"{len(POINTS)}\n"), True),
    "an index": lambda: (INDEXED, True),
    "an index with a head": lambda: (b"Index x y z red green blue\n" + INDEXED, True),
    "colours to 1": lambda: (table(" ", SHARES), True),
    "colours with an opacity": lambda: (table(" ", [f"{colour} 255" for colour in WHOLE]), True),
    "an intensity before colours": lambda: (table(" ", [f"{0.01 * k:.2f} {c}" for k, c in enumerate(WHOLE)]), True),
    "a normal and colours": lambda: (table(" ", BOTH), True),
    "Windows' line ends": lambda: (table(" ", WHOLE).replace(b"\n", b"\r\n"), True),
    "UTF-16": lambda: (table(";", WHOLE, "\ufeffX;Y;Z;R;G;B\n", ",").decode().encode("utf-16-le"), True),
    "a mark of UTF-8": lambda: (b"\xef\xbb\xbf" + table(" ", WHOLE), True),
}


@cache
def a_surface() -> Piece:
    """How it follows from the points is a question of other tests."""
    return surface_from_points(PointCloud(POINTS), 1.0)


@pytest.mark.parametrize("name", TABLES)
def test_a_table_of_points_is_read_however_a_program_writes_it(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    data, coloured = TABLES[name]()
    clouds: list[PointCloud] = []
    monkeypatch.setattr(surfaces, "surface_from_points", lambda cloud, metres: clouds.append(cloud) or a_surface())
    assert read_scan(data).from_points
    (cloud,) = clouds
    np.testing.assert_allclose(cloud.points, POINTS, rtol=0.0, atol=1e-5)
    assert (cloud.colours is not None) == coloured
    if cloud.colours is not None:
        assert np.abs(cloud.colours.astype(float) - colours_of(POINTS)).max() <= 1.0


@pytest.mark.parametrize(("kind", "most"), [("F", 1.0), ("F", 255.0), ("U", 255)])
def test_a_pcd_with_a_column_for_each_colour(kind: str, most: float) -> None:
    colours = colours_of(POINTS) / 255.0 * most
    rows = np.column_stack([POINTS, np.round(colours) if kind == "U" else colours])
    size = 4 if kind == "F" else 1
    head = (
        f"VERSION 0.7\nFIELDS x y z r g b\nSIZE 4 4 4 {size} {size} {size}\nTYPE F F F {kind} {kind} {kind}\n"
        f"COUNT 1 1 1 1 1 1\nWIDTH {len(rows)}\nHEIGHT 1\nPOINTS {len(rows)}\nDATA ascii\n"
    )
    cloud = pcd_points((head + "\n".join(" ".join(f"{n:.6g}" for n in row) for row in rows) + "\n").encode())
    assert np.abs(cloud.colours.astype(float) - colours_of(POINTS)).max() <= 1.0

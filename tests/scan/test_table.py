"""The table is cut away, and nothing of the body with it: where the truth is known, and where body and table touch."""

import numpy as np
import pytest
from helpers.surfaces import plane, sphere

from breastrig.core.assets import asset_folder
from breastrig.core.stances import AUTO
from breastrig.fitting.prepare_scan import PreparedScan, prepared
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import face_areas
from breastrig.scan.around.table import found_table
from breastrig.scan.clean import Surface, clean
from breastrig.scan.orient import propose_frame
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan
from breastrig_studies.virtual.bodies import read_bodies
from breastrig_studies.virtual.scan import Circumstances, scan_skin

pytestmark = pytest.mark.long

Mesh = tuple[np.ndarray, np.ndarray]


def scanned(vertices: np.ndarray, faces: np.ndarray) -> Surface:
    return clean(Scan(vertices, faces, "m", 1.0, "As asked for.", "0" * 64))


def turned(rng: np.random.Generator) -> np.ndarray:
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return np.asarray(turn * np.sign(np.linalg.det(turn)))


@pytest.fixture(scope="module")
def lying() -> tuple[Surface, ClosestPointSearch]:
    """The coarse simulated scan of a lying virtual patient on her table, turned at random, and her true skin."""
    bodies, rng = read_bodies(), np.random.default_rng(3)
    body = next(body for body in bodies.patients[3].bodies if body.stance == "supine")
    assert body.table is not None
    scan = scan_skin(body, bodies.faces, bodies.scanned, rng, Circumstances(voxel=0.008, every=4))
    turn = turned(rng)
    return scanned(scan.vertices @ turn.T, scan.faces), ClosestPointSearch(body.vertices @ turn.T, bodies.faces)


def example(stance: str) -> Surface:
    return clean(read_scan(asset_folder("example") / stance / "scan.ply", None, "auto", texture=False))


def areas_of(surface: Surface, kept: PreparedScan, truth: ClosestPointSearch) -> dict[str, float]:
    """m² of the scan and of what was kept of it: on the true skin (4 mm), and off it (12 mm)."""
    result = {}
    for name, vertices, faces in (
        ("whole", surface.vertices, surface.faces),
        ("kept", kept.target.vertices, kept.target.faces),
    ):
        away, areas = truth.query(vertices[faces].mean(axis=1)).distances, face_areas(vertices, faces)
        result[f"{name} skin"] = float(areas[away < 0.004].sum())
        result[f"{name} table"] = float(areas[away > 0.012].sum())
    return result


@pytest.mark.parametrize("stance", [AUTO, "supine"])
def test_all_of_the_table_is_cut_and_nothing_of_the_skin(
    lying: tuple[Surface, ClosestPointSearch], stance: str
) -> None:
    surface, truth = lying
    ready = prepared(surface, stance)
    found = areas_of(surface, ready, truth)
    assert found["whole table"] > 0.1
    assert found["kept table"] < 0.003 * found["whole table"]
    assert found["kept skin"] == pytest.approx(found["whole skin"], rel=1e-9)
    assert ready.table_triangles == len(surface.faces) - len(ready.target.faces)
    assert ready.notes[-1] == f"{ready.table_triangles} triangles of the table under the patient were left out."


def test_who_says_that_the_patient_stands_keeps_all_of_the_scan(lying: tuple[Surface, ClosestPointSearch]) -> None:
    assert prepared(lying[0], "standing").table_triangles == 0


@pytest.mark.parametrize("stance", [AUTO, "supine", "standing"])
def test_nothing_is_cut_where_there_is_no_table(stance: str) -> None:
    surface = example("standing")
    ready = prepared(surface, stance)
    assert ready.table_triangles == 0
    assert ready.notes == surface.notes
    np.testing.assert_array_equal(ready.target.faces, surface.faces)
    np.testing.assert_array_equal(ready.target.vertices, surface.vertices)


def lying_form(rng: np.random.Generator, sag: float = 0.0) -> tuple[Mesh, np.ndarray]:
    """A body that rises from its table without a gap, one surface with it, noise of 1 mm; and its (V,) true height.

    The table sags by `sag` m in the middle.
    """
    vertices, faces = plane(1.2, 200)
    x, y = vertices[:, 0], vertices[:, 1]
    inside = 1.0 - (x / 0.17) ** 2 - (y / 0.35) ** 2
    body = 0.22 * np.maximum(inside, 0.0) ** 0.3  # steep where it leaves the table
    table = sag * ((x / 0.6) ** 2 + (y / 0.6) ** 2 - 1.0)
    vertices = vertices + np.column_stack([np.zeros((len(x), 2)), body + table])
    return (vertices + 0.001 * rng.normal(size=vertices.shape), faces), body


@pytest.mark.parametrize("sag", [0.0, 0.004])
def test_skin_that_rests_on_the_table_stays(sag: float, rng: np.random.Generator) -> None:
    (vertices, faces), body = lying_form(rng, sag)
    turn = turned(rng)
    surface = Surface(vertices @ turn.T, faces, ())
    frame = propose_frame(surface.vertices, faces)
    assert frame.table is not None
    cut = found_table(surface.vertices, faces, *frame.table).triangles
    lowest = body[faces].min(axis=1)
    assert not cut[lowest > 0.012].any()  # of the body
    assert cut[body[faces].max(axis=1) == 0.0].mean() > 0.99  # of the table
    assert prepared(surface, AUTO).table_triangles >= np.count_nonzero(cut)


def test_what_lies_below_the_table_goes_unless_it_is_connected_with_the_body(rng: np.random.Generator) -> None:
    """The floor goes; an arm that reaches below the edge stays."""
    (vertices, faces), _ = lying_form(rng)
    arm, arm_faces = sphere(0.05, 2)
    arm = arm * [5.0, 1.0, 1.0] + np.array([0.0, 0.0, 0.12])
    arm[:, 2] -= 1.5 * np.maximum(arm[:, 0], 0.0)  # its tip is 0.25 m lower than its root
    floor, floor_faces = plane(0.25, 20)
    floor = floor + np.array([0.9, 0.0, -0.5])
    parts = [(vertices, faces), (arm, arm_faces), (floor, floor_faces)]
    starts = np.cumsum([0, *(len(each) for each, _ in parts)])
    joined = np.concatenate([each for each, _ in parts])
    triangles = np.concatenate([each + start for (_, each), start in zip(parts, starts, strict=False)])
    cut = found_table(joined, triangles, np.array([0.0, 0.0, 1.0]), 0.0).triangles
    of = np.repeat(np.arange(3), [len(each) for _, each in parts])
    assert arm[:, 2].min() < -0.1
    assert not cut[of == 1].any()
    assert cut[of == 2].all()


def test_a_plane_with_the_body_behind_it_is_no_table(rng: np.random.Generator) -> None:
    """The flattened front of a ball, as flat as any table."""
    vertices, faces = sphere(0.2, 4)
    vertices[:, 2] = np.minimum(vertices[:, 2], 0.17)
    assert not found_table(vertices, faces, np.array([0.0, 0.0, 1.0]), 0.17).triangles.any()


def test_a_curved_front_is_no_table() -> None:
    vertices, faces = sphere(0.2, 4)
    front = faces[(vertices[faces][:, :, 2] > 0.16).all(axis=1)]
    assert not found_table(vertices, front, np.array([0.0, 0.0, 1.0]), 0.185).triangles.any()


def test_a_scan_that_is_nothing_but_a_table_is_left_as_it_is(rng: np.random.Generator) -> None:
    vertices, faces = plane(1.0, 40)
    surface = Surface(vertices + 0.0005 * rng.normal(size=vertices.shape), faces, ())
    assert prepared(surface, "supine").table_triangles == 0


def test_the_packaged_example_lies_on_a_table() -> None:
    surface = example("supine")
    ready = prepared(surface, AUTO)
    assert ready.frame.stance == "supine"
    assert 0.3 < ready.table_triangles / len(surface.faces) < 0.45


@pytest.mark.parametrize(("tilt", "is_table"), [(25.0, True), (60.0, False), (75.0, False)])
def test_skin_that_leaves_the_table_steeply_is_kept_down_to_the_table(tilt: float, is_table: bool) -> None:
    """A flank that rises from the table: its triangles within the scanner's noise of the plane are not table."""
    up = np.arange(1, 60) * 0.002 / np.sin(np.radians(tilt))
    along = np.concatenate([np.arange(0.0, 0.6001, 0.006), 0.6 + up * np.cos(np.radians(tilt))])
    height = np.concatenate([np.zeros(len(along) - len(up)), up * np.sin(np.radians(tilt))])
    across = np.arange(0.0, 0.3, 0.006)
    wide, far = len(across), len(along)
    vertices = np.stack([np.repeat(across, far), np.tile(along, wide), np.tile(height, wide)], axis=1)
    corner = (np.arange(wide - 1)[:, None] * far + np.arange(far - 1)).ravel()
    faces = np.concatenate(
        [np.stack([corner, corner + far, corner + far + 1], 1), np.stack([corner, corner + far + 1, corner + 1], 1)]
    )
    found = found_table(vertices, faces, np.array([0.0, 0.0, 1.0]), 0.001)
    heights = vertices[faces, 2]
    assert found.triangles[heights.max(axis=1) == 0.0].mean() > 0.98
    near = (heights.min(axis=1) > 0.0015) & (heights.max(axis=1) < 0.0055)  # within the least band
    assert near.any()
    assert (found.triangles[near] == is_table).all()
    assert not found.triangles[heights.min(axis=1) > 0.013].any()

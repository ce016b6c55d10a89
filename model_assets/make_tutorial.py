"""Makes what the tutorial needs beside the example patient's two scans: lines of a pen, and an MRI's label map.

    python model_assets/make_tutorial.py [--pictures FOLDER]

writes model_assets/example/marked/{scan.zip, landmarks.json, case.json}, the standing body with lines drawn on the skin
(OBJ with a picture), and model_assets/example/mri/{scan.nii.gz, landmarks.json, case.json}, the prone body as a label
map with two lesions under the drawn tumour (1 body, 2 and 3 lesions). A minute; needs what make_example.py needs, and
`pip install -e ".[mri]"`. Same numbers in, same bytes out on one machine.
"""

import argparse
import gzip
import tomllib
from dataclasses import replace
from pathlib import Path

import nibabel
import numpy as np
from make_example import BEHIND, CAMERA, HERE, SEED, Stance, both_stances, write_json
from scipy.spatial import cKDTree
from sheets import contact_sheet, save_png
from steps.source import fetch, read_source
from virtual_patient.body import Body, virtual_patient
from virtual_patient.hanging import hanging

from breastrig.core.notice import LIMITS_OF_USE
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.rays import RayCaster
from breastrig.rendering.picture import Layer, Scene, camera
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.depth_camera import take
from breastrig_studies.virtual.depth_fusion import fuse, without_small_pieces
from breastrig_studies.virtual.painted.albedo import Albedo
from breastrig_studies.virtual.painted.atlas import make_atlas
from breastrig_studies.virtual.painted.files import scan_zip
from breastrig_studies.virtual.painted.marks import Marks, Skin, draw_marks
from breastrig_studies.virtual.painted.photograph import photograph
from breastrig_studies.virtual.painted.tones import draw_palette
from breastrig_studies.virtual.scan import SMALLEST_PIECE, SimulatedScan
from breastrig_studies.virtual.warped.prone import SHOWN

Array = np.ndarray

PEN_SEED = 20_261_147  # one whose tumour lies over the left breast and whose lines are whole
DRAWN = ("midline", "meridian_L", "meridian_R", "imf_L", "imf_R", "tumour")  # of draw_marks; others run onto an arm
VOXEL = 0.0075  # m, of the surface: lines are in the picture, so that it may be coarser than the other scans'
TEXTURE = 1536  # texels a side: 0.9 mm on the skin
TONE, INKS = 2, ("violet", "violet")
SIZES = np.array([2.5, 2.5, 2.5])  # mm, of the label map's voxels
SCAN_OF_MRI = (
    -0.17,
    0.17,
    -0.03,
    0.02,
    -0.02,
    0.02,
)  # m: right, left, below the folds, above the notch, behind, before
LESIONS = ((0.0, 0.022, 0.008), (0.020, 0.034, 0.005))  # m: towards the middle from the tumour, deep, radius
ARM = 0.2  # share of the arms from which on an MRI shows no skin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=HERE / "example")
    parser.add_argument("--pictures", type=Path, help="folder for pictures of both bodies")
    options = parser.parse_args()
    recipe = tomllib.loads((HERE / "recipe.toml").read_text("utf-8"))["source"]
    wheel = fetch(recipe["wheel"], recipe["requirement"], recipe["sha256"], HERE / "sources")
    body = virtual_patient(read_source(wheel))
    standing, _ = both_stances(body, np.random.default_rng(SEED))
    marks = write_marked(options.out / "marked", standing, options.pictures)
    write_mri(options.out / "mri", body, standing, marks, options.pictures)


def write_marked(folder: Path, stance: Stance, pictures: Path | None) -> Marks:
    """The scan with a picture, in mm, and the lines that were drawn on the skin."""
    random = np.random.default_rng(PEN_SEED)
    truth, landmarks = stance.truth, stance.landmarks
    body = VirtualBody("standing", truth.vertices, landmarks, None)
    skin = Skin(body, truth.faces)
    marks = draw_marks(body, truth.faces, random, "lumpectomy", {}, INKS)
    marks = replace(marks, ink=tuple(stroke for stroke in marks.ink if stroke.name in DRAWN))
    albedo = Albedo(skin, draw_palette(TONE, random), marks, random, even=True)
    images = take(truth.vertices, truth.faces, stance.views, CAMERA, random, stance.blind_spots)
    vertices, faces = fuse(images, stance.low, stance.high, VOXEL)
    nearest = ClosestPointSearch(truth.vertices, truth.faces).query(vertices)
    kept = np.einsum("mc,mc->m", nearest.barycentric, truth.kept[truth.faces[nearest.faces]])
    vertices, faces, used = without_small_pieces(vertices, faces[(kept > 0.5)[faces].all(axis=1)], SMALLEST_PIECE)
    scan = SimulatedScan(vertices, faces, float(nearest.distances[used].mean()))
    atlas = make_atlas(vertices, faces, TEXTURE)
    picture = photograph(albedo, truth.vertices, body, truth.faces, scan, atlas, random)
    placed = 1e3 * (vertices @ stance.rotation.T + stance.translation)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scan.zip").write_bytes(scan_zip(placed, faces, atlas, picture.jpeg, decimals=1))
    in_scan = {name: 1e3 * (stance.rotation @ at + stance.translation) for name, at in sorted(landmarks.items())}
    write_known(folder, "Example patient, lines of a pen", "standing", "+Y", in_scan, placed)
    print(f"marked: {len(vertices)} vertices, texels of {1e3 * atlas.texel:.2f} mm, {[s.name for s in marks.ink]}")
    if pictures:
        shown = albedo.lab(skin.vertices)[:, :1] / 100.0
        draw(pictures / "marked.png", truth.vertices, truth.faces, np.repeat(shown, 3, axis=1))
    return marks


def write_mri(folder: Path, body: Body, stance: Stance, marks: Marks, pictures: Path | None) -> None:
    """The label map of the same woman, prone, in LPS and mm; no arms, as they are overhead."""
    standing, faces = stance.truth.vertices, stance.truth.faces
    prone, wall = hanging(standing, faces, body.breasts)
    tumour = next(stroke for stroke in marks.ink if stroke.name == "tumour")
    middle = tumour.points.positions(standing, faces).mean(axis=0)
    side = np.sign(middle[0])
    centres = []
    for inwards, deep, _ in LESIONS:
        vertex = int(np.linalg.norm(standing - middle + [side * inwards, 0.0, 0.0], axis=1).argmin())
        towards = wall[vertex] - prone[vertex]
        centres.append(prone[vertex] + deep * towards / np.linalg.norm(towards))
    at = {name: ClosestPointSearch(standing, faces).query(place[None]) for name, place in stance.landmarks.items()}
    landmarks = {name: found.barycentric[0] @ prone[faces[found.faces[0]]] for name, found in at.items()}
    right, left, below, above, behind, before = SCAN_OF_MRI
    folds = min(landmarks[f"inframammary_fold_{side}"][1] for side in "LR")
    low = np.array([right, folds + below, BEHIND + behind])
    high = np.array([left, landmarks["suprasternal_notch"][1] + above, prone[:, 2].max() + before])
    counts = np.ceil(1e3 * (high - low) / SIZES).astype(int)
    x, y, z = (low[k] + 1e-3 * SIZES[k] * np.arange(counts[k]) for k in range(3))
    trunk = faces[(body.arms[faces] < ARM).all(axis=1)]
    flat = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    origins = np.column_stack([flat, np.full(len(flat), high[2] + 0.1)])
    _, distance = RayCaster(prone, trunk).first_hits(origins, np.tile([0.0, 0.0, -1.0], (len(flat), 1)))
    front = (high[2] + 0.1 - distance).reshape(len(x), len(y), 1)
    labels = (z < np.where(np.isfinite(front), front, -np.inf)).astype(np.uint8)  # (I, J, K): left, head, front
    for number, (centre, (_, _, radius)) in enumerate(zip(centres, LESIONS, strict=True), start=2):
        away = [(axis - middle) ** 2 for axis, middle in zip((x, y, z), centre, strict=True)]
        labels[away[0][:, None, None] + away[1][:, None] + away[2] < radius**2] = number
    to_ras = np.array([[-SIZES[0], 0, 0, 0], [0, 0, SIZES[2], 0], [0, SIZES[1], 0, 0], [0, 0, 0, 1.0]])
    to_ras[:3, 3] = 1e3 * low[[0, 2, 1]] * [-1.0, 1.0, 1.0]
    image = nibabel.Nifti1Image(labels, to_ras)
    image.header.set_xyzt_units("mm")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scan.nii.gz").write_bytes(gzip.compress(image.to_bytes(), 9, mtime=0))
    in_lps = {name: 1e3 * landmarks[name][[0, 2, 1]] * [1.0, -1.0, 1.0] for name in sorted(SHOWN)}
    skin = 1e3 * prone[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    write_known(folder, "Example patient, MRI", "prone", "-P", in_lps, skin)
    for number, centre in enumerate(centres, start=1):
        depth = np.linalg.norm(prone - centre, axis=1).min()
        print(f"mri: lesion {number} at {np.round(1e3 * centre, 1)} mm, {1e3 * depth:.1f} mm deep")
    print(f"mri: {labels.shape} voxels, nipples {[np.round(1e3 * landmarks[f'nipple_{side}']) for side in 'LR']}")
    if pictures:
        draw(pictures / "mri.png", prone, trunk, None)


def write_known(folder: Path, label: str, stance: str, vertical: str, landmarks: dict[str, Array], skin: Array) -> None:
    """landmarks.json and case.json, in mm of the scan's frame."""
    gaps, _ = cKDTree(skin).query(np.array(list(landmarks.values())))
    write_json(
        folder / "landmarks.json",
        {
            "schema": "breastrig/landmarks@1",
            "unit": "mm",
            "landmarks": {name: [round(float(value), 2) for value in place] for name, place in landmarks.items()},
        },
    )
    write_json(
        folder / "case.json",
        {
            "name": folder.name,
            "label": label,
            "stance": stance,
            "unit": "mm",
            "patient": "Virtual: an adult woman computed from MakeHuman's CC0 data, as the other scans here.",
            "license": "CC0-1.0",
            "notice": LIMITS_OF_USE,
            "landmark_gap_mm": {name: round(float(gap), 1) for name, gap in zip(landmarks, gaps, strict=True)},
        },
    )


def draw(file: Path, vertices: Array, faces: Array, colours: Array | None) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    scene = Scene([Layer(vertices, faces) if colours is None else Layer(vertices, faces, colours)])
    views = ("front", "three_quarter", "left")
    save_png(contact_sheet([scene.render(camera(view, vertices), (560, 560)) for view in views], 3, list(views)), file)


if __name__ == "__main__":
    main()

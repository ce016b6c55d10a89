"""Prone warped bodies, scanned as a breast MRI shows them: the front of the chest, breasts hanging, no arms.

A patient who was computed prone (a donor, PATIENT/prone/truth.ply) gives the motion of the skin from standing; it is
transferred to a warped standing body by a thin-plate spline through the landmarks. Real breasts hang farther (60 to 150
mm) than the donors', so the motion to the front is enlarged; upper poles, trunks and crops differ from body to body.
Bodies of each half have donors of that half.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.interpolate import RBFInterpolator
from scipy.sparse import csr_array, diags_array

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadInput
from breastrig.core.version import __version__
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.half_edges import neighbours
from breastrig.geometry.normals import vertex_normals
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.scan.clean import compact
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.case_files import moved, placed_at_random, write_json, write_known, write_ply
from breastrig_studies.virtual.depth_fusion import without_small_pieces
from breastrig_studies.virtual.scan import SMALLEST_PIECE, SimulatedScan
from breastrig_studies.virtual.warped.body import WarpedBody, draw_body, is_sound_hanging
from breastrig_studies.virtual.warped.make import Half, names_of, source_of
from breastrig_studies.virtual.warped.sources import HALF_OF_PATIENT, Source, read_body, read_sources

SEED = 20_261_126
VERSION = 1  # of the maps and ranges; another one makes all bodies anew
SHOWN = (  # of an MRI's landmarks; of others its field of view shows nothing
    "suprasternal_notch",
    "mid_sternum",
    "xiphoid",
    "nipple_L",
    "nipple_R",
    "inframammary_fold_L",
    "inframammary_fold_R",
)
UPPER_POLE = 0.4  # of the way from nipple to the middle of the collar bone
POLE_REACH = 0.035  # m, standard deviation around it
LPS = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # of body coordinates
TIGHT = 0.3  # share of the scans
TRIES = 12
ARM, ASIDE = 0.2, 0.03  # share of the arms and m beyond the shoulders' tips that a scan shows
ROUNDS = 20  # of averaging what is carried over neighbours: some 30 mm


Places = dict[str, Array]  # (3,) m by name


@dataclass(frozen=True, eq=False)
class Donor:
    """A patient's skin standing and its motion to prone, in body coordinates (m)."""

    name: str
    standing: Array  # (V, 3)
    faces: Integers  # (F, 3)
    motion: Array  # (V, 3)
    landmarks: Places  # standing


@dataclass(frozen=True)
class ProneNumbers:
    """Random parameters of one prone body; lengths in m."""

    forwards: float  # times the donor's motion to the front, and the share of it along the body and sideways
    along: float
    sideways: float
    poles: tuple[float, float]  # fuller (or hollow) upper poles, left and right
    wider: float  # times, the whole trunk
    deeper: float
    tight: bool  # the field of view
    above: float  # the notch, where the scan ends
    below: float  # the fold
    behind: float  # the shoulders' tips
    noise: float
    turned: bool  # in any direction, not along the axes of the DICOM patient frame


def draw_numbers(random: np.random.Generator) -> ProneNumbers:
    tight = bool(random.random() < TIGHT)
    low, high = ((-0.06, -0.02), (0.005, 0.02)) if tight else ((-0.02, 0.03), (0.02, 0.06))
    pole, apart = random.normal(0.0, 0.010), random.normal(0.0, 0.003)
    return ProneNumbers(
        forwards=float(random.uniform(1.0, 3.2)),
        along=float(random.uniform(0.7, 1.4)),
        sideways=float(random.uniform(0.3, 1.4)),
        poles=(float(pole + apart), float(pole - apart)),
        wider=float(random.uniform(0.85, 1.2)),
        deeper=float(random.uniform(0.8, 1.2)),
        tight=tight,
        above=float(random.uniform(*low)),
        below=float(random.uniform(*high)),
        behind=float(random.uniform(-0.03, 0.0) if tight else random.uniform(-0.01, 0.04)),
        noise=float(random.uniform(0.0003, 0.001)),
        turned=bool(random.random() < 0.5),
    )


def read_donors(data: Path) -> dict[str, Donor]:
    """Donors by name: the patients of the folder with prone/truth.ply; BadInput when a half would have none."""
    donors = {}
    for name in HALF_OF_PATIENT:
        if (data / name / "prone" / "truth.ply").is_file():
            standing, faces, landmarks = read_body(data / name / "standing")
            prone, same, _ = read_body(data / name / "prone")
            if not np.array_equal(faces, same):
                raise BadInput(f"{data / name}: prone/truth.ply has other triangles than the standing one.")
            donors[name] = Donor(name, standing, faces, prone - standing, landmarks)
    if {HALF_OF_PATIENT[name] for name in donors} != {*HALF_OF_PATIENT.values()}:
        raise BadInput(f"{data} has no PATIENT/prone/truth.ply for both halves.")
    return donors


def carried(values: Array, skin: Array, faces: Integers, at: Places, body: VirtualBody, body_faces: Integers) -> Array:
    """(V, ...) the (W, ...) values on another skin, at the standing body's places; `at`: its landmarks."""
    names = sorted(at.keys() & body.landmarks.keys())
    own, other = (np.array([of[name] for name in names]) for of in (body.landmarks, at))
    there = RBFInterpolator(own, other)(body.vertices)
    near = ClosestPointSearch(skin, faces).query(there)
    found = np.einsum("mc,mc...->m...", near.barycentric, values[faces[near.faces]])
    mean = csr_array(0.5 * (diags_array(np.ones(len(found))) + neighbours(body_faces, len(found))))
    for _ in range(ROUNDS):  # between arm and trunk the nearest skin jumps
        found = mean @ found
    return np.asarray(found)


def arm_share(rig: Rig, body: WarpedBody) -> Array:
    """(V,) 0 on the trunk to 1 on the arms, as the rig's bones share its skin."""
    at = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))
    arms = [index for index, name in enumerate(rig.bone_names) if name.startswith("upper_arm")]
    return carried(rig.skin_weights[:, arms].sum(axis=1), rig.template, rig.faces, at, body.standing, body.source.faces)


def prone_skin(body: WarpedBody, donor: Donor, numbers: ProneNumbers, arms: Array) -> Array:
    """(V, 3) m: the standing skin of a warped body, hanging as the donor's does; (V,) `arms`: see arm_share."""
    standing = body.standing.vertices
    motion = carried(donor.motion, donor.standing, donor.faces, donor.landmarks, body.standing, body.source.faces)
    motion *= (1.0 - arms)[:, None]
    skin = standing + motion * [numbers.sideways, numbers.along, numbers.forwards]
    skin = skin * [numbers.wider, 1.0, numbers.deeper]
    hanging = body.source.landmarks(skin)
    for side, fuller in zip("LR", numbers.poles, strict=True):
        nipple, clavicle = hanging[f"nipple_{side}"], hanging[f"midclavicle_{side}"]
        away = (skin - nipple - UPPER_POLE * (clavicle - nipple))[:, :2]
        skin[:, 2] += fuller * np.exp(-0.5 * (away**2).sum(axis=1) / POLE_REACH**2) * (skin[:, 2] > clavicle[2] - 0.03)
    return skin


@dataclass(frozen=True, eq=False)
class Hanging:
    """A prone body and what it was made of."""

    prone: VirtualBody
    body: WarpedBody
    arms: Array  # (V,) share of its arms
    donor: Donor
    numbers: ProneNumbers


def draw_prone(
    source: Source, donors: Sequence[Donor], rig: Rig, random: np.random.Generator, *, resized: bool = True
) -> Hanging:
    """A body with both breasts whose skin does not fold on itself; `resized`: its trunk is not the standing one's."""
    for _ in range(TRIES):
        body = draw_body(source, random)
        own = [donor for donor in donors if donor.name == source.name] or donors
        donor, numbers = own[int(random.integers(len(own)))], draw_numbers(random)
        numbers = numbers if resized else replace(numbers, wider=1.0, deeper=1.0)
        if body.numbers.mastectomy:
            continue
        arms = arm_share(rig, body)
        skin = prone_skin(body, donor, numbers, arms)
        prone = VirtualBody("prone", skin, source.landmarks(skin), None)
        seen = source.faces[field_of_view(prone, source.faces, arms, numbers)[source.faces].all(axis=1)]
        if is_sound_hanging(body.standing.vertices, skin, seen):
            return Hanging(prone, body, arms, donor, numbers)
    raise RuntimeError(f"No sound prone body of {source.name} in {TRIES} tries.")


def field_of_view(body: VirtualBody, skin: Integers, arms: Array, numbers: ProneNumbers) -> Booleans:
    """(V,) what the MRI's segmentation keeps; arms: (V,) 0 on the trunk to 1."""
    at, vertices = body.landmarks, body.vertices
    top = at["suprasternal_notch"][1] + numbers.above
    bottom = min(at["inframammary_fold_L"][1], at["inframammary_fold_R"][1]) - numbers.below
    behind = 0.5 * (at["acromion_L"][2] + at["acromion_R"][2]) - numbers.behind
    aside = np.abs(vertices[:, 0] - at["xiphoid"][0]) < 0.5 * (at["acromion_L"][0] - at["acromion_R"][0]) + ASIDE
    facing = (vertex_normals(vertices, skin)[:, 2] > -0.5) | (vertices[:, 2] > at["mid_sternum"][2])  # or hanging
    inside = (vertices[:, 1] < top) & (vertices[:, 1] > bottom) & (vertices[:, 2] > behind)
    return np.asarray(inside & facing & aside & (arms < ARM))


def mri_scan(
    body: VirtualBody, skin: Integers, arms: Array, numbers: ProneNumbers, random: np.random.Generator
) -> SimulatedScan:
    """The scan as the isosurface of a segmented MRI, in body coordinates."""
    kept = field_of_view(body, skin, arms, numbers)
    vertices, faces = compact(body.vertices, skin[kept[skin].all(axis=1)])
    vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    vertices, faces, _ = without_small_pieces(vertices, faces, SMALLEST_PIECE)
    pieces = trimesh.Trimesh(vertices, faces, process=False).split(only_watertight=False)
    largest = max(pieces, key=lambda piece: piece.area)
    vertices, faces = np.asarray(largest.vertices), np.asarray(largest.faces, dtype=np.int64)
    off = random.normal(0.0, numbers.noise, len(vertices))
    normals = vertex_normals(vertices, faces)
    return SimulatedScan(vertices + off[:, None] * normals, faces, float(np.abs(off).mean()))


def make_prone(
    folder: Path,
    progress: Callable[[str], None],
    data: Path,
    bodies: int,
    seed: int = SEED,
    half: Half = "both",
) -> None:
    """NAME/prone/{scan.ply, landmarks.json, case.json, truth.ply} and NAME/patient.json of the first `bodies` bodies.

    `data`: a folder of cases with prone patients; the bodies of other seeds are others.
    """
    sources, donors, rig = read_sources(data), read_donors(data), read_rig(default_rig_path())
    for name, number in names_of(bodies, half, "prone").items():
        random = np.random.default_rng((seed, number))
        source = source_of(sources, number, random)
        own = [donor for donor in donors.values() if HALF_OF_PATIENT[donor.name] == source.half]
        made_by = {"breastrig": __version__, "prone": VERSION, "seed": [seed, number], "source": source.sha256}
        place = folder / name
        if _made_by(place) == made_by:
            continue
        found = draw_prone(source, own, rig, random)
        drawn: dict[str, Any] = {"source": source.name, "donor": found.donor.name, "numbers": asdict(found.numbers)}
        about = {"virtual": True, "origin": source.origin, "licence": source.licence, "family": source.family}
        count = write_prone(place, found.prone, source.faces, found.arms, found.numbers, drawn, random)
        write_json(place / "patient.json", about | drawn | {"made_by": made_by})
        progress(f"{place.name}: {count} triangles")


def write_prone(
    place: Path,
    prone: VirtualBody,
    skin: Integers,
    arms: Array,
    numbers: ProneNumbers,
    drawn: dict[str, Any],
    random: np.random.Generator,
) -> int:
    """Writes place/prone/{scan.ply, landmarks.json, case.json, truth.ply}; how many triangles the scan has."""
    scan = mri_scan(prone, skin, arms, numbers, random)
    placed = placed_at_random("mm", random)
    if not numbers.turned:
        placed[:3, :3] = 1e3 * LPS
    (place / "prone").mkdir(parents=True, exist_ok=True)
    write_ply(place / "prone" / "scan.ply", moved(scan.vertices, placed), scan.faces)
    shown = VirtualBody("prone", prone.vertices, {name: prone.landmarks[name] for name in SHOWN}, None)
    write_known(place / "prone", shown, skin, scan, "mm", placed, drawn)
    return len(scan.faces)


def _made_by(place: Path) -> object:
    try:
        return json.loads((place / "patient.json").read_text("utf-8")).get("made_by")
    except (OSError, ValueError, AttributeError):
        return None

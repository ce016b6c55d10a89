"""Makes bodies whose chest wall, tumours and motion to supine and prone are known, as cases of `breastrig evaluate`.

python -m breastrig_studies.sliding.make FOLDER DATA

Apart from the cohort of `gravity.json`: other shapes (warped ones, of DATA's patients and the stored cohort), another
wall (a sheet through the skin around the breasts, 9 to 26 mm under it, that goes up with the arm), cubes in which the
surfaces lie embedded for tetrahedra, other laws for tissue and skin, another solver, and breasts that slide on the
wall. Weak: the drawn body is without stress where it stands, arms do not move, nothing touches (the fold under a breast
is glued within a cell), a trunk is as standing, one mixture of fat and gland, no ligaments; hand-set stiffness.

PATIENT/STANCE/wall.ply has the wall in the scan's frame and unit, PATIENT/volume.npz the cubes and their nodes by
stance in body coordinates (m). Body n is for development, validation or test by n % 3; no source of a development body
is one of validation. The same bytes each time on one machine; bodies that are there stay.
"""

import json
import sys
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.units import METRES_PER_UNIT
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig_studies.arguments import arguments
from breastrig_studies.sliding.body import Drawn, SlidingBody, drawn, solved
from breastrig_studies.sliding.lattice import NotAtRest
from breastrig_studies.sliding.wall import drawn_wall, footprint
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.case_files import UNITS, moved, write_case, write_json, write_ply
from breastrig_studies.virtual.warped.body import draw_body
from breastrig_studies.virtual.warped.captures import scan_captured
from breastrig_studies.virtual.warped.prone import arm_share, draw_numbers, write_prone
from breastrig_studies.virtual.warped.sources import DEVELOPMENT, VALIDATION, Source, read_sources

SEED = 20_261_128
BODIES = 14
GROUPS = (DEVELOPMENT, VALIDATION, "test")
STIFFER, TRIES = 1.5, 5
ON_TABLE = 0.004  # m that the table presses into the back


def main(folder: Path, data: Path, bodies: int = BODIES) -> None:
    """Writes the first bodies; those that do not come to rest, however stiff, are left out."""
    rig, sources = read_rig(default_rig_path()), read_sources(data)
    for number in range(bodies):
        place = folder / f"sliding_{number:03d}_{GROUPS[number % 3]}"
        if not (place / "patient.json").is_file():
            write_body(place, rig, sources, number)
            sys.stdout.write(f"{place.name}\n")
            sys.stdout.flush()


def source_of(sources: tuple[Source, ...], number: int, random: np.random.Generator) -> Source:
    """Every other one of a group from an independent source, where there is one."""
    own = [source for source in sources if source.half == GROUPS[number % 3]] or list(sources)
    family = ("independent", "makehuman")[number // 3 % 2]
    fitting = [source for source in own if source.family == family] or own
    return fitting[int(random.integers(len(fitting)))]


def write_body(place: Path, rig: Rig, sources: tuple[Source, ...], number: int) -> None:
    """PATIENT's files; patient.json last."""
    random = np.random.default_rng((SEED, number))
    source = source_of(sources, number, random)
    warped = draw_body(source, random)
    while warped.numbers.mastectomy:
        warped = draw_body(source, random)
    body, arms = warped.standing, arm_share(rig, warped)
    breasts = footprint(body, source.faces)
    wall, tissue = drawn_wall(body, source.faces, breasts, arms, random), drawn(random)
    shape = Drawn(body, source.faces, arms, breasts, wall)
    for _ in range(TRIES):
        with suppress(NotAtRest):
            found = solved(shape, tissue, np.random.default_rng((SEED, number, 1)))
            break
        tissue = replace(tissue, fat=STIFFER * tissue.fat, skin=STIFFER * tissue.skin)
    else:
        sys.stdout.write(f"{place.name} does not come to rest\n")
        return
    about: dict[str, object] = {
        "source": source.name,
        "family": source.family,
        "group": GROUPS[number % 3],
        "tissue": asdict(tissue),
    }
    _write_scans(place, source, arms, found, about, number)
    _write_inside(place, found)
    write_json(place / "patient.json", {"virtual": True, "origin": source.origin, "licence": source.licence} | about)


def _write_scans(
    place: Path, source: Source, arms: Array, found: SlidingBody, about: dict[str, object], number: int
) -> None:
    for k, stance in enumerate(("standing", "supine")):
        own, skin = np.random.default_rng((SEED, number, 2, k)), found.skin[stance]
        table = None if stance == "standing" else float(skin[arms < 0.05, 2].min()) + ON_TABLE
        body = VirtualBody(stance, skin, source.landmarks(skin), table)
        scan = scan_captured(body, source.faces, source.scanned, "ordinary", own)
        write_case(place / stance, body, source.faces, scan, UNITS[(number + k) % 2], own, dict(about))
    own = np.random.default_rng((SEED, number, 2, 2))
    skin, numbers = found.skin["prone"], replace(draw_numbers(own), wider=1.0, deeper=1.0)
    write_prone(
        place, VirtualBody("prone", skin, source.landmarks(skin), None), source.faces, arms, numbers, dict(about), own
    )


def _write_inside(place: Path, found: SlidingBody) -> None:
    """Walls, volume and tumours."""
    centers: dict[str, Array] = {}
    for stance in found.skin:
        case = json.loads((place / stance / "case.json").read_text("utf-8"))
        placed = np.array(case["body_mm_to_scan"]) @ np.diag([1e3, 1e3, 1e3, 1.0])
        write_ply(place / stance / "wall.ply", moved(found.wall[stance], placed), found.wall_faces)
        centers[stance] = 1e3 * METRES_PER_UNIT[case["unit"]] * moved(found.tumours[stance], placed)
    arrays: dict[str, Any] = {name: at.astype(np.float32) for name, at in found.nodes.items()}
    np.savez_compressed(place / "volume.npz", cells=found.cells.astype(np.int32), **arrays)
    tumours = [
        {
            "id": f"{'LR'[k >= len(found.radii) // 2]}{k % (len(found.radii) // 2) + 1}",
            "radius_mm": round(1e3 * float(radius), 1),
            "center": {stance: np.round(at[k], 3).tolist() for stance, at in centers.items()},
            "wall_mm": {"standing": round(1e3 * float(found.over_wall[k]), 1)},
        }
        for k, radius in enumerate(found.radii)
    ]
    write_json(place / "tumours.json", {"schema": "breastrig/lesions-truth@1", "unit": "mm", "tumours": tumours})


if __name__ == "__main__":
    given = arguments(__doc__, "FOLDER", "DATA")
    main(Path(given.folder), Path(given.data))

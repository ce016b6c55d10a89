"""Writes pairs of scans of virtual patients at two visits, each fitted apart, with the skin's true change.

python -m breastrig_studies.visits.pairs OUT HALF WOMEN [DATA]

OUT/HALF_NUMBER_STANCE/{before, same, volume, dent, weight}/{picked, alone}: folders of fits, and `truth.npz` beside
them: the true skin before (V, 3) and after, in body coordinates without posture, m, and the way into the scan's frame.
Pairs that are there stay.  DATA: a folder of patients who are warped too.
"""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import breastrig
from breastrig.core.arrays import Array
from breastrig.core.errors import BreastRigError
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig_studies.arguments import arguments
from breastrig_studies.studies.landmarks import CLICK_ERROR
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.case_files import moved, placed_at_random
from breastrig_studies.virtual.scan import SimulatedScan
from breastrig_studies.virtual.warped.body import draw_body
from breastrig_studies.virtual.warped.captures import scan_captured
from breastrig_studies.virtual.warped.make import names_of, source_of
from breastrig_studies.virtual.warped.sources import Source, read_sources
from breastrig_studies.visits.changed_body import at_visit, breasts, changed, draw_change

SEED = 20_261_129
CAPTURES = (("ordinary", 0.8), ("poor_sensor", 0.1), ("large_holes", 0.1))  # whole ones: parts are not compared
KINDS = {"standing": ("before", "same", "volume", "dent", "weight"), "supine": ("before", "same", "volume")}
SHOWN = 0.01  # m; a landmark farther from the scan cannot be picked


def write_pairs(out: Path, half: str, women: int, data: Path | None) -> None:
    """All pairs of the first `women` of a half."""
    sources = read_sources(data)
    for name, number in list(names_of(2 * women, half).items()):  # type: ignore[arg-type]
        random = np.random.default_rng((SEED, number))
        source = source_of(sources, number, random)
        body = draw_body(source, random, np.random.default_rng((SEED, number, 2)))
        for stance in (body.standing, body.supine):
            folder = out / f"{name}_{stance.stance}"
            for place, kind in enumerate(KINDS[stance.stance]):
                if not (folder / kind / "truth.npz").is_file():
                    own = np.random.default_rng((SEED, number, 3 + place + 10 * (stance.stance == "supine")))
                    _write(folder / kind, source, body.standing.vertices, stance, kind, own)


def _write(
    folder: Path, source: Source, standing: Array, body: VirtualBody, kind: str, random: np.random.Generator
) -> None:
    change = draw_change(kind, random)
    regions = {s: region for s, region in breasts(source, standing).items() if f"nipple_{s}" in body.landmarks}
    if change.side and change.side not in regions:
        change = replace(change, side=next(iter(regions)))
    skin = changed(source, body.vertices, regions, change, random)
    while skin is None:
        change = replace(change, ml=0.5 * change.ml, mm=0.5 * change.mm)
        skin = changed(source, body.vertices, regions, change, random)
    seen = at_visit(source, body, skin, random)
    capture = str(random.choice([name for name, _ in CAPTURES], p=[share for _, share in CAPTURES]))
    scan = scan_captured(seen, source.faces, source.scanned, capture, random)
    placed = placed_at_random("m", random)
    given = breastrig.Scan.from_arrays(moved(scan.vertices, placed), scan.faces, unit="m")
    for way, picks in (("picked", _picks(seen, scan, placed, random)), ("alone", {})):
        try:
            fit = breastrig.fit(given, landmarks=picks, stance=body.stance, drawing=None)
        except BreastRigError as error:
            sys.stderr.write(f"{folder} {way}: {error}" + "\n")
            continue
        fit.save(folder / way, force=True)
    known: dict[str, Any] = {
        "before": body.vertices.astype(np.float32),
        "after": skin.astype(np.float32),
        "seen": seen.vertices.astype(np.float32),
        "faces": source.faces.astype(np.int32),
        "placed": placed,
        "change": np.array([change.kind, change.side, f"{change.ml:.2f}", f"{change.mm:.2f}", capture]),
    }
    known |= {f"at_{name}": place for name, place in source.landmarks(skin).items() if name in body.landmarks}
    np.savez_compressed(folder / "truth.npz", **known)
    sys.stderr.write(f"{folder.parent.name} {change} {capture}\n")


def _picks(body: VirtualBody, scan: SimulatedScan, placed: Array, random: np.random.Generator) -> dict[str, Array]:
    """Places on the scan's skin CLICK_ERROR from the true ones, in the scan's frame."""
    search, found = ClosestPointSearch(scan.vertices, scan.faces), {}
    for name, place in body.landmarks.items():
        if search.query(place[None]).distances[0] > SHOWN:
            continue
        step = random.normal(size=3)
        for _ in range(4):
            step *= CLICK_ERROR / np.linalg.norm(step)
            step = search.query((place + step)[None]).points[0] - place
        found[name] = moved((place + step)[None], placed)[0]
    return found


if __name__ == "__main__":
    given = arguments(__doc__, "OUT", "HALF", "WOMEN", "[DATA]")
    data = None if given.data is None else Path(given.data)
    write_pairs(Path(given.out), given.half, int(given.women), data)

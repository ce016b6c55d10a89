"""Writes the family of warped bodies in the form that `breastrig evaluate` reads.

Body number n is of the half n % 2, so that wherever the work is broken off both halves are there; two of five of each
half come from independent sources where there are any, although those are rare.  Each body has its own generator.
"""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from breastrig.core.version import __version__
from breastrig_studies.virtual.case_files import UNITS, write_case, write_json
from breastrig_studies.virtual.warped.body import draw_body
from breastrig_studies.virtual.warped.captures import scan_captured
from breastrig_studies.virtual.warped.numbers import HANGING, draw_capture
from breastrig_studies.virtual.warped.sources import DEVELOPMENT, VALIDATION, Source, read_sources

SEED = 20_261_122
FAMILY_VERSION = 2  # of the maps, ranges and captures; another one makes all bodies anew
BODIES = 100
HANGS = 2  # beside the stances 0 and 1: the generator of what hangs
INDEPENDENT_IN_FIVE = (1, 3)  # of each five bodies of a half, these are of independent sources

Half = Literal["development", "validation", "both"]


def make_warped(
    folder: Path,
    progress: Callable[[str], None],
    data: Path | None = None,
    bodies: int = BODIES,
    seed: int = SEED,
    half: Half = "both",
    hanging: float = HANGING,
) -> None:
    """NAME/patient.json and NAME/STANCE/{scan.ply, landmarks.json, case.json, truth.ply} of the first `bodies` bodies.

    `data`: a folder of cases whose patients are sources too; `hanging`: the share of the bodies whose breasts hang.
    Of one `half` only its bodies are written, the same as among both.  The same bytes each time on one machine; bodies
    that are there already, of these sources, share and version, stay.  `progress` gets a sentence a scan.  BadInput
    when `data` does not fit.
    """
    sources = read_sources(data)
    for name, number in names_of(bodies, half).items():
        _write_body(folder / name, sources, number, (seed, hanging), progress)


def names_of(bodies: int, half: Half = "both", kind: Literal["warped", "prone"] = "warped") -> dict[str, int]:
    """The folders of the first bodies, as far as they are of the half, and their numbers."""
    halves = {number: (DEVELOPMENT, VALIDATION)[number % 2] for number in range(bodies)}
    return {f"{kind}_{number:03d}_{own}": number for number, own in halves.items() if half in ("both", own)}


def source_of(sources: Sequence[Source], number: int, random: np.random.Generator) -> Source:
    """A source of the body's half, an independent one for two bodies of five where there is such a source."""
    half = (DEVELOPMENT, VALIDATION)[number % 2]
    own = [source for source in sources if source.half == half]
    family = "independent" if (number // 2) % 5 in INDEPENDENT_IN_FIVE else "makehuman"
    fitting = [source for source in own if source.family == family] or own
    return fitting[int(random.integers(len(fitting)))]


def _write_body(
    folder: Path, sources: Sequence[Source], number: int, drawing: tuple[int, float], progress: Callable[[str], None]
) -> None:
    seed, share = drawing
    random = np.random.default_rng((seed, number))
    source = source_of(sources, number, random)
    made_by = {"breastrig": __version__, "warped": FAMILY_VERSION, "seed": [seed, number], "source": source.sha256}
    made_by |= {} if share == HANGING else {"hanging": share}
    if _is_there(folder, made_by):
        return
    capture = draw_capture(random)
    body = draw_body(source, random, np.random.default_rng((seed, number, HANGS)), share)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "patient.json").unlink(missing_ok=True)
    drawn: dict[str, Any] = {"source": source.name, "half": source.half, "family": source.family, "capture": capture}
    drawn["numbers"] = body.numbers.written()
    for stance, virtual in enumerate((body.standing, body.supine)):
        own = np.random.default_rng((seed, number, stance))
        scan = scan_captured(virtual, source.faces, source.scanned, capture, own)
        unit = UNITS[(number // 2 + stance) % len(UNITS)]
        write_case(folder / virtual.stance, virtual, source.faces, scan, unit, own, drawn)
        progress(f"{folder.name} {virtual.stance}: {len(scan.faces)} triangles")
    about = {"virtual": True, "origin": source.origin, "licence": source.licence, "lying": body.lying}
    write_json(folder / "patient.json", about | drawn | {"tries": body.tries, "made_by": made_by})


def _is_there(folder: Path, made_by: dict[str, Any]) -> bool:
    """patient.json is written last, so where it is and names the same maker, all is there."""
    try:
        about = json.loads((folder / "patient.json").read_text("utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(about, dict) and about.get("made_by") == made_by

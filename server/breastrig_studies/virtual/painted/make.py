"""Writes painted scans of the virtual cohort in the form of the textured data: bodies, marks and pictures of our own.

Every tone and ink appears; one nipple in eight is covered, one in eight reconstructed without pigment.  The same
number gives the same woman, marks and picture on one machine.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from breastrig.core.arrays import Integers
from breastrig.core.version import __version__
from breastrig_studies.virtual.bodies import Bodies, VirtualBody, read_bodies
from breastrig_studies.virtual.case_files import UNITS, write_json
from breastrig_studies.virtual.painted.albedo import Albedo
from breastrig_studies.virtual.painted.atlas import Atlas, make_atlas
from breastrig_studies.virtual.painted.files import strokes_elsewhere, write_painted_case, write_shapes
from breastrig_studies.virtual.painted.marks import COVERED, PLANS, RECONSTRUCTED, Marks, Skin, draw_marks
from breastrig_studies.virtual.painted.photograph import Photograph, photograph
from breastrig_studies.virtual.painted.tones import TONES, draw_palette
from breastrig_studies.virtual.scan import SimulatedScan, scan_body
from breastrig_studies.virtual.warped.make import Half
from breastrig_studies.virtual.warped.sources import DEVELOPMENT, VALIDATION

SEED = 20_261_123
PAINT_VERSION = 4  # of the formulas; another one paints all anew
TEXTURE = 1024  # texels a side


@dataclass(frozen=True, eq=False)
class PaintedSkin:
    """The skin and marks of one patient, in both stances."""

    skin: Skin
    marks: Marks
    albedo: Albedo  # with ink
    bare: Albedo  # without
    tone: int
    plan: str


@dataclass(frozen=True, eq=False)
class PaintedScan:
    """A scan with its picture, in body coordinates (m)."""

    body: VirtualBody
    scan: SimulatedScan
    atlas: Atlas
    picture: Photograph


def draw_skin(
    standing: VirtualBody,
    faces: Integers,
    random: np.random.Generator,
    tone: int | None = None,
    plan: str | None = None,
    states: dict[str, str] | None = None,
    inks: tuple[str, str] | None = None,
    even: bool = True,
) -> PaintedSkin:
    """A skin for a standing body; what is None is drawn: tone 1 to 6, plan, states of the nipples by side.

    `inks` are those of most lines and of the rest; lines that are not `even` fade here and there, as worn ones do.
    """
    drawn_tone, drawn_plan = int(random.choice(TONES)), str(random.choice(PLANS))
    tone, plan = drawn_tone if tone is None else tone, drawn_plan if plan is None else plan
    drawn = {side: str(random.choice(["", "", "", "", "", "", COVERED, RECONSTRUCTED])) for side in "LR"}
    states = {side: state for side, state in drawn.items() if state} if states is None else states
    palette = draw_palette(tone, random)
    skin = Skin(standing, faces)
    marks = draw_marks(standing, faces, random, plan, states, inks)
    seed = int(random.integers(2**31))
    without = Marks(marks.areolae, (), marks.scars, marks.veins, marks.spots)
    painted, bare = (Albedo(skin, palette, each, np.random.default_rng(seed), even) for each in (marks, without))
    return PaintedSkin(skin, marks, painted, bare, tone, plan)


def painted_scan(
    painted: PaintedSkin, body: VirtualBody, scan: SimulatedScan, random: np.random.Generator, side: int, inked: bool
) -> PaintedScan:
    """The picture of a scan of this patient in one stance, on `side` x `side` texels."""
    atlas = make_atlas(scan.vertices, scan.faces, side)
    albedo = painted.albedo if inked else painted.bare
    picture = photograph(albedo, painted.skin.vertices, body, painted.skin.faces, scan, atlas, random)
    return PaintedScan(body, scan, atlas, picture)


def painted_patients(half: Half = "both") -> tuple[str, ...]:
    """The names of the patients of a half; as sources of warped bodies they are of the same one."""
    halves = {
        patient.name: (DEVELOPMENT, VALIDATION)[index % 2] for index, patient in enumerate(read_bodies().patients)
    }
    return tuple(name for name, own in halves.items() if half in ("both", own))


def make_painted(
    folder: Path,
    progress: Callable[[str], None],
    patients: Sequence[str] | None = None,
    side: int = TEXTURE,
    seed: int = SEED,
) -> None:
    """PATIENT/STANCE/{scan.zip, truth.ply, landmarks.json, case.json, ink.json, skin.json}, ink_in_OTHER.json.

    Ink is on the standing scan only, and not on every one.  About eight seconds a scan.  Patients that are there
    already, of these bodies and this version, stay.
    """
    bodies = read_bodies()
    for index, patient in enumerate(bodies.patients):
        place = folder / patient.name
        made_by = {"breastrig": __version__, "paint": PAINT_VERSION, "seed": [seed, index], "side": side}
        if (patients is None or patient.name in patients) and not _is_there(place, made_by):
            place.mkdir(parents=True, exist_ok=True)
            (place / "patient.json").unlink(missing_ok=True)
            _write_patient(place, bodies, index, seed, side, progress)
            about = {"family": "makehuman", "virtual": True, "origin": bodies.origin, "licence": bodies.licence}
            write_json(place / "patient.json", about | {"made_by": made_by})


def _is_there(folder: Path, made_by: dict[str, object]) -> bool:
    """patient.json is written last."""
    try:
        about = json.loads((folder / "patient.json").read_text("utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(about, dict) and about.get("made_by") == made_by


def _write_patient(
    folder: Path, bodies: Bodies, index: int, seed: int, side: int, progress: Callable[[str], None]
) -> None:
    standing, supine = bodies.patients[index].bodies
    painted = draw_skin(standing, bodies.faces, np.random.default_rng((seed, index)), tone=TONES[index % len(TONES)])
    frames = {}
    for number, body in enumerate((standing, supine)):
        random = np.random.default_rng((seed, index, number))
        scan = scan_body(bodies, body, random)
        inked = body is standing and bool(painted.marks.ink)
        found = painted_scan(painted, body, scan, random, side, inked)
        unit = UNITS[(index + number) % len(UNITS)]
        more = {"tone": painted.tone, "plan": painted.plan if inked else "none", "seed": [seed, index, number]}
        frames[body.stance] = (
            unit,
            write_painted_case(
                folder / body.stance,
                body,
                bodies.faces,
                scan,
                found.atlas,
                found.picture,
                painted.marks,
                inked,
                unit,
                random,
                more,
            ),
        )
        progress(f"{folder.name} {body.stance}: {found.atlas.charts} charts, {1e3 * found.atlas.texel:.2f} mm a texel")
    unit, placed = frames["supine"]
    elsewhere = strokes_elsewhere(supine, bodies.faces, painted.marks.ink, placed, unit)
    write_shapes(folder / "standing" / "ink_in_supine.json", unit, elsewhere)

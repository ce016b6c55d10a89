"""A painted virtual woman whose scan is her true skin: colour and truth without the cost of a simulated camera."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from breastrig.core.arrays import Array
from breastrig.geometry.fields.level_sets import part_above
from breastrig.scan.clean import compact
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan
from breastrig_studies.virtual.bodies import Bodies, VirtualBody, read_bodies
from breastrig_studies.virtual.painted.files import scan_zip
from breastrig_studies.virtual.painted.make import PaintedScan, PaintedSkin, draw_skin, painted_scan
from breastrig_studies.virtual.scan import SimulatedScan

NOISE = 0.0004  # m, of the scan


@dataclass(frozen=True, eq=False)
class PaintedBody:
    """Everything in body coordinates, metres."""

    bodies: Bodies
    body: VirtualBody
    painted: PaintedSkin
    picture: PaintedScan
    scan: Scan  # as it is read from the zip

    @property
    def rims(self) -> dict[str, Array]:
        """Side -> (P, 3) m, the true borders of the areolae that have colour."""
        return {
            areola.side: areola.rim.positions(self.body.vertices, self.bodies.faces)
            for areola in self.painted.marks.areolae
            if areola.state == "natural"
        }


def painted_body(
    patient: int = 3,
    tone: int = 3,
    plan: str = "none",
    side: int = 512,
    seed: int = 5,
    supine: bool = False,
    states: tuple[tuple[str, str], ...] = (),
    inks: tuple[str, str] | None = None,
) -> PaintedBody:
    """The cohort's woman number `patient` (0 to 6), painted; `states` are those of nipples that are not natural.

    Lines are worn, but for those of given inks.
    """
    return _painted_body(patient, tone, plan, side, seed, supine, states, inks)


@lru_cache(maxsize=8)
def _painted_body(
    patient: int,
    tone: int,
    plan: str,
    side: int,
    seed: int,
    supine: bool,
    states: tuple[tuple[str, str], ...],
    inks: tuple[str, str] | None,
) -> PaintedBody:
    bodies = read_bodies()
    standing, lying = bodies.patients[patient].bodies
    body = lying if supine else standing
    random = np.random.default_rng((seed, patient))
    painted = draw_skin(
        standing, bodies.faces, random, tone=tone, plan=plan, states=dict(states), inks=inks, even=inks is not None
    )
    kept = bodies.faces[bodies.scanned[bodies.faces].all(axis=1)]
    vertices, faces = compact(body.vertices, kept)
    low = body.landmarks["umbilicus"][1] - 0.09  # as people crop
    vertices, faces = part_above(vertices, faces, vertices[:, 1], low)
    vertices = vertices + NOISE * random.standard_normal(vertices.shape)
    picture = painted_scan(painted, body, SimulatedScan(vertices, faces, NOISE), random, side, plan != "none")
    scan = read_scan(scan_zip(vertices, faces, picture.atlas, picture.picture.jpeg, 6), None, "m")
    return PaintedBody(bodies, body, painted, picture, scan)

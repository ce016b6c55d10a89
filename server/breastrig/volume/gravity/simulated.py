"""A patient's own breasts in a stance that was not scanned, solved by finite elements.

Her stiffness is that of which the published median is a multiple: the one under which her breasts go nearest to where a
scan in another stance has them, else one.  What softer and stiffer breasts would do is the radius.  Generators: whoever
stops asking has cancelled them.
"""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.rig.model import Rig
from breastrig.volume.breast_skin import BreastSkin, breast_skins
from breastrig.volume.gravity.soft_breast import DIRECTIONS, G, drawn, published, soft_breast
from breastrig.volume.gravity.statics import NoEquilibrium
from breastrig.volume.predicted import Predicted, in_template, stood_up, with_breasts
from breastrig.volume.volume_mesh import VolumeMesh

OF_90 = 1.645  # standard deviations to either side that hold nine of ten stiffnesses
STIFFER, TRIES = 2.0, 4  # where breasts do not come to rest, which cannot be that soft then
FACTORS = (0.5, 1.0, 2.0, 4.0, 8.0)  # of stiffness, that are tried with a second scan


@dataclass(frozen=True)
class Progress:
    """How far a prediction is."""

    share: float  # of the work that is done, 0 to 1
    said: str  # what is done next, in a few words


@dataclass(frozen=True, eq=False)
class Patient:
    """Her body as it was fitted."""

    rig: Rig
    mesh: VolumeMesh  # what is inside of it
    vertices: Array  # (V, 3) m
    stance: str

    def moved(self, side: BreastSkin, goal: str, factor: float) -> Array:
        """(P, 3) m, in the template's frame, at the skin that the breast moves, `factor` times as stiff as the median.

        Raises NoEquilibrium.
        """
        soft = soft_breast(self.rig, side.side)
        local, turn = in_template(self.rig, self.vertices, self.stance)
        points = (self.mesh.points[soft.nodes] - self.vertices[0]) @ turn.T + local[0]
        here, there = (G * np.array(DIRECTIONS[name]) for name in (self.stance, goal))
        stiffness = drawn(published(), np.zeros(4)).times(factor)
        body = soft.body(points, stiffness).resting(here)
        return soft.on(side.skin, body.at_rest(there, None, here))


def simulated(
    patient: Patient, goal: str, other: tuple[str, Array] | None = None
) -> Generator[Progress, None, Predicted]:
    """Her body in `goal`; `other` is a second stance in which she was scanned, and her (V, 3) m there.

    Raises BadInput, and NoEquilibrium where her breasts are too soft however stiff they are made.
    """
    first = 0.0 if other is None else 0.6
    spread = float(np.exp(OF_90 * published()["fat"]["log_sd"]))  # also with a second scan: stances differ by as much
    factor = 1.0 if other is None else (yield from _factor(patient, *other, first))
    breasts = []
    for k, side in enumerate(breast_skins(patient.rig)):
        name = "left" if side.side == "L" else "right"
        moves: list[Array] = []
        for j, times in enumerate((1.0, spread, 1.0 / spread)):
            yield Progress(
                first + (1.0 - first) * (3 * k + j) / 6.0, f"{name} breast{('', ', if stiffer', ', if softer')[j]}"
            )
            tries = STIFFER ** np.arange(TRIES if not moves else 1)
            for stiffer in tries:
                try:
                    moves.append(patient.moved(side, goal, factor * times * stiffer))
                except NoEquilibrium:
                    if not moves and stiffer == tries[-1]:
                        raise
                    continue
                break
        within = np.max([np.linalg.norm(move - moves[0], axis=1) for move in moves], axis=0)
        breasts.append((moves[0], within))
    return with_breasts(patient.rig, patient.vertices, patient.stance, goal, breasts)


def _factor(patient: Patient, stance: str, vertices: Array, share: float) -> Generator[Progress, None, float]:
    """Times the median: the stiffness that brings both breasts nearest to those of another scan, in mean squares."""
    there, here = stood_up(patient.rig, vertices, stance), stood_up(patient.rig, patient.vertices, patient.stance)
    missed: Array = np.full(len(FACTORS), np.inf)
    for k, factor in enumerate(FACTORS):
        yield Progress(share * k / len(FACTORS), f"stiffness as the {stance} scan shows it, {k + 1} of {len(FACTORS)}")
        try:
            gaps = [
                ((there - here)[side.skin] - patient.moved(side, stance, factor))[side.breast]
                for side in breast_skins(patient.rig)
            ]
        except NoEquilibrium:
            continue
        missed[k] = np.mean([(gap**2).sum(axis=1).mean() for gap in gaps])
    best = int(np.argmin(missed))
    logs = np.log(FACTORS)
    if 0 < best < len(FACTORS) - 1 and np.isfinite(missed[best - 1 : best + 2]).all():
        bend, slope, _ = np.polyfit(logs[best - 1 : best + 2], missed[best - 1 : best + 2], 2)
        return float(np.exp(-0.5 * slope / bend))
    return FACTORS[best]

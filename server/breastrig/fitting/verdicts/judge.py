"""Judges a finished fit: signals, radii and size of its posterior, and their combination."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.correspondence.distances import Comparison
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.task import PickIssue
from breastrig.fitting.uncertainty.radii import Radii, radii, seen_vertices
from breastrig.fitting.verdicts.fit_signals import fit_signals
from breastrig.fitting.verdicts.reasons import GivenLandmarks, Reason, of_doubts, of_lesions
from breastrig.fitting.verdicts.verdict import Verdict, shows_a_part, unusual_size, verdict, verdict_limits
from breastrig.least_squares.newton import Status
from breastrig.rig.near_breasts import near_breasts
from breastrig.rig.stance_priors import in_stance
from breastrig.scan.piece import BallInside

UNCLEAR_STANCE = Reason("The scan does not show clearly whether the patient stands or lies", ("say which it is",))
CONTRADICTED = Reason(
    "The body looks turned another way round than the file says", ("check left, head and front in the file",)
)


@dataclass(frozen=True, eq=False)
class Judged:
    """The judgement of a fit."""

    verdict: Verdict
    refusal: str  # one sentence, where it is no torso
    compared: Comparison
    radii: Radii | None


def judge(
    posterior: Posterior,
    status: Status,
    given: GivenLandmarks,
    doubts: Sequence[PickIssue] = (),
    clearness: float | None = None,
    *,
    lesions: Sequence[BallInside] = (),
    unclear_stance: bool = False,
    contradicted: bool = False,
    repeats: Callable[[], bool] = lambda: False,
) -> Judged:
    """`clearness`: Start.margin; `repeats`: whether the landmarks are proposals that a person has only agreed to.

    `lesions`: that the scan shows inside; `contradicted`: whether scan or landmarks show the body another way round
    than its file says.  Where that is so, or a lesion lies outside, no place of the fit is known.
    The stance is a question only where no landmarks place the fit: they are what moves the breasts.
    """
    rig, task, vertices = posterior.task.rig, posterior.task, posterior.state.vertices
    compared = Comparison(task.target, vertices, rig.faces)
    posed, near = (in_stance(rig, task.stance), posterior.state.x, compared, clearness), near_breasts(rig)
    signals, signals_near = fit_signals(*posed), fit_signals(*posed, near)
    found = verdict_limits(rig)
    limits = None if found is None else found.in_stance(task.stance)
    given = replace(given, left=_to_be_placed(posterior))
    if given.placed and shows_a_part(signals, limits):
        given = replace(given, repeated=repeats())
    inside, outside = of_lesions(rig, vertices, lesions)
    known = radii(posterior, -np.inf if contradicted or outside else clearness)
    corners = rig.faces[rig.landmark_points().faces]
    far = {name for name, at in zip(rig.landmark_names, corners, strict=True) if not near[at].any()}
    stance = (UNCLEAR_STANCE,) if unclear_stance and not given.on_their_own else ()
    size = unusual_size(limits, rig, vertices, task.target, task.stance)
    turned = (CONTRADICTED,) if contradicted else ()
    asked = (*turned, *inside, *of_doubts(doubts, far), *stance, *size)
    lines = None if known is None else known.lines
    said = verdict(signals, status, limits, given, asked, lines, task.stance, signals_near)
    refusal = "" if said.is_torso else said.refusal(rig.name, given, unusual_size=bool(size))
    return Judged(said, refusal, compared, known)


def _to_be_placed(posterior: Posterior) -> int:
    """The number of landmarks that the scan shows and nobody has picked."""
    rig, picked = posterior.task.rig, posterior.task.picked
    left = tuple(name for name in rig.landmark_names if name not in picked)
    if not left:
        return 0
    return int(seen_vertices(posterior)[rig.faces[rig.landmark_points(left).faces]].any(axis=1).sum())

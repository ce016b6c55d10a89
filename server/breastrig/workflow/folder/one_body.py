"""Whether two fits can be of one body: lengths that no stance changes, against what they may be off.

Between landmarks, as far as the errors of both places are known.  Of nine pairs of stances of one body (four virtual
patients and the example, picked and not) the first two lengths changed by up to 19 and 11 mm, no more than their errors
allow; of twenty pairs of two picked bodies fourteen differ by more.  Shoulders come nearer with raised arms, standing,
too (by more than errors allow in 11 of 92 pairs of one woman), so they do not count.

And of the trunk that both fits' scales and shapes make, against their covariances and what stances add; limits and
rates are in the rig's same_body.toml.  Scans from a breast MRI show too little of a trunk: it is said that they were
not compared.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import NeedsYes
from breastrig.core.settings_file import Positive, SettingsPart
from breastrig.core.stances import PRONE
from breastrig.fitting.body.trunk_lengths import SAID, trunk_lengths
from breastrig.rig.known import known_part
from breastrig.workflow.folder.fit_folder import FitFolder

QUESTION = "These do not look like scans of one patient"


@dataclass(frozen=True)
class BodyIssue:
    """A sentence on whether two fits are of one patient."""

    says: str  # one sentence, or two
    is_question: bool  # a person has to say that they are of one patient; else it is not known, and said


@dataclass(frozen=True)
class Bone:
    """A length that belongs to a body."""

    start: str
    end: str
    said: str
    change: float  # m, by which it may differ between two scans of one body, apart from the landmarks' errors


class Spreads(SettingsPart):
    """Standard deviations of the logarithms of trunk_lengths.SAID between fits of one body, beyond what they know."""

    ribs_breadth: Positive
    waist_breadth: Positive
    ribs_depth: Positive
    navel_depth: Positive
    notch_navel: Positive


class TrunkLimits(SettingsPart):
    """same_body.toml: how much two fits of one body differ."""

    spread: Spreads
    asked: Positive  # beyond this sum of squares, each over its variance, two fits are asked about


BONES = (
    Bone("suprasternal_notch", "xiphoid", "from the notch to the xiphoid", 0.018),  # its skin slides when lying
    Bone("suprasternal_notch", "umbilicus", "from the notch to the umbilicus", 0.025),  # the spine bends
)


def check_one_body(a: FitFolder, b: FitFolder, same_patient: bool) -> None:
    """NeedsYes where the two are not likely to be of one patient; `same_patient`: a person says that they are."""
    doubt = body_doubt(a, b)
    if doubt is not None and doubt.is_question and not same_patient:
        raise NeedsYes(doubt.says.removesuffix("."), "same_patient")


def doubts_between(a: FitFolder, b: FitFolder, same_patient: bool = False) -> list[str]:
    """What is to be read of the two; nothing where a person has said that they are of the `same_patient`."""
    doubt = None if same_patient else body_doubt(a, b)
    return [] if doubt is None else [doubt.says]


def body_doubt(a: FitFolder, b: FitFolder) -> BodyIssue | None:
    """Whether the two are of one patient; None where nothing speaks against it."""
    if a.result.scan.sha256 == b.result.scan.sha256:
        if a.stance == b.stance or a.result.predicted or b.result.predicted:
            return None
        both = f"{a.stance} and as {b.stance}"
        return BodyIssue(f"Both fits are of the same scan file, as {both}. Choose the scan of the other stance.", True)
    return _by_landmarks(a, b) or _by_trunk(a, b)


def _by_landmarks(a: FitFolder, b: FitFolder) -> BodyIssue | None:
    (there, off_there), (here, off_here) = _landmarks(a), _landmarks(b)
    known = there.keys() & off_there.keys() & here.keys() & off_here.keys()
    for bone in BONES:
        if not {bone.start, bone.end} <= known:
            continue
        first, second = (float(np.linalg.norm(places[bone.start] - places[bone.end])) for places in (there, here))
        offs = [off[end] for off in (off_there, off_here) for end in (bone.start, bone.end)]
        allowed = float(np.hypot(np.linalg.norm(offs), bone.change))
        if abs(first - second) > allowed:
            on_first, on_second = _scans(a, b)
            return BodyIssue(
                f"{QUESTION}: it is {1e3 * first:.0f} mm {bone.said} on {on_first} and {1e3 * second:.0f} mm on "
                f"{on_second}; {1e3 * allowed:.0f} mm are explained by their errors.",
                True,
            )
    return None


def _by_trunk(a: FitFolder, b: FitFolder) -> BodyIssue | None:
    if PRONE in (a.stance, b.stance):
        return _unknown(a, b, "a prone scan shows too little of the trunk")
    limits = known_part(a.rig, "same_body.toml", TrunkLimits)
    if limits is None:
        return _unknown(a, b, "nobody has measured how much two fits of one body differ with this model")
    first, second = (None if fit.body is None else trunk_lengths(fit.rig, fit.body) for fit in (a, b))
    if first is None or second is None:
        return _unknown(a, b, "one of the fits does not say how sure it is of the body")
    spread = np.array([getattr(limits.spread, name) for name in SAID])
    differs = second.logs - first.logs
    squares = differs**2 / (first.sigmas**2 + second.sigmas**2 + spread**2)
    if squares.sum() <= limits.asked:
        return None
    words = [
        f"{100.0 * abs(np.expm1(by)):.0f} % {said[int(by < 0)]}"
        for by, said in zip(differs, SAID.values(), strict=True)
    ]
    most = " and ".join(words[place] for place in np.argsort(-squares)[:2])
    there, here = _scans(a, b)
    return BodyIssue(f"{QUESTION}: the trunk is {most} on {here} than on {there}.", True)


def _unknown(a: FitFolder, b: FitFolder, why: str) -> BodyIssue:
    return BodyIssue(f"Whether {' and '.join(_scans(a, b))} are of one patient was not compared: {why}.", False)


def _scans(a: FitFolder, b: FitFolder) -> tuple[str, str]:
    """What they are called."""
    there, here = (f"{fit.stance} {'prediction' if fit.result.predicted else 'scan'}" for fit in (a, b))
    return (f"the {there}", f"the {here}") if there != here else (f"the first {there}", f"the second {here}")


def _landmarks(fit: FitFolder) -> tuple[dict[str, Array], dict[str, float]]:
    """(3,) m places, as picked or seen, else of the model; and m, the radii that hold the true ones with 90 %."""
    model = {name: fit.metres_per_unit * np.array(place) for name, place in fit.result.landmarks.items()}
    radii = fit.result.landmark_uncertainty_mm
    return model | fit.seen | fit.landmarks, {name: 1e-3 * radius for name, radius in radii.items()}

"""Whether two fits can be of one body: lengths that no stance changes, against what they may be off.

Between landmarks, as far as the errors of both places are known.  Of nine pairs of stances of one body (four virtual
patients and the example, picked and not) the first two lengths changed by up to 19 and 11 mm, no more than their errors
allow; of twenty pairs of two picked bodies fourteen differ by more.  Shoulders come nearer with raised arms, standing,
too (by more than errors allow in 11 of 92 pairs of one woman), so they do not count.

And of the trunk that both fits' scales and shapes make, against their covariances and what stances add, and of the
breasts' volumes, against their bands: the deviance of Student's t for each, so that one number that is far off counts
less than several.  Limits and rates are in the rig's same_body.toml.  Scans from a breast MRI show too little of a
trunk: it is said that they were not compared.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import NeedsYes
from breastrig.core.settings_file import Positive, SettingsPart
from breastrig.core.stances import PRONE, SIDES
from breastrig.fitting.body.trunk_lengths import SAID, trunk_lengths
from breastrig.report.bands import OF_90
from breastrig.report.stance import Stance
from breastrig.report.volume import breast_volume
from breastrig.rig.known import known_part
from breastrig.use.folder.fit_folder import FitFolder

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
    """Standard deviations of numbers of `SIZES` between fits of one body, beyond what they know."""

    ribs_breadth: Positive
    waist_breadth: Positive
    ribs_depth: Positive
    navel_depth: Positive
    notch_navel: Positive
    breasts: Positive
    left_share: Positive


class TrunkLimits(SettingsPart):
    """same_body.toml: the differences between two fits of one body."""

    spread: Spreads
    freedom: Positive  # degrees of Student's t
    asked: Positive  # beyond this deviance of all sizes two fits are asked about
    beside_breasts: Positive  # m³ that are added to the volume of both breasts, as flat ones have no logarithm


SIZES = {  # what is said of each where it is greater, and where it is less; logarithms, but for the share
    **{name: ("the trunk is", words) for name, words in SAID.items()},
    "breasts": ("the breasts are", ("larger", "smaller")),
    "left_share": ("the left breast's part of both is", ("larger", "smaller")),
}

LEAST = 1e-6  # m³ of a breast

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
    """Sentences about the two fits; empty where a person has stated that they are of the `same_patient`."""
    doubt = None if same_patient else body_doubt(a, b)
    return [] if doubt is None else [doubt.says]


def body_doubt(a: FitFolder, b: FitFolder) -> BodyIssue | None:
    """Whether the two are of one patient; None where nothing speaks against it."""
    if a.result.scan.sha256 == b.result.scan.sha256:
        if a.stance == b.stance or a.result.predicted or b.result.predicted:
            return None
        both = f"{a.stance} and as {b.stance}"
        return BodyIssue(f"Both fits are of the same scan file, as {both}. Choose the scan of the other stance.", True)
    return _by_landmarks(a, b) or _by_size(a, b)


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


def _by_size(a: FitFolder, b: FitFolder) -> BodyIssue | None:
    if PRONE in (a.stance, b.stance):
        return _unknown(a, b, "a prone scan shows too little of the trunk")
    limits = known_part(a.rig, "same_body.toml", TrunkLimits)
    if limits is None:
        return _unknown(a, b, "nobody has measured how much two fits of one body differ with this model")
    first, second = (_sizes(fit, limits.beside_breasts) for fit in (a, b))
    if first is None or second is None:
        return _unknown(a, b, "one of the fits does not say how sure it is of the body")
    spread = np.array([getattr(limits.spread, name) for name in SIZES])
    differs = second[0] - first[0]
    squares = np.nan_to_num(differs**2 / (first[1] ** 2 + second[1] ** 2 + spread**2))
    if np.sum((limits.freedom + 1.0) * np.log1p(squares / limits.freedom)) <= limits.asked:
        return None
    there, here = _scans(a, b)
    greater = _true_sizes(second[0], limits.beside_breasts) / _true_sizes(first[0], limits.beside_breasts) - 1.0
    return BodyIssue(f"{QUESTION}: {_words(greater, squares)} on {here} than on {there}.", True)


def _true_sizes(sizes: Array, beside: float) -> Array:
    """(K,) of `SIZES` without what is added to the breasts."""
    both, left = np.exp(sizes[-2]), sizes[-1] * np.exp(sizes[-2])
    volume = max(both - beside, LEAST)
    return np.concatenate([np.exp(sizes[:-2]), [volume, max(left - 0.5 * beside, LEAST) / volume]])


def _words(greater: Array, squares: Array) -> str:
    """The two sizes that differ most, each with the share by which it is greater."""
    said: dict[str, list[str]] = {}
    for place in np.argsort(-squares)[:2]:
        subject, words = list(SIZES.values())[place]
        by = 100.0 * abs(greater[place])
        said.setdefault(subject, []).append(f"{by:.0f} % {words[int(greater[place] < 0.0)]}")
    return " and ".join(f"{subject} {' and '.join(words)}" for subject, words in said.items())


def _sizes(fit: FitFolder, beside: float) -> tuple[Array, Array] | None:
    """(K,) numbers of `SIZES` and their standard deviations; nan where nothing is known of the breasts.

    None where the fit says nothing of its body.
    """
    trunk = None if fit.body is None else trunk_lengths(fit.rig, fit.body)
    if trunk is None:
        return None
    breasts, sigmas = np.full(2, np.nan), np.full(2, np.nan)
    if fit.radii is not None and not fit.result.predicted:
        surface = fit.surface
        stance = Stance(fit.rig, fit.vertices, surface.vertices, surface.faces, fit.stance, radii=fit.radii)
        left, right = (breast_volume(stance, side) for side in SIDES)
        if left is not None and right is not None:
            sizes = np.maximum([left.value, right.value], 0.0)
            both = sizes.sum() + beside
            breasts = np.array([np.log(both), (sizes[0] + 0.5 * beside) / both])
            sigma = 0.5 * np.hypot(left.high - left.low, right.high - right.low) / (OF_90 * both)
            sigmas = np.array([sigma, 0.5 * sigma])
    return np.append(trunk.logs, breasts), np.append(trunk.sigmas, sigmas)


def _unknown(a: FitFolder, b: FitFolder, why: str) -> BodyIssue:
    return BodyIssue(f"Whether {' and '.join(_scans(a, b))} are of one patient was not compared: {why}.", False)


def _scans(a: FitFolder, b: FitFolder) -> tuple[str, str]:
    """The names of both scans, for sentences."""
    there, here = (f"{fit.stance} {'prediction' if fit.result.predicted else 'scan'}" for fit in (a, b))
    return (f"the {there}", f"the {here}") if there != here else (f"the first {there}", f"the second {here}")


def _landmarks(fit: FitFolder) -> tuple[dict[str, Array], dict[str, float]]:
    """(3,) m places, as picked or seen, else of the model; and m, the radii that hold the true ones with 90 %."""
    model = {name: fit.metres_per_unit * np.array(place) for name, place in fit.result.landmarks.items()}
    radii = fit.result.landmark_uncertainty_mm
    return model | fit.seen | fit.landmarks, {name: 1e-3 * radius for name, radius in radii.items()}

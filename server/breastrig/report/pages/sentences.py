"""What the report says in sentences: what to doubt, what the plan says, and how things were measured."""

from collections.abc import Sequence
from dataclasses import dataclass

from breastrig.report.document import Reported
from breastrig.report.measures import OUTLINE

METHODS = (  # a sentence, and the measure that it is about; none for what holds of all
    ("Straight: distance in space. Along the skin: shortest way on the fitted model's skin, holes bridged.", None),
    ("Landmarks as picked, else of the model (each named in report.json).", None),
    (
        "Nipple to midline: at right angles to the model's median plane; along the skin to its midline.",
        "nipple_midline",
    ),
    ("Base width: between the most medial and most lateral point of the model's breast outline.", "base_width"),
    (
        "Volume: between the skin inside that outline and a smooth chest wall (a thin-plate spline through the skin "
        "on, 10 and 20 mm outside it); its band holds the outline moved 5 mm in and out and the distance between fit "
        "and scan; a change within the bands says nothing.",
        "volume",
    ),
    ("M1 to M6: ratios of left and right, 1 = symmetric (Reddy et al. 2017); every woman has some asymmetry.", "M1"),
)
HOW = "How it was measured"
WARNINGS = {"check": "CHECK THIS FIT: see doubts and notes", "unusable": "NOT USABLE: see doubts and notes"}


@dataclass(frozen=True)
class Section:
    """A paragraph with its heading."""

    heading: str
    text: str
    size: float  # of its letters, points


def warning_of(one: Reported) -> str:
    """What has to stand wherever numbers of this fit do; empty for a good one."""
    return WARNINGS.get((one.result.get("verdict") or {}).get("level", "good"), "")


def sections(stances: Sequence[Reported]) -> list[Section]:
    """The paragraphs, what matters most first."""
    doubted = [remark for one in stances for remark in _said(stances, one, _doubts(one))]
    planned = [remark for one in stances for remark in _said(stances, one, one.stance.remarks)]
    none = "Every landmark was picked, and none of the picks was doubted."
    return [
        Section("Doubts and notes", "  ".join(doubted) or none, 7.5),
        *([Section("The plan in words", "  ".join(planned), 7.5)] if planned else []),
        Section(HOW, methods(stances), 6.5),
    ]


def methods(stances: Sequence[Reported]) -> str:
    """How what stands in the tables was measured."""
    measured = {None, *(row.measure for one in stances for row in one.rows)}
    return " ".join(sentence for sentence, measure in METHODS if measure in measured)


def _said(stances: Sequence[Reported], one: Reported, remarks: Sequence[str]) -> list[str]:
    """Each remark with its stance, where there are two."""
    prefix = f"{one.name.capitalize()}: " if len(stances) > 1 else ""
    return [prefix + remark for remark in remarks]


def _doubts(one: Reported) -> list[str]:
    """Why to check the fit, unusual picks and those not followed, patterns that do not fit, what reading found."""
    reasons = [str(reason) for reason in (one.result.get("verdict") or {}).get("reasons", ())]
    for picks in ("landmarks_not_followed", "landmarks_unusual"):
        reasons += [str(pick["reason"]) for pick in one.result.get(picks, ())]
    reasons += [str(note) for notes in ("drawing_missing", "notes") for note in one.result.get(notes, ())]
    unpicked = _unpicked(one)
    return reasons + (["the model's own place was taken for " + ", ".join(_spoken(unpicked)) + "."] if unpicked else [])


def _unpicked(one: Reported) -> list[str]:
    """The landmarks that no pick gave, or none that was believed, of those that the measures name."""
    named = dict.fromkeys(name for row in one.rows for name in row.landmarks)
    return [name.removesuffix(" (model)") for name in named if name.endswith(" (model)") and name != OUTLINE]


def _spoken(names: Sequence[str]) -> list[str]:
    """nipple_L and nipple_R: nipple on both sides; suprasternal_notch: suprasternal notch."""
    sides: dict[str, list[str]] = {}
    for name in names:
        stem, side = (name[:-2], name[-1]) if name.endswith(("_L", "_R")) else (name, "")
        sides.setdefault(stem.replace("_", " "), []).append(side)
    words = {"": "", "L": " left", "R": " right"}
    return [stem + (" on both sides" if len(found) > 1 else words[found[0]]) for stem, found in sides.items()]

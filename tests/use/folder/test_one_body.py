"""Whether two fits can be of one body: bones that differ by more than errors and stance explain."""

import re
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from helpers.results import result_file

from breastrig.core.errors import NeedsYes
from breastrig.report.volume import vertices_within
from breastrig.rig.cohort_posterior import Gaussian
from breastrig.rig.model import Rig
from breastrig.scan.clean import Surface
from breastrig.use.folder.fit_folder import FitFolder
from breastrig.use.folder.one_body import body_doubt, check_one_body, doubts_between

BODY = {  # mm
    "suprasternal_notch": [0.0, 420.0, 80.0],
    "xiphoid": [0.0, 190.0, 100.0],
    "umbilicus": [0.0, 40.0, 90.0],
    "acromion_L": [170.0, 440.0, 0.0],
    "acromion_R": [-170.0, 440.0, 0.0],
}


def body(rig: Rig, larger: float = 1.0, sigma: float = 0.003) -> Gaussian:
    """As the rig was built, but larger, and how surely that is known."""
    mean = np.concatenate([np.full(3 * len(rig.bones), larger), np.zeros(len(rig.shapes))])
    return Gaussian(mean, sigma**2 * np.eye(len(mean)))


def fit(
    rig: Rig,
    stance: str = "standing",
    radius: float = 5.0,
    picked: bool = True,
    larger: float = 1.0,
    **moved: list[float],
) -> FitFolder:
    places = BODY | moved
    landmarks = {name: 1e-3 * np.array(place) for name, place in places.items()} if picked else {}
    scan = {"sha256": f"{stance:0>60}{larger:.4f}"}
    result = result_file(
        scan=scan, landmarks=places, landmark_uncertainty_mm=dict.fromkeys(places, radius) if radius else {}
    )
    found = SimpleNamespace(
        rig=rig,
        result=result,
        stance=stance,
        landmarks=landmarks,
        seen={},
        metres_per_unit=1e-3,
        body=body(rig, larger),
        radii=None,
    )
    return cast(FitFolder, found)


def test_one_body_in_two_stances_is_not_asked_about(rig: Rig) -> None:
    nearer = {"acromion_L": [110.0, 480.0, 0.0], "acromion_R": [-110.0, 480.0, 0.0], "umbilicus": [0.0, 55.0, 90.0]}
    assert body_doubt(fit(rig), fit(rig, "supine", **nearer)) is None
    assert body_doubt(fit(rig, "supine"), fit(rig, xiphoid=[0.0, 202.0, 100.0])) is None
    raised = {name: place for name, place in nearer.items() if name != "umbilicus"}
    assert body_doubt(fit(rig), fit(rig, larger=1.0001, **raised)) is None, "arms are raised standing, too"
    check_one_body(fit(rig), fit(rig, "supine", larger=1.03), same_patient=False)


@pytest.mark.parametrize(
    ("stance", "moved", "said"),
    [
        (
            "supine",
            {"xiphoid": [0.0, 165.0, 100.0]},
            "231 mm from the notch to the xiphoid on the standing scan and 256",
        ),
        (
            "supine",
            {"umbilicus": [0.0, -20.0, 90.0]},
            "380 mm from the notch to the umbilicus on the standing scan and 440",
        ),
        (
            "standing",
            {"umbilicus": [0.0, -20.0, 90.0]},
            "380 mm from the notch to the umbilicus on the first standing scan and 440",
        ),
    ],
)
def test_landmarks_that_cannot_be_of_one_body_are_asked_about(
    rig: Rig, stance: str, moved: dict[str, list[float]], said: str
) -> None:
    doubt = body_doubt(fit(rig), fit(rig, stance, larger=1.0001, **moved))
    assert doubt.is_question
    assert doubt.says.startswith("These do not look like scans of one patient: it is ")
    assert said in doubt.says
    unsure = {"radius": 80.0, "picked": False}
    assert body_doubt(fit(rig), fit(rig, stance, larger=1.0001, **unsure, **moved)) is None, "it may be the landmarks"
    assert body_doubt(fit(rig), fit(rig, stance, larger=1.0001, radius=0.0, **moved)) is None, "it is not known"


@pytest.mark.parametrize("stance", ["standing", "supine"])
def test_without_picks_the_trunks_are_compared(rig: Rig, stance: str) -> None:
    first, second = fit(rig, radius=80.0, picked=False), fit(rig, stance, 80.0, picked=False, larger=1.12)
    with pytest.raises(
        NeedsYes, match=r"the trunk is 12 % .* than on .*; if it is right all the same, say same_patient"
    ) as told:
        check_one_body(first, second, same_patient=False)
    assert told.value.on_command_line().endswith("add --same-patient.")
    check_one_body(first, second, same_patient=True)
    assert doubts_between(first, second, same_patient=True) == []
    assert len(doubts_between(first, second)) == 1


def test_a_fit_that_hardly_knows_the_body_asks_less(rig: Rig) -> None:
    first, second = fit(rig, radius=80.0, picked=False), fit(rig, "supine", 80.0, picked=False, larger=1.12)
    object.__setattr__(second, "body", body(rig, 1.12, sigma=0.1))
    assert body_doubt(first, second) is None


def with_breasts(found: FitFolder, left: float = 1.0, right: float = 1.0, radius: float = 0.004) -> FitFolder:
    """As the rig was built, but with breasts so many times as high over the chest."""
    skin = found.rig.template.copy()
    for side, times in (("L", left), ("R", right)):
        inside = vertices_within(found.rig, side)
        assert inside is not None
        skin[inside, 2] += (times - 1.0) * (skin[inside, 2] - skin[inside, 2].min())
    for name, value in {
        "vertices": skin,
        "surface": Surface(skin, found.rig.faces, ()),
        "radii": np.full(len(skin), radius),
    }.items():
        object.__setattr__(found, name, value)
    return found


UNPICKED = {"radius": 80.0, "picked": False}


@pytest.mark.parametrize(
    ("standing", "lying", "said"),
    [
        ((1.0, 1.0), (1.5, 1.5), r"the breasts are \d+ % larger .*on the supine scan than on the standing scan"),
        ((1.0, 1.0), (0.6, 1.6), r"the left breast's part of both is \d+ % smaller "),
    ],
)
def test_breasts_of_other_volumes_are_asked_about(
    rig: Rig, standing: tuple[float, float], lying: tuple[float, float], said: str
) -> None:
    first = with_breasts(fit(rig, **UNPICKED), *standing)
    second = with_breasts(fit(rig, "supine", **UNPICKED, larger=1.03), *lying)
    doubt = body_doubt(first, second)
    assert doubt.is_question
    assert re.search(said, doubt.says)
    assert body_doubt(second, first) is not None
    alike = with_breasts(fit(rig, "supine", **UNPICKED, larger=1.03), *(1.02 * times for times in standing))
    assert body_doubt(first, alike) is None


@pytest.mark.parametrize("case", ["hardly known", "not known", "predicted"])
def test_breasts_of_which_little_is_known_are_not_asked_about(rig: Rig, case: str) -> None:
    first, second = (
        with_breasts(fit(rig, **UNPICKED)),
        with_breasts(fit(rig, "supine", **UNPICKED, larger=1.03), 1.5, 1.5),
    )
    assert body_doubt(first, second) is not None
    if case == "predicted":
        object.__setattr__(second, "result", second.result.model_copy(update={"predicted": True}))
    else:
        object.__setattr__(second, "radii", np.full(len(rig.template), 0.15) if case == "hardly known" else None)
    assert body_doubt(first, second) is None


@pytest.mark.parametrize("case", ["prone", "no body", "another rig"])
def test_what_was_not_compared_is_said(rig: Rig, case: str) -> None:
    first, second = fit(rig), fit(rig, "prone" if case == "prone" else "supine", larger=1.3)
    if case == "no body":
        object.__setattr__(second, "body", None)
    if case == "another rig":
        object.__setattr__(first, "rig", replace(rig, known={}))
    doubt = body_doubt(first, second)
    assert not doubt.is_question
    assert "was not compared: " in doubt.says
    check_one_body(first, second, same_patient=False)


def test_a_prone_scan_is_compared_by_landmarks(rig: Rig) -> None:
    doubt = body_doubt(fit(rig), fit(rig, "prone", xiphoid=[0.0, 165.0, 100.0]))
    assert doubt.is_question


def test_the_same_file_as_two_stances_is_said(rig: Rig) -> None:
    first, second = fit(rig), fit(rig, "supine")
    object.__setattr__(second, "result", first.result)
    doubt = body_doubt(first, second)
    assert doubt.says.startswith("Both fits are of the same scan file, as standing and as supine.")
    assert body_doubt(first, first) is None

"""Whether two fits can be of one body: bones that differ by more than errors and stance explain."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from helpers.results import result_file

from breastrig.files.result import ResultParameters
from breastrig.workflow.folder.fit_folder import FitFolder
from breastrig.workflow.folder.one_body import body_doubt

BODY = {  # mm
    "suprasternal_notch": [0.0, 420.0, 80.0],
    "xiphoid": [0.0, 190.0, 100.0],
    "umbilicus": [0.0, 40.0, 90.0],
    "acromion_L": [170.0, 440.0, 0.0],
    "acromion_R": [-170.0, 440.0, 0.0],
}


def fit(stance: str = "standing", radius: float = 5.0, picked: bool = True, **moved: list[float]) -> FitFolder:
    places = BODY | moved
    landmarks = {name: 1e-3 * np.array(place) for name, place in places.items()} if picked else {}
    scan = {"sha256": f"{stance:0>64}"}
    result = result_file(
        scan=scan, landmarks=places, landmark_uncertainty_mm=dict.fromkeys(places, radius) if radius else {}
    )
    return cast(
        FitFolder, SimpleNamespace(result=result, stance=stance, landmarks=landmarks, seen={}, metres_per_unit=1e-3)
    )


def test_one_body_in_two_stances_is_not_asked_about() -> None:
    nearer = {"acromion_L": [110.0, 480.0, 0.0], "acromion_R": [-110.0, 480.0, 0.0], "umbilicus": [0.0, 55.0, 90.0]}
    assert body_doubt(fit(), fit("supine", **nearer)) is None
    assert body_doubt(fit("supine"), fit(xiphoid=[0.0, 202.0, 100.0])) is None


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
        ("standing", {"acromion_L": [210.0, 440.0, 0.0]}, "340 mm between the shoulders on the standing scan and 380"),
    ],
)
def test_what_cannot_be_one_body_is_asked_about(stance: str, moved: dict[str, list[float]], said: str) -> None:
    doubt = body_doubt(fit(), fit(stance, **moved))
    assert doubt is not None
    assert doubt.startswith("Are both scans of one patient?")
    assert said in doubt
    assert body_doubt(fit(), fit(stance, radius=80.0, picked=False, **moved)) is None, "it may be the landmarks"
    assert body_doubt(fit(), fit(stance, radius=0.0, **moved)) is None, "it is not known"


def proportioned(stance: str, umbilicus: float = 40.0, pelvis: float = 1.0) -> FitFolder:
    """Nothing was picked: the places are within 30 mm."""
    found = fit(stance, radius=30.0, picked=False, umbilicus=[0.0, umbilicus, 90.0])
    bone = {
        "name": "pelvis",
        "rotation_xyzw": [0.0, 0.0, 0.0, 1.0],
        "translation_m": [0.0] * 3,
        "scale": [pelvis, 1.0, 1.0],
    }
    bones = ResultParameters.model_validate({"bones": [bone], "blendshapes": {}})
    found.result = found.result.model_copy(update={"parameters": bones})  # type: ignore[misc]
    return found


def test_without_picks_the_models_proportions_are_compared() -> None:
    first = proportioned("standing")
    assert body_doubt(first, proportioned("supine", 55.0, 1.08)) is None
    assert "380 mm from the notch to the umbilicus" in str(body_doubt(first, proportioned("supine", 5.0)))
    assert "pelvis differs by 15 %" in str(body_doubt(first, proportioned("supine", 40.0, 1.18)))
    assert body_doubt(first, proportioned("prone", 5.0, 1.18)) is None, "a prone scan shows too little"


def test_the_same_file_as_two_stances_is_said() -> None:
    first, second = fit(), fit("supine")
    second.result = first.result  # type: ignore[misc]
    assert str(body_doubt(first, second)).startswith("Both fits are of the same scan file, as standing and as supine.")

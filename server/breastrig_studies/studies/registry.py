"""The questions by name, each as a function of cases, rig, recipe and its own settings."""

from collections.abc import Callable
from functools import wraps
from typing import Any

from breastrig.fitting.recipe import Recipe
from breastrig.rig.model import Rig
from breastrig_studies.cohort import Case
from breastrig_studies.studies import accuracy, peers, sensitivity, unseen
from breastrig_studies.studies import landmarks as landmark_study
from breastrig_studies.studies import orientation as orientation_study
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.colour_landmarks import colour_landmarks
from breastrig_studies.studies.ink import ink_study, ink_transfer_study
from breastrig_studies.studies.lesions import lesions_study
from breastrig_studies.studies.measures import measures_study
from breastrig_studies.studies.other_patient import other_patient
from breastrig_studies.studies.transfer import transfer_study
from breastrig_studies.studies.trust import certainty
from breastrig_studies.studies.trust.verdicts import verdicts
from breastrig_studies.studies.two_stances import gain

Answer = Callable[..., dict[str, Any]]


def _of_one_case(question: Answer) -> Answer:
    @wraps(question)
    def answer(cases: tuple[Case, ...], rig: Rig, recipe: Recipe, **settings: Any) -> dict[str, Any]:
        (case,) = cases
        return question(read_scene(case), rig, recipe, **settings)

    return answer


def two_stances(cases: tuple[Case, ...], rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """The gain of fitting two stances of one patient together."""
    return {"rows": gain(cases, rig, recipe, lambda _: None)}


ANSWERS: dict[str, Answer] = {
    "accuracy": _of_one_case(accuracy.accuracy),
    "halves": _of_one_case(landmark_study.halves),
    "no_landmarks": _of_one_case(landmark_study.no_landmarks),
    "clicks": _of_one_case(landmark_study.clicks),
    "one_wrong": _of_one_case(landmark_study.one_wrong),
    "exchanged_sides": _of_one_case(landmark_study.exchanged_sides),
    "random_turns": _of_one_case(orientation_study.random_turns),
    "compliance": _of_one_case(sensitivity.compliance),
    "shape_count": _of_one_case(sensitivity.shape_count),
    "unseen": _of_one_case(unseen.unseen),
    "certainty": _of_one_case(certainty.certainty),
    "measures": _of_one_case(measures_study),
    "verdicts": _of_one_case(verdicts),
    "peer": _of_one_case(peers.peer),
    "two_stances": two_stances,
    "transfer": transfer_study,
    "lesions": lesions_study,
    "other_patient": other_patient,
    "colour_landmarks": colour_landmarks,
    "ink": ink_study,
    "ink_transfer": ink_transfer_study,
}

"""The questions by name, each as a function of cases, rig, recipe and its own settings."""

import statistics
from collections.abc import Callable
from functools import wraps
from typing import Any

import numpy as np

from breastrig.correspondence.distances import landmark_summary_mm, summary_mm, surface_distances, surface_summary_mm
from breastrig.fitting.body.refine import refined, skin_behind
from breastrig.fitting.recipe import Recipe
from breastrig.geometry.normals import turned_triangles
from breastrig.rig.model import Rig
from breastrig_studies.cohort import Case
from breastrig_studies.gravity.prediction import prediction_study
from breastrig_studies.studies import landmarks as landmark_study
from breastrig_studies.studies import orientation as orientation_study
from breastrig_studies.studies import peers, sensitivity, unseen
from breastrig_studies.studies.case import Fitted, Scene, read_scene
from breastrig_studies.studies.colour_landmarks import colour_landmarks
from breastrig_studies.studies.ink import ink_study, ink_transfer_study
from breastrig_studies.studies.lesions import lesions_study
from breastrig_studies.studies.measures import measures_study
from breastrig_studies.studies.other_patient import other_patient
from breastrig_studies.studies.prone import prone
from breastrig_studies.studies.transfer import transfer_study
from breastrig_studies.studies.trust import certainty
from breastrig_studies.studies.trust.asked import asked
from breastrig_studies.studies.trust.captured import captured
from breastrig_studies.studies.trust.verdicts import verdicts

REPEATS = 3  # fits whose median time counts ...
ENOUGH_SECONDS = 1.0  # ... unless one takes this long: then chance matters less


def accuracy(scene: Scene, rig: Rig, recipe: Recipe) -> dict[str, Any]:
    """All numbers of Table 1 for the fit with all landmarks."""
    start = scene.start(rig, scene.landmarks)
    times: list[float] = []
    while len(times) < REPEATS and sum(times) < ENOUGH_SECONDS:
        fit: Fitted = scene.fitted(rig, recipe, scene.landmarks, start)
        times.append(fit.seconds)
    distances = surface_distances(scene.target, fit.vertices, rig.faces)
    behind = skin_behind(rig, scene.case.stance, scene.target, fit.vertices)
    fine = refined(scene.target, fit.vertices, rig.faces, behind).vertices
    names = tuple(scene.landmarks)
    places = rig.landmark_points(names).positions(fit.vertices, rig.faces)
    moved = np.linalg.norm(rig.blendshapes, axis=2)  # (S, V) m at weight 1
    return {
        "time_s": round(statistics.median(times), 4),
        "iterations": fit.iterations,
        "surface_mm": surface_summary_mm(distances.model),
        "scan_to_model_mm": summary_mm(distances.scan),
        "truth_mm": summary_mm(scene.truth_errors(fit.vertices, rig.faces)),
        "turned_triangles": int(turned_triangles(fit.vertices, rig.faces).sum()),
        "landmark_mm": landmark_summary_mm(dict(zip(names, places, strict=True)), scene.landmarks),
        "refined": {
            "surface_mm": surface_summary_mm(surface_distances(scene.target, fine, rig.faces).model),
            "truth_mm": summary_mm(scene.truth_errors(fine, rig.faces)),
            "turned_triangles": int(turned_triangles(fine, rig.faces).sum()),
        },
        "shape_effect_mm": {  # how far each shape moved the skin: |weight| times its root mean square displacement
            name: round(float(1e3 * abs(weight) * np.sqrt((moved[k] ** 2).mean())), 5)
            for k, (name, weight) in enumerate(zip(rig.shape_names, fit.parameters.weights, strict=True))
        },
    }


Answer = Callable[..., dict[str, Any]]


def _of_one_case(question: Answer) -> Answer:
    @wraps(question)
    def answer(cases: tuple[Case, ...], rig: Rig, recipe: Recipe, **settings: Any) -> dict[str, Any]:
        (case,) = cases
        return question(read_scene(case), rig, recipe, **settings)

    return answer


ANSWERS: dict[str, Answer] = {
    "accuracy": _of_one_case(accuracy),
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
    "asked": _of_one_case(asked),
    "captured": _of_one_case(captured),
    "prone": _of_one_case(prone),
    "peer": _of_one_case(peers.peer),
    "transfer": transfer_study,
    "lesions": lesions_study,
    "prediction": prediction_study,
    "other_patient": other_patient,
    "colour_landmarks": colour_landmarks,
    "ink": ink_study,
    "ink_transfer": ink_transfer_study,
}

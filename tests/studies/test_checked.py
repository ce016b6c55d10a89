"""The study of checks: what is promised is the posterior's, and the numbers of fits are what they are called."""

import numpy as np
import pytest
from helpers.cohort import write_patient

from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.landmarks import CLICK_ERROR
from breastrig_studies.studies.trust.checked import ALL, as_clicked, chosen


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    folder = tmp_path_factory.mktemp("cohort")
    write_patient(folder / "patient_0", read_rig(default_rig_path()), 3, "independent", ("standing",))
    [case] = chosen(folder, ALL)
    return read_scene(case)


def test_a_person_says_yes_to_what_is_near_and_else_clicks_beside_the_true_place(scene: Scene) -> None:
    true = dict(scene.landmarks)
    names = tuple(true)
    away = np.array([0.0, 0.0, CLICK_ERROR])
    expected = {name: true[name] + (0.3 if k % 2 else 4.0) * away for k, name in enumerate(names)}
    found = as_clicked(scene, true, expected)
    for k, name in enumerate(names):
        if k % 2:
            np.testing.assert_array_equal(found[name], expected[name])
        else:
            assert np.linalg.norm(found[name] - true[name]) == pytest.approx(CLICK_ERROR, rel=0.5)
    assert as_clicked(scene, true, {}).keys() == true.keys(), "nothing was shown"

"""The study of checks: what is promised is the posterior's, and the numbers of fits are what they are called."""

import re
from pathlib import Path

import numpy as np
import pytest
from helpers.cohort import write_patient

from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig_studies.studies.case import Scene, read_scene
from breastrig_studies.studies.landmarks import CLICK_ERROR
from breastrig_studies.studies.trust.checked import ALL, COLUMNS, WHO, as_clicked, checked, chosen, summary


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


@pytest.mark.slow
def test_a_row_has_every_column_and_a_summary_reads_them(scene: Scene, tmp_path: Path) -> None:
    row = checked(scene, read_rig(default_rig_path()), load_recipe("default"))
    assert row is not None
    assert {*row} == {*COLUMNS} - {*WHO} | {"checks"}
    assert len(str(row["checks"]).split()) == 2
    assert row["none_stated_mm"] >= row["promised_one_mm"] >= row["promised_two_mm"] > 0.0
    assert row["all_stated_mm"] < row["none_stated_mm"]
    assert 0.0 < float(row["two_off_mm"]) < 30.0
    assert 0.0 <= float(row["two_held"]) <= 1.0
    said = "\n".join(summary([row | {"stance": "standing", "patient": "p", "cohort": "c"}] * 3))
    assert "standing, 3 scans" in said
    assert re.search(rf"two +{row['two_stated_mm']:.1f} mm +{row['two_off_mm']:.1f}", said)

"""The tracked bodies of the virtual cohort are what they are said to be; they are not made again here."""

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from torso_rules import LANDMARKS
from virtual_patient.size import girth
from virtual_patient.woman import AVERAGE, OLDEST, YOUNGEST, figure
from virtual_patient.women import WOMEN

from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig_studies.virtual.bodies import Bodies, VirtualBody, VirtualPatient, closed, cohort_folder, read_bodies


@pytest.fixture(scope="module")
def bodies() -> Bodies:
    return read_bodies()


def test_seven_adults_as_in_the_paper(bodies: Bodies) -> None:
    assert [patient.name for patient in bodies.patients] == [f"patient_{k}" for k in range(1, 8)]
    ages = [patient.about["age_years"] for patient in bodies.patients]
    assert min(ages) >= 30
    assert max(ages) <= 70
    sizes = [patient.about["size"] for patient in bodies.patients]
    assert (sizes[0], sizes[-1]) == ("95A", "110C")
    assert {size[-1] for size in sizes} == {"A", "B", "C"}
    assert len(set(sizes)) == 7


def test_the_recipe_is_of_adults_and_is_what_was_stored(bodies: Bodies) -> None:
    for woman, patient in zip(WOMEN, bodies.patients, strict=True):
        assert YOUNGEST <= woman.years <= OLDEST
        assert (woman.name, woman.size, woman.years) == (
            patient.name,
            patient.about["size"],
            patient.about["age_years"],
        )
        assert sum(woman.origin) == pytest.approx(1.0)
        assert not any(word in name for name, _ in woman.details for word in ("child", "baby"))


def test_nobody_younger_than_an_adult_is_made() -> None:
    with pytest.raises(ValueError, match="only adults"):
        figure(None, replace(AVERAGE, years=24.0))


def test_the_tape_finds_the_band_on_the_stored_skin(bodies: Bodies) -> None:
    for patient in bodies.patients:
        standing = patient.bodies[0]
        volumes = patient.about["breast_volume_ml"]
        side = max(volumes, key=volumes.get)
        trunk = np.abs(standing.vertices[:, 0]) < 0.6 * np.abs(standing.landmarks[f"acromion_{side}"][0]) + 0.07
        fold = standing.landmarks[f"inframammary_fold_{side}"][1]
        found = 100.0 * girth(standing.vertices, bodies.faces, trunk, fold - 0.005, side)
        assert found == pytest.approx(int(patient.about["size"][:-1]) - 15, abs=2.5)
        assert patient.about["under_bust_cm"] == pytest.approx(found, abs=2.0)


def each(bodies: Bodies) -> list[tuple[VirtualPatient, VirtualBody]]:
    return [(patient, body) for patient in bodies.patients for body in patient.bodies]


def test_landmarks_lie_on_the_skin_and_left_is_left(bodies: Bodies) -> None:
    for _, body in each(bodies):
        marks = body.landmarks
        assert set(marks) == set(LANDMARKS)
        found = ClosestPointSearch(body.vertices, bodies.faces).query(np.array(list(marks.values())))
        assert found.distances.max() < 1e-6
        for name in ("nipple", "acromion", "midclavicle", "inframammary_fold"):
            assert marks[f"{name}_L"][0] > 0.02
            assert marks[f"{name}_R"][0] < -0.02
        heights = [marks[name][1] for name in ("suprasternal_notch", "mid_sternum", "inframammary_fold_L", "umbilicus")]
        assert heights == sorted(heights, reverse=True)
        assert marks["nipple_L"][1] > marks["inframammary_fold_L"][1]


def test_a_lid_closes_every_opening_and_moves_no_skin(bodies: Bodies) -> None:
    body = bodies.patients[0].bodies[0]
    vertices, faces = closed(body.vertices, bodies.faces)
    np.testing.assert_array_equal(vertices[: len(body.vertices)], body.vertices)
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert (uses == 2).all()


def test_the_readme_names_the_files_that_are_there(model_assets: Path) -> None:
    said = (model_assets / "README.md").read_text("utf-8")
    for name in ("bodies.npz", "patients.json"):
        found = hashlib.sha256((cohort_folder() / name).read_bytes()).hexdigest()
        assert f"| `cohort/{name}` | `{found}` |" in said

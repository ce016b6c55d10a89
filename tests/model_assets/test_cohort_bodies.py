"""The tracked bodies of the virtual cohort are what they are said to be; they are not made again here."""

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from virtual_patient.size import girth
from virtual_patient.woman import AVERAGE, OLDEST, YOUNGEST, figure
from virtual_patient.women import WOMEN

from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import face_normals, vertex_normals
from breastrig.geometry.rays import RayCaster
from breastrig.rig.validation.torso import LANDMARKS
from breastrig_studies.virtual.bodies import Bodies, VirtualBody, VirtualPatient, closed, cohort_folder, read_bodies

SKIN_TO_SKIN = 2e-4  # m, where a ray from the skin begins, so that it does not hit its own triangle


@pytest.fixture(scope="module")
def bodies() -> Bodies:
    return read_bodies()


def chest_frame(body: VirtualBody) -> np.ndarray:
    """(3, 3), columns: her left, her head, her front, by the landmarks of the chest."""
    marks = body.landmarks
    head = marks["suprasternal_notch"] - marks["xiphoid"]
    left = marks["acromion_L"] - marks["acromion_R"]
    front = np.cross(left, head)
    left = np.cross(head, front)
    return np.stack([axis / np.linalg.norm(axis) for axis in (left, head, front)], axis=1)


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


def test_local_targets_are_not_those_of_our_own_shapes(model_assets: Path) -> None:
    """But the navel, which without its hollow would be no landmark."""
    recipe = (model_assets / "recipe.toml").read_text("utf-8")
    details = {name for woman in WOMEN for name, _ in woman.details}
    assert {name for name in details if f'"{name}"' in recipe} == {"stomach/stomach-navel-in"}


def test_one_asymmetry_is_marked_and_only_one(bodies: Bodies) -> None:
    for patient in bodies.patients:
        volumes = patient.about["breast_volume_ml"]
        smaller, larger = sorted(volumes.values())
        if patient.about["marked_asymmetry"]:
            assert larger > 2.0 * smaller
        else:
            assert larger < 1.1 * smaller
    assert sum(patient.about["marked_asymmetry"] for patient in bodies.patients) == 1


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


def test_the_files_are_small() -> None:
    assert (cohort_folder() / "bodies.npz").stat().st_size < 1_000_000


def each(bodies: Bodies) -> list[tuple[VirtualPatient, VirtualBody]]:
    return [(patient, body) for patient in bodies.patients for body in patient.bodies]


def test_bodies_have_human_size_and_no_vertex_is_lost(bodies: Bodies) -> None:
    assert set(np.unique(bodies.faces)) == set(range(len(bodies.scanned)))
    for _, body in each(bodies):
        assert body.vertices.shape == (len(bodies.scanned), 3)
        assert np.isfinite(body.vertices).all()
        assert 0.45 < np.ptp(body.vertices[:, 1]) < 0.75
        assert 0.2 < np.ptp(body.vertices[:, 2]) < 0.4


def test_the_skin_nowhere_goes_through_itself(bodies: Bodies) -> None:
    """Seen from just above each point of the skin, the next surface outwards is met from its outside."""
    for patient, body in each(bodies):
        vertices, faces = closed(body.vertices, bodies.faces)
        outwards = vertex_normals(vertices, faces)[: len(body.vertices)]
        hit, _ = RayCaster(vertices, faces).first_hits(body.vertices + SKIN_TO_SKIN * outwards, outwards, 1.0)
        from_within = np.einsum("mi,mi->m", face_normals(vertices, faces)[hit], outwards) > 0.0
        assert not (from_within & (hit >= 0)).any(), (patient.name, body.stance)


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


def test_lying_down_breasts_flatten_and_slide_outwards_and_to_the_head(bodies: Bodies) -> None:
    """In the frame of the chest of each stance, from the middle of the breastbone to each nipple."""
    for patient in bodies.patients:
        tips = {}
        for body in patient.bodies:
            frame, middle = chest_frame(body), body.landmarks["mid_sternum"]
            places = np.array([body.landmarks[f"nipple_{side}"] - middle for side in ("L", "R")])
            tips[body.stance] = places @ frame * [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]]  # outwards, to the head, forwards
        change = tips["supine"] - tips["standing"]
        assert (change[:, 0] > 0.004).all(), patient.name
        assert (change[:, 1] > 0.001).all(), patient.name
        assert (change[:, 2] < -0.001).all(), patient.name


def test_larger_breasts_move_more_when_lying_down(bodies: Bodies) -> None:
    """All nipples of all women: their way grows with the volume of their breast."""
    ways, volumes = [], []
    for patient in bodies.patients:
        for side in ("L", "R"):
            tips = [body.landmarks[f"nipple_{side}"] - body.landmarks["mid_sternum"] for body in patient.bodies]
            frames = [chest_frame(body) for body in patient.bodies]
            ways.append(np.linalg.norm(tips[1] @ frames[1] - tips[0] @ frames[0]))
            volumes.append(patient.about["breast_volume_ml"][side])
    assert np.corrcoef(ways, volumes)[0, 1] > 0.8


def test_buttocks_and_ribcage_rest_on_the_table_and_the_waist_bridges_it(bodies: Bodies) -> None:
    for patient in bodies.patients:
        standing, supine = patient.bodies
        assert standing.table is None
        assert supine.table is not None
        gap = supine.vertices[:, 2] - supine.table
        assert gap.min() > 0.0
        navel = supine.landmarks["umbilicus"][1]
        back = bodies.scanned & (np.abs(supine.vertices[:, 0]) < 0.15)
        below, waist, above = (
            gap[back & (supine.vertices[:, 1] > low) & (supine.vertices[:, 1] < high)].min()
            for low, high in ((-1.0, navel - 0.07), (navel + 0.01, navel + 0.06), (navel + 0.12, 1.0))
        )
        assert max(below, above) < 0.003, patient.name
        assert 0.005 < waist < 0.05, patient.name
        assert (gap < 0.008).sum() > 0.05 * len(gap)


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

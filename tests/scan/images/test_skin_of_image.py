from dataclasses import replace

import numpy as np
import pytest
import trimesh
from helpers.mr_image import mr_image

from breastrig.core.errors import BadScan
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.scan.images.image import ImageVolume
from breastrig.scan.images.skin import cells, skin_of_image
from breastrig.scan.images.skin.nipples import nipples_on
from breastrig_studies.virtual.magnetic.coverage import coverage
from breastrig_studies.virtual.magnetic.image import PLAIN, MrImage
from breastrig_studies.virtual.magnetic.image import mr_image as image_of
from breastrig_studies.virtual.magnetic.woman import prone_woman

FAR = 4.0  # mm: false skin, and skin that was missed
COARSE = 4.0  # mm, voxels: a question that they answer as finer ones do takes half as long


def off(made: MrImage, skin: skin_of_image.ImageSkin) -> np.ndarray:
    """(F,) mm from the middles of the triangles to the true skin."""
    return ClosestPointSearch(made.vertices, made.faces).query(skin.vertices[skin.faces].mean(axis=1)).distances


def missed(made: MrImage, skin: skin_of_image.ImageSkin) -> np.ndarray:
    """(N, 3) mm, places of the true skin within the image that no skin is near."""
    middles = made.vertices[made.faces].mean(axis=1)
    at = np.linalg.solve(made.image.affine[:3, :3], (middles - made.image.affine[:3, 3]).T).T
    seen = middles[((at > 2.0) & (at < np.array(made.image.values.shape) - 3.0)).all(axis=1)]
    return seen[ClosestPointSearch(skin.vertices, skin.faces).query(seen).distances > FAR]


def lateral(skin: skin_of_image.ImageSkin) -> int:
    """Triangles of the arms, under the shoulders."""
    middles = skin.vertices[skin.faces].mean(axis=1)
    return int(((np.abs(middles[:, 0]) > 160.0) & (middles[:, 2] < 400.0)).sum())


def found(made: MrImage) -> skin_of_image.ImageSkin:
    return skin_of_image.skin_of_image(made.image)


@pytest.mark.parametrize(
    ("option", "step", "within"),
    [
        ("plain", COARSE, 0.8),
        ("fat suppressed", 3.0, 1.5),
        ("visible board", 3.0, 0.8),
        ("one coil half at 30 %", COARSE, 1.2),
        ("all of the back", COARSE, 1.2),
    ],
)
def test_the_skin_is_the_womans(option, step, within):
    made = mr_image(option, step=step)
    skin = found(made)
    away = off(made, skin)
    assert np.quantile(away, 0.95) < within
    assert (away > FAR).mean() < (0.01 if option == "fat suppressed" else 0.002)
    away = missed(made, skin)
    assert not len(away) or (option == "all of the back" and away[:, 1].min() > made.nipples["L"][1] + 150.0)
    normals = trimesh.Trimesh(skin.vertices, skin.faces, process=False).face_normals
    front = skin.vertices[skin.faces].mean(axis=1)[:, 1] < made.nipples["L"][1] + 15.0
    turned = normals[front & (np.abs(normals[:, 1]) > 0.5)][:, 1] > 0.0  # inwards
    assert turned.mean() < (0.02 if option == "fat suppressed" else 1e-9)  # nipples on dark fat


def test_fine_voxels_give_triangles_of_two_millimetres_within_half_of_one_and_nipples_on_their_sides():
    made = mr_image("plain", seed=1, step=1.5)
    skin = found(made)
    assert np.quantile(off(made, skin), 0.95) < 0.5
    assert 1.0 < np.median(trimesh.Trimesh(skin.vertices, skin.faces).edges_unique_length) < 2.5
    assert skin.notes == ()
    assert [each.side for each in skin.nipples] == ["L", "R"]
    for each in skin.nipples:
        assert np.linalg.norm(each.place - made.nipples[each.side]) < each.radius_mm


def test_the_order_of_the_voxels_does_not_matter():
    made = mr_image("plain", step=COARSE)
    other, affine = made.image.values.swapaxes(0, 1), made.image.affine[:, [1, 0, 2, 3]]
    skin = skin_of_image.skin_of_image(ImageVolume(np.ascontiguousarray(other), affine))
    assert np.quantile(off(made, skin), 0.95) < 0.8
    normals = trimesh.Trimesh(skin.vertices, skin.faces, process=False).face_normals
    assert normals[:, 1].mean() < -0.2


def test_fat_that_is_suppressed_has_its_edge_at_half_of_the_skins_signal(monkeypatch):
    made = mr_image("fat suppressed", seed=3, step=COARSE)
    own = off(made, found(made)).mean()
    monkeypatch.setattr(skin_of_image, "ISO_OF_DARK", cells.ISO)
    assert off(made, found(made)).mean() > 1.5 * own


def strong(**changes) -> MrImage:
    woman = prone_woman(2)
    return image_of(woman, replace(PLAIN, steps=(COARSE, COARSE, COARSE), **changes), 2)


def test_ghosts_are_weaker_than_what_is_around(monkeypatch):
    made = mr_image("motion ghosts", seed=0, step=COARSE)
    assert found(made).notes == ()
    assert not len(missed(made, found(made)))
    monkeypatch.setattr(cells, "LEAST", 0.0)
    monkeypatch.setattr(cells, "OF_ROW", 0.0)
    assert len(missed(made, found(made))) > 50


def test_strong_ghosts_are_no_skin_beside_the_trunk(monkeypatch):
    made = mr_image("strong motion ghosts", seed=41)
    skin = found(made)
    assert not any(note.startswith("Beside the trunk") for note in skin.notes)
    assert (off(made, skin) > FAR).mean() < 0.005
    assert all(np.linalg.norm(each.place - made.nipples[each.side]) < each.radius_mm for each in skin.nipples)
    monkeypatch.setattr(cells, "OF_ROW", 0.0)
    assert any(note.startswith("Beside the trunk") for note in found(made).notes)


def test_a_back_that_fades_into_noise_is_open_and_said(monkeypatch):
    made = mr_image("faded back", seed=41)
    skin = found(made)
    assert skin_of_image.FADED in skin.notes
    assert (off(made, skin) > FAR).mean() < 0.005
    away = missed(made, skin)
    assert not (away[:, 1] < made.nipples["L"][1] + 100.0).any()
    monkeypatch.setattr(cells, "SEEN", 0.0)
    assert (off(made, found(made)) > FAR).mean() > 0.1


def test_noise_opens_no_way_into_the_lungs(monkeypatch):
    made = strong(noise=0.07)
    assert (off(made, found(made)) > FAR).mean() < 0.06
    monkeypatch.setattr(cells, "SMOOTH", 0.01)
    assert (off(made, found(made)) > FAR).mean() > 0.2


def test_a_scanners_air_of_zero_tells_no_noise(monkeypatch):
    made = mr_image("air set to 0", seed=0, step=2.0)
    assert not len(missed(made, found(made)))
    monkeypatch.setattr(cells, "CUT", 1.1)
    assert len(missed(made, found(made))) > 50


def test_patches_without_a_step_from_air_to_tissue_are_left_open(monkeypatch):
    made = strong(fades=40.0, back=True)
    monkeypatch.setattr(cells, "SEEN", 0.0)
    skin = found(made)
    share = (off(made, skin) > FAR).mean()
    assert any("fades into noise" in note for note in skin.notes)
    monkeypatch.setattr(skin_of_image, "WITHOUT_STEP", np.inf)
    assert (off(made, found(made)) > FAR).mean() > 1.5 * share


def test_arms_that_touch_the_trunk_are_left_open(monkeypatch):
    made = mr_image("arms touch", step=COARSE)
    skin = found(made)
    assert any(note.startswith("Beside the trunk") for note in skin.notes)
    beside = lateral(skin)
    monkeypatch.setattr(skin_of_image, "ARM", np.inf)
    whole = found(made)
    assert whole.notes == ()
    assert beside < 0.25 * lateral(whole)
    assert not (missed(made, skin)[:, 1] < made.nipples["L"][1] + 60.0).any()  # both breasts are whole


def test_missing_slices_are_open():
    made = mr_image("slices missing", step=COARSE)
    gap, affine = made.image.gaps[0], made.image.affine
    low, high = (affine[2, 3] + affine[2, 2] * at for at in (gap.first, gap.last))
    z = found(made).vertices[:, 2]
    assert not ((z > low) & (z < high)).any()
    assert z.min() < low - 20.0
    assert z.max() > high + 20.0


def test_one_side_says_where_the_image_ends():
    assert found(mr_image("one side", step=COARSE)).notes == (skin_of_image.EDGE.format("right"),)


def test_where_fat_is_suppressed_no_nipple_is_proposed_and_it_is_said():
    skin = found(mr_image("fat suppressed"))
    assert skin.nipples == ()
    assert skin_of_image.NO_NIPPLES in skin.notes


def test_one_side_shows_one_nipple():
    assert [each.side for each in found(mr_image("one side", step=COARSE)).nipples] == ["L"]


@pytest.mark.parametrize("bumps", [(), ((-20.0, 0.0), (20.0, 0.0))])
def test_no_nipple_is_seen_without_a_bump_or_with_two_alike(bumps):
    ball = trimesh.creation.icosphere(5, 60.0)
    places = np.asarray(ball.vertices)
    for x, z in bumps:
        away = np.linalg.norm(places[:, [0, 2]] - [x, z], axis=1)
        places = places + np.where(places[:, 1] < 0.0, 5.0 * np.exp(-((away / 5.0) ** 2)), 0.0)[:, None] * [0, -1.0, 0]
    assert nipples_on(places + np.array([90.0, 0.0, 0.0]), np.asarray(ball.faces), 0.0) == ()


@pytest.mark.parametrize("kind", ["noise", "constant", "nothing"])
def test_an_image_of_air_alone_is_refused(kind):
    values = {
        "noise": np.random.default_rng(3).rayleigh(20.0, (60, 50, 40)),
        "constant": np.full((30, 30, 30), 7),
        "nothing": np.zeros((30, 30, 30), np.int16),
    }[kind]
    with pytest.raises(BadScan, match="shows no skin with air in front"):
        skin_of_image.skin_of_image(ImageVolume(values, np.diag([2.0, 2.0, 2.0, 1.0])))


@pytest.mark.parametrize("kind", ["leg", "head", "ball", "speck", "slab", "thin"])
def test_what_is_no_breast_has_a_skin_or_is_refused(kind):
    shape, random = (50, 60, 40), np.random.default_rng(4)
    low, steps = np.array([-75.0, -90.0, -60.0]), np.full(3, 3.0)
    body = {
        "leg": trimesh.creation.cylinder(45.0, 400.0),
        "head": trimesh.creation.icosphere(3, 60.0),
        "ball": trimesh.creation.icosphere(3, 25.0),
        "speck": trimesh.creation.icosphere(1, 2.0),
        "slab": trimesh.creation.box([400.0, 50.0, 400.0]),
        "thin": trimesh.creation.box([400.0, 3.0, 400.0]),
    }[kind]
    share = coverage(np.asarray(body.vertices), np.asarray(body.faces), low, steps, shape)
    values = np.hypot(500.0 * share + 8.0 * random.standard_normal(shape), 8.0 * random.standard_normal(shape))
    affine = np.diag([3.0, 3.0, 3.0, 1.0])
    affine[:3, 3] = low
    try:
        skin = skin_of_image.skin_of_image(ImageVolume(values.astype(np.float32), affine))
    except BadScan:
        assert kind in ("speck", "thin")
        return
    assert np.isfinite(skin.vertices).all()
    assert skin.faces.max() < len(skin.vertices)

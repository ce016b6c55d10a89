import numpy as np
import pytest
import trimesh
from helpers.mr_image import mr_image

from breastrig_studies.virtual.magnetic.coverage import coverage
from breastrig_studies.virtual.magnetic.woman import prone_woman


def test_a_ball_covers_its_volume():
    ball = trimesh.creation.icosphere(4, 10.0)
    low, steps = np.array([-15.0, -14.0, -13.0]), np.array([1.0, 2.0, 1.5])
    share = coverage(np.asarray(ball.vertices), np.asarray(ball.faces), low, steps, (31, 15, 19))
    assert share.sum() * steps.prod() == pytest.approx(ball.volume, rel=2e-3)
    middle = np.argwhere(share > 0.999) * steps + low
    assert np.linalg.norm(middle, axis=1).max() < 10.0


def test_what_two_bodies_share_counts_once():
    box = trimesh.creation.box([10.0, 10.0, 10.0])
    two = trimesh.util.concatenate([box, box.copy().apply_translation([2.5, 0.0, 0.0])])
    share = coverage(np.asarray(two.vertices), np.asarray(two.faces), np.full(3, -9.5), np.ones(3), (20, 20, 20))
    assert share.max() == 1.0
    assert share.sum() == pytest.approx(1250.0, rel=1e-3)


def test_a_woman_is_closed_and_her_nipples_are_in_front():
    woman = prone_woman(3)
    assert trimesh.Trimesh(woman.vertices, woman.faces, process=False).is_volume
    for side, sign in (("L", 1.0), ("R", -1.0)):
        nipple, breast = woman.nipples[side], woman.vertices[sign * woman.vertices[:, 0] > 20.0]
        assert nipple[1] < breast[:, 1].min() + 15.0


@pytest.mark.parametrize("option", ["plain", "folded over"])
def test_images_are_whole_numbers_with_the_lesion_inside(option):
    made = mr_image(option)
    values = made.image.values
    assert values.dtype == np.int16
    assert made.lesion.shape == values.shape
    middle = np.argwhere(made.lesion).mean(axis=0) @ made.image.affine[:3, :3].T + made.image.affine[:3, 3]
    np.testing.assert_allclose(middle, made.lesion_at, atol=1.0)
    assert values[made.lesion].min() > 4 * np.median(values[:, 1])  # air in front of her

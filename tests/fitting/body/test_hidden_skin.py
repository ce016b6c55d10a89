"""Skin that no scan shows: where it is expected above the model, and that the layer goes over into it."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.refine import HiddenSkin, hidden_skin, refined
from breastrig.geometry.normals import vertex_normals
from breastrig.rig.model import Rig
from breastrig_studies.bodies.hidden_skin import about_the_back, agreed_form, estimated


@pytest.fixture(scope="module")
def heights(torso: Rig) -> Array:
    known = hidden_skin(torso, "standing")
    assert known is not None
    return known


def front(rig: Rig) -> ScanTarget:
    """A scan of the template from the front."""
    faces = rig.faces[(vertex_normals(rig.template, rig.faces)[rig.faces][:, :, 2] > 0.2).all(axis=1)]
    used, triangles = np.unique(faces, return_inverse=True)
    return ScanTarget(rig.template[used], triangles.reshape(-1, 3))


def test_both_sides_are_alike_and_the_front_is_not_hidden(torso: Rig, heights: Array) -> None:
    np.testing.assert_allclose(heights[torso.mirror_vertices], heights, atol=0.5e-3)
    assert 1e-3 < np.abs(heights).max() < 0.012
    breasts = np.concatenate([torso.regions["areola_L"], torso.regions["areola_R"]])
    assert np.abs(heights[breasts]).max() < 1e-4


def test_of_lying_bodies_the_form_of_the_back_is_known_and_not_how_high_it_lies(torso: Rig) -> None:
    known = hidden_skin(torso, "supine")
    np.testing.assert_allclose(known[torso.mirror_vertices], known, atol=0.5e-3)
    back = known[torso.regions["back"]]
    assert np.abs(back).max() > 2e-3
    assert abs(back.mean()) < 0.5e-3
    breasts = np.concatenate([torso.regions["areola_L"], torso.regions["areola_R"]])
    assert np.abs(known[breasts]).max() < 1e-4


def test_nothing_is_known_of_other_rigs(torso: Rig) -> None:
    assert hidden_skin(replace(torso, known={}), "standing") is None


def test_the_layer_goes_over_into_hidden_skin_and_leaves_what_is_seen(torso: Rig, heights: Array) -> None:
    scan = front(torso)
    plain = refined(scan, torso.template, torso.faces)
    layer = refined(scan, torso.template, torso.faces, heights)
    gap = scan.vertex_tree.query(torso.template)[0]
    change = np.abs(layer.displacement - plain.displacement)[gap < 1e-9]
    assert np.percentile(change, 95) < 1e-6
    assert change.max() < 0.5e-3  # at the scan's rim, which is not matched
    far = (gap > 0.06) & (np.abs(heights) > 1e-3)
    assert far.sum() > 50
    np.testing.assert_allclose(layer.displacement[far], heights[far], rtol=0.03, atol=0.1e-3)


def test_a_triangle_that_would_turn_over_stays_as_it_is(torso: Rig) -> None:
    spike = np.zeros(len(torso.template))
    spike[torso.regions["back"][::3]] = -0.2
    layer = refined(front(torso), torso.template, torso.faces, spike)
    assert np.abs(layer.displacement[torso.regions["back"]]).max() < 0.2


def test_heights_do_not_go_over_from_an_arm_to_the_trunk_beside_it() -> None:
    skin = HiddenSkin(np.array([[0.1, 0.0, 0.0]]), np.array([[-1.0, 0.0, 0.0]]), np.array([0.005]))
    template = np.array([[0.1, 0.0, 0.0], [0.1, 0.0, 0.0], [-0.1, 0.0, 0.0]])
    normals = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    np.testing.assert_allclose(skin.at(template, normals), [0.005, 0.0, 0.005], atol=1e-12)


def test_sources_count_alike_however_many_bodies_each_has(torso: Rig) -> None:
    everywhere = np.ones(len(torso.template), dtype=np.bool_)
    low, high = np.full(len(torso.template), 0.001), np.full(len(torso.template), 0.003)
    skin = estimated(torso, {"ours": [(everywhere, low)] * 3, "given": [(everywhere, high)]})
    np.testing.assert_allclose(skin.heights, 0.002, atol=1e-9)


def test_how_high_a_whole_back_lies_is_not_estimated_but_its_form_is(torso: Rig) -> None:
    hidden = np.zeros(len(torso.template), dtype=np.bool_)
    hidden[torso.regions["back"]] = True
    form = np.where(hidden, 0.1 * (torso.template[:, 1] - torso.template[hidden, 1].mean()), 0.0)
    for high in (-0.02, 0.0, 0.02):
        np.testing.assert_allclose(about_the_back(torso, hidden, np.where(hidden, form + high, 0.0)), form, atol=1e-12)
    alone = estimated(torso, {"ours": [(hidden, form)]})
    both = agreed_form(torso, {"ours": [(hidden, form + 0.02)], "given": [(hidden, form - 0.02)]})
    np.testing.assert_allclose(both.heights, alone.heights, atol=1e-12)
    assert np.abs(both.heights).max() > 0.01


@pytest.mark.slow
def test_of_supine_bodies_only_what_the_sources_agree_on_is_estimated(torso: Rig) -> None:
    hidden = np.ones(len(torso.template), dtype=np.bool_)
    back = np.isin(np.arange(len(hidden)), torso.regions["back"])
    form = np.where(back, torso.template[:, 1] - torso.template[back, 1].mean(), 0.0)
    against = agreed_form(torso, {"ours": [(hidden, 0.02 * form)], "given": [(hidden, -0.05 * form)]})
    assert not against.heights.any()
    alike = agreed_form(torso, {"ours": [(hidden, 0.02 * form)], "given": [(hidden, 0.05 * form)]})
    weaker = estimated(torso, {"ours": [(hidden, 0.02 * form)]})
    np.testing.assert_allclose(alike.heights, weaker.heights, atol=1e-12)

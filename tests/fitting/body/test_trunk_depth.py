"""A deep trunk that lies on its back: its hidden skin is farther back, but never through the table."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.refine import TrunkDepth, hidden_skin, skin_behind, trunk_depth
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.plane import Plane
from breastrig.rig.model import Rig
from breastrig_studies.bodies.trunk_depth import Body, estimated

FORWARD = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def known(torso: Rig) -> TrunkDepth:
    found = trunk_depth(torso)
    assert found is not None
    return found


def table_below(rig: Rig, belly: float) -> Plane:
    """Above which the template's belly lies at this height (m)."""
    return Plane(FORWARD, float(rig.template[rig.regions["belly"], 2].mean()) - belly)


def nothing(rig: Rig) -> Array:
    return np.zeros(len(rig.template))


def test_the_higher_the_belly_lies_the_deeper_is_the_back_and_nothing_else(torso: Rig, known: TrunkDepth) -> None:
    low, high = (
        known.added(torso, table_below(torso, known.ordinary + more), torso.template, nothing(torso))
        for more in (0.01, 0.02)
    )
    back = torso.regions["back"]
    assert low[back].mean() > 0.002
    np.testing.assert_allclose(high, 2.0 * low, atol=1e-12)
    np.testing.assert_allclose(high[torso.mirror_vertices], high, atol=0.5e-3)
    breasts = np.concatenate([torso.regions["areola_L"], torso.regions["areola_R"]])
    assert np.abs(high[breasts]).max() < 1e-4


def test_of_ordinary_trunks_nothing_is_said(torso: Rig, known: TrunkDepth) -> None:
    for less in (1e-6, 0.01, 0.05):
        assert not known.added(torso, table_below(torso, known.ordinary - less), torso.template, nothing(torso)).any()


def test_a_belly_that_lies_higher_than_any_counts_as_the_highest(torso: Rig, known: TrunkDepth) -> None:
    far = replace(known, reach=10.0)
    most, more = (
        far.added(torso, table_below(torso, known.ordinary + known.most + excess), torso.template, nothing(torso))
        for excess in (0.0, 0.1)
    )
    np.testing.assert_allclose(most, more, atol=1e-12)


def test_nothing_goes_through_the_table(torso: Rig, known: TrunkDepth) -> None:
    steep = replace(known, slopes=np.full(len(torso.template), 100.0))
    table = table_below(torso, known.ordinary + 0.02)
    normals = vertex_normals(torso.template, torso.faces)
    down = normals @ FORWARD < -0.2  # others hardly come nearer to the table
    for expected in (nothing(torso), np.full(len(torso.template), 0.004)):
        moved = torso.template + (expected + steep.added(torso, table, torso.template, expected))[:, None] * normals
        above = moved @ table.normal - table.height
        before = (torso.template + expected[:, None] * normals) @ table.normal - table.height
        assert (above[down] > np.minimum(before[down], 0.0) - 1e-9).all()
        assert (np.abs(above[down & (before > 0.0)]) < 1e-9).all()


def test_a_plane_far_behind_the_back_is_no_table(torso: Rig, known: TrunkDepth) -> None:
    assert not known.added(torso, table_below(torso, 0.40), torso.template, nothing(torso)).any()


def test_only_a_supine_body_on_a_visible_table_is_changed_by_it(torso: Rig, known: TrunkDepth) -> None:
    table = table_below(torso, known.ordinary + 0.02)
    on_it, without = ScanTarget(torso.template, torso.faces, table=table), ScanTarget(torso.template, torso.faces)
    lying, standing = hidden_skin(torso, "supine"), hidden_skin(torso, "standing")
    np.testing.assert_array_equal(skin_behind(torso, "supine", without, torso.template), lying)
    np.testing.assert_array_equal(skin_behind(torso, "standing", on_it, torso.template), standing)
    behind = skin_behind(torso, "supine", on_it, torso.template)
    assert behind is not None
    np.testing.assert_array_equal(behind, lying + known.added(torso, table, torso.template, lying))
    assert trunk_depth(replace(torso, known={})) is None
    assert skin_behind(replace(torso, known={}), "supine", on_it, torso.template) is None


def test_the_slope_is_estimated_of_deep_trunks_and_every_woman_counts_alike(torso: Rig) -> None:
    everywhere = np.ones(len(torso.template), dtype=np.bool_)
    deep, deeper = (Body(10.0, everywhere, np.full(len(torso.template), height)) for height in (2.0, 4.0))
    ordinary = Body(0.0, everywhere, np.full(len(torso.template), -0.03))
    document = estimated(torso, {"one": [deep] * 3, "other": [deeper], "third": [ordinary]})
    np.testing.assert_allclose(document["slopes"], 0.3, atol=1e-4)  # so deep that nothing is damped
    assert document["bodies"] == {"one": 3, "other": 1, "third": 1}


def test_what_some_of_the_scans_show_is_estimated_in_part(torso: Rig) -> None:
    everywhere, height = np.ones(len(torso.template), dtype=np.bool_), np.full(len(torso.template), 5.0)
    document = estimated(torso, {"one": [Body(10.0, everywhere, height)], "other": [Body(10.0, ~everywhere, height)]})
    np.testing.assert_allclose(document["slopes"], 0.25, atol=1e-4)


def test_one_woman_who_is_hardly_deep_tells_little(torso: Rig) -> None:
    everywhere = np.ones(len(torso.template), dtype=np.bool_)
    document = estimated(torso, {"one": [Body(0.001, everywhere, np.full(len(torso.template), 0.008))]})
    assert np.abs(document["slopes"]).max() < 0.05

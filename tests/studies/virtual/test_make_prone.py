"""Prone warped bodies: breasts that hang to the front, in the field of view of an MRI."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.warped.body import WarpedBody
from breastrig_studies.virtual.warped.numbers import Numbers
from breastrig_studies.virtual.warped.prone import Donor, ProneNumbers, arm_share, mri_scan, prone_skin
from breastrig_studies.virtual.warped.sources import read_sources

NUMBERS = ProneNumbers(2.0, 1.0, 1.0, (0.0, 0.0), 1.0, 1.0, False, 0.0, 0.03, 0.0, 0.0005, False)


@pytest.fixture(scope="module")
def standing() -> WarpedBody:
    source = read_sources()[0]
    body = VirtualBody("standing", source.standing, source.landmarks(source.standing), None)
    return WarpedBody(source, Numbers(), "supine", 1, body, body)


def test_a_donors_own_motion_comes_out_enlarged_and_the_scan_has_no_arms(standing: WarpedBody) -> None:
    source, places = standing.source, standing.standing.landmarks
    away = source.standing - places["nipple_L"]
    motion = 0.02 * np.exp(-0.5 * (away**2).sum(axis=1) / 0.04**2)[:, None] * np.array([0.0, 0.0, 1.0])
    donor = Donor("herself", source.standing, source.faces, motion, places)
    arms = arm_share(read_rig(default_rig_path()), standing)
    skin = prone_skin(standing, donor, NUMBERS, arms)
    moved = source.landmarks(skin)
    assert moved["nipple_L"][2] - places["nipple_L"][2] == pytest.approx(0.04, abs=0.008)  # what is carried is smoothed
    np.testing.assert_allclose(moved["nipple_R"], places["nipple_R"], atol=0.001)
    fuller = prone_skin(standing, donor, replace(NUMBERS, poles=(0.01, -0.01)), arms) - skin
    assert fuller[:, 2].max() == pytest.approx(0.01, abs=0.001)
    assert fuller[:, 2].min() == pytest.approx(-0.01, abs=0.001)
    body = VirtualBody("prone", skin, moved, None)
    scan = mri_scan(body, source.faces, arms, NUMBERS, np.random.default_rng(1))
    assert np.abs(scan.vertices[:, 0]).max() < moved["acromion_L"][0] + 0.04
    assert scan.vertices[:, 1].max() < moved["suprasternal_notch"][1] + 0.005
    assert scan.vertices[:, 1].min() > moved["inframammary_fold_L"][1] - 0.05
    near = np.linalg.norm(scan.vertices - moved["nipple_L"], axis=1).min()
    assert near < 0.005

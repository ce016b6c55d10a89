"""Prone scans of women who were solved under gravity."""

from pathlib import Path

import numpy as np
import pytest

from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.volume.breast_skin import breast_skins
from breastrig_studies.gravity.prone_scans import hanging_skin


def test_both_breasts_hang_as_mirror_images_and_farther_than_computed(tmp_path: Path) -> None:
    rig = read_rig(default_rig_path())
    left = breast_skins(rig)[0]
    prone = np.where(left.breast, 0.02, 0.0)[:, None] * np.array([0.1, 0.0, 1.0])
    np.savez(tmp_path / "0000.npz", given=rig.template, prone_skin=prone)
    moved = hanging_skin(rig, tmp_path / "0000.npz", 3.0) - rig.template
    nipples = [rig.regions[f"areola_{side}"][0] for side in "LR"]
    np.testing.assert_allclose(moved[nipples], [[0.002, 0.0, 0.06], [-0.002, 0.0, 0.06]], atol=1e-12)
    breasts = np.concatenate([rig.regions["breast_L"], rig.regions["breast_R"]])
    assert not np.delete(moved, breasts, axis=0).any()
    assert moved[:, 2].max() == pytest.approx(0.06)

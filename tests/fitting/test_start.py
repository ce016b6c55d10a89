"""Where a fit starts."""

import numpy as np
import pytest

from breastrig.core.errors import BadLandmarks, BadSettings
from breastrig.fitting.recipe import load_recipe, preset_names
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig.rig.skinning import pose


def test_umeyama_recovers_a_similarity(rng: np.random.Generator) -> None:
    source = rng.normal(size=(7, 3))
    rotation, scale, shift = exp_so3(rng.normal(size=3)), 1.3, rng.normal(size=3)
    found = umeyama(source, scale * source @ rotation.T + shift)
    np.testing.assert_allclose(found.rotation, rotation, atol=1e-12)
    np.testing.assert_allclose(found.translation, shift, atol=1e-12)
    assert abs(found.scale - scale) < 1e-12


def test_a_mirrored_patient_is_met_by_a_rotation_and_never_by_a_reflection(rng: np.random.Generator) -> None:
    source = rng.normal(size=(7, 3))
    assert abs(np.linalg.det(umeyama(source, source * [-1, 1, 1]).rotation) - 1.0) < 1e-12


def test_landmarks_on_one_line_are_refused() -> None:
    line = np.outer(np.arange(4.0), [1.0, 2.0, 3.0])
    with pytest.raises(BadLandmarks, match="on one line"):
        umeyama(line, line)


def test_the_start_puts_the_models_landmarks_on_the_picked_ones(toy_rig: Rig, rng: np.random.Generator) -> None:
    rotation, shift = exp_so3(rng.normal(size=3)), rng.normal(size=3)
    model = toy_rig.landmark_points().positions(toy_rig.template, toy_rig.faces)
    picked = dict(zip(toy_rig.landmark_names, 1.1 * model @ rotation.T + shift, strict=True))
    posed = pose(toy_rig, start_from_landmarks(toy_rig, picked))
    np.testing.assert_allclose(posed, 1.1 * toy_rig.template @ rotation.T + shift, atol=1e-9)


def test_every_preset_loads_and_knows_its_name() -> None:
    assert set(preset_names()) >= {"default", "paper"}
    for name in preset_names():
        assert load_recipe(name).name == name


def test_a_wrong_preset_is_named_with_the_right_ones() -> None:
    with pytest.raises(BadSettings, match=r"shapes\.symetry_sigma is no setting; `breastrig presets show default`"):
        load_recipe({"shapes": {"symetry_sigma": 0.5}})
    with pytest.raises(BadSettings, match='"fast" is not a preset; known are: default, paper'):
        load_recipe("fast")


def test_a_broken_preset_file_says_where(tmp_path) -> None:
    (tmp_path / "mine.toml").write_text('name = "mine"\ndescription = ""\ndamping = -1\n')
    with pytest.raises(BadSettings, match="damping"):
        load_recipe(tmp_path / "mine.toml")

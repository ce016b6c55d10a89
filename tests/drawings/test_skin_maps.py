"""The numbers of the skin map are data: common ones, and what a rig knows of how far off carried points are."""

from dataclasses import replace

import pytest
from helpers.toy_rig import toy_rig

from breastrig.core.errors import BadModel
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.gltf.read_rig import default_rig_path, read_rig


def test_a_rig_without_settings_of_its_own_has_the_common_ones_and_no_errors() -> None:
    common, torso = skin_map_settings(toy_rig()), skin_map_settings(read_rig(default_rig_path()))
    errors = {"error_share", "error_skin"}
    assert set(common.model_dump(include=errors).values()) == {None}
    assert common.wall_error == {}
    assert set(torso.wall_error) == {"standing", "supine", "prone"}
    assert None not in torso.model_dump(include=errors).values()
    assert torso.inside_depth_share < common.inside_depth_share == 1.0
    assert torso.error_hanging > common.error_hanging == 0.0
    measured = errors | {"error_hanging", "inside_depth_share", "wall_error"}
    assert common.model_dump(exclude=measured) == torso.model_dump(exclude=measured)


def test_a_rig_may_know_better_and_a_damaged_file_is_one_sentence() -> None:
    assert skin_map_settings(replace(toy_rig(), known={"skin_map.toml": "rounds = 2"})).rounds == 2
    with pytest.raises(BadModel, match=r"toy.known/skin_map.toml cannot be used: rounds: .*\.$"):
        skin_map_settings(replace(toy_rig(), known={"skin_map.toml": "rounds = 0"}))
    with pytest.raises(BadModel, match=r"toy.known/skin_map.toml cannot be read \(.*\); mend it or take it away\.$"):
        skin_map_settings(replace(toy_rig(), known={"skin_map.toml": "rounds ="}))


def test_surface_matches_lose_trust_before_they_are_out_of_reach() -> None:
    settings = skin_map_settings(toy_rig())
    assert settings.surface_scale < settings.to_scan_distance
    assert settings.rounds >= 2

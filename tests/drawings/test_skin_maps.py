"""The numbers of the skin map are data: each rig's own, the torso's where a rig has none."""

from breastrig.drawings.skin_maps.settings import skin_map_settings


def test_a_rig_without_settings_of_its_own_is_mapped_like_the_torso() -> None:
    assert skin_map_settings("toy") == skin_map_settings("torso")
    assert skin_map_settings("../../secret") == skin_map_settings("torso")


def test_surface_matches_lose_trust_before_they_are_out_of_reach() -> None:
    settings = skin_map_settings("torso")
    assert settings.surface_scale < settings.to_scan_distance
    assert settings.rounds >= 2

from pathlib import Path

import pytest

from breastrig.core import assets


def test_a_checkout_has_its_folders_in_their_places(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(assets, "PACKAGE", tmp_path / "server" / "breastrig")
    assert assets.asset_folder("model") == tmp_path / "model_assets" / "built"
    assert assets.asset_folder("example") == tmp_path / "model_assets" / "example"
    assert assets.asset_folder("example") == tmp_path / "model_assets" / "example"
    assert assets.asset_folder("web") == tmp_path / "web" / "dist"


def test_the_wheels_own_folder_wins(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(assets, "PACKAGE", tmp_path / "breastrig")
    packaged = tmp_path / "breastrig" / "assets" / "web"
    packaged.mkdir(parents=True)
    assert assets.asset_folder("web") == packaged

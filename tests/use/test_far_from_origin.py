"""A scan ten kilometres from the origin is fitted as the same scan at home, in every file that the fit leaves."""

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.gltf_evaluator import GltfScene

from breastrig.core.assets import asset_folder
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.read import read_scan
from breastrig.use.fit import run_fit
from breastrig.use.steps.settings import FitJob

EXAMPLE = asset_folder("example") / "standing"
FAR = np.array([10_000.0, -3_000.0, 7_000.0])  # m
EXACT = 1e-5  # m


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The example's fit at home and far away, from text files that hold all digits."""
    scan = read_scan(EXAMPLE / "scan.ply")
    picks, unit = read_landmarks(EXAMPLE / "landmarks.json")
    assert unit == "mm"
    folders = {}
    for name, shift in (("home", np.zeros(3)), ("far", FAR)):
        folder = tmp_path_factory.mktemp(name)
        lines = ["v {:.9f} {:.9f} {:.9f}".format(*place) for place in scan.vertices + shift]
        lines += ["f {} {} {}".format(*(corners + 1)) for corners in scan.faces]
        (folder / "scan.obj").write_text("\n".join([*lines, ""]))
        landmarks = {pick: (place + 1e3 * shift).tolist() for pick, place in picks.items()}
        *_, last = run_fit(FitJob(folder / "scan.obj", folder / "out", landmarks))
        assert last.kind == "done"
        folders[name] = folder / "out"
    return folders


def apart(folders: dict[str, Path], places) -> float:
    """How far (m) the same places of the two fits lie apart, apart from the shift."""
    return float(np.abs(places(folders["far"]) - FAR - places(folders["home"])).max())


def mesh(name: str):
    return lambda folder: read_scan(folder / name, None, "m", texture=False).vertices


@pytest.mark.slow
def test_the_fitted_model_and_the_scan(folders: dict[str, Path]) -> None:
    assert apart(folders, mesh("fitted.ply")) < EXACT
    assert apart(folders, mesh("scan.ply")) < EXACT


def test_the_glb_and_its_last_key(folders: dict[str, Path]) -> None:
    def scene(folder: Path) -> GltfScene:
        return GltfScene((folder / "fitted.glb").read_bytes())

    name = next(node["name"] for node in scene(folders["home"]).nodes if "skin" in node)
    assert apart(folders, lambda folder: scene(folder).positions(name)) < EXACT
    assert apart(folders, lambda folder: scene(folder).at_key("registration", -1).positions(name)) < EXACT
    assert np.abs(scene(folders["far"]).positions(name) - mesh("fitted.ply")(folders["far"])).max() < EXACT


def test_the_numbers_and_what_is_said(folders: dict[str, Path]) -> None:
    home, far = (json.loads((folders[name] / "result.json").read_text()) for name in ("home", "far"))
    for part in ("surface_distance_mm", "scan_to_model_mm"):
        assert far[part] == pytest.approx(home[part], abs=1e-3)
    assert not any("origin" in note for note in home["notes"])
    assert [note for note in far["notes"] if "origin" in note] == [
        "The scan lies 10,000 m from the origin of its coordinates; results are exact there, "
        "but pictures of it may be rounded to 0.98 mm."
    ]

"""`import breastrig` waits for nothing, and every name that it offers is there and says its shapes and units."""

import inspect
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import breastrig
from breastrig.core.assets import asset_folder
from breastrig.core.errors import BreastRigError

SCAN, PICKS = (str(asset_folder("example") / "standing" / name) for name in ("scan.ply", "landmarks.json"))
PLACES = {
    *("find_ink", "fit", "iterates", "propose_landmarks", "propose_marks", "read_scan", "transfer"),
    *("predict", "volume_mesh", "draw", "project", "example"),
}


def modules_after(code: str, folder: Path) -> set[str]:
    """The modules of a fresh process that has run the code; its own and its temporary files would lie in `folder`."""
    command = [sys.executable, "-B", "-W", "error", "-c", f"{code}\nimport sys\nprint(*sys.modules)"]
    surroundings = os.environ | {"TMPDIR": str(folder)}
    run = subprocess.run(command, cwd=folder, env=surroundings, capture_output=True, text=True, check=True)
    return set(run.stdout.split())


def test_importing_the_package_loads_nothing_of_weight(tmp_path: Path) -> None:
    loaded = modules_after("import breastrig\nbreastrig.__version__", tmp_path)
    assert not loaded & {"numpy", "scipy", "flask", "pydantic", "trimesh", "threading"}
    assert {name for name in loaded if name.startswith("breastrig.")} == {"breastrig.core", "breastrig.core.version"}


def test_every_name_is_found_listed_and_loaded_once() -> None:
    assert set(breastrig.__all__) <= set(dir(breastrig))
    assert sorted(breastrig.__all__) == breastrig.__all__
    for name in breastrig.__all__:
        assert getattr(breastrig, name) is getattr(breastrig, name)
    assert set(breastrig._PLACES) | {"__version__"} == set(breastrig.__all__)
    with pytest.raises(AttributeError, match="no attribute 'predicted'"):
        _ = breastrig.predicted


def test_every_function_says_shapes_units_and_errors() -> None:
    functions = {name: value for name in breastrig.__all__ if inspect.isfunction(value := getattr(breastrig, name))}
    others = {"load_model", "measure", "write_report", "write_template", "write_dicom", "send_dicom"}
    assert set(functions) == PLACES | others
    for name, function in functions.items():
        said = inspect.getdoc(function) or ""
        assert "frame" in said or "mm" in said, name
        assert "Raises" in said or "errors are" in said or "see `iterates`" in said, name
        assert all(each.annotation is not each.empty for each in inspect.signature(function).parameters.values()), name
    for name in PLACES:
        assert "unit" in (inspect.getdoc(functions[name]) or ""), name


def test_every_error_that_a_fit_can_raise_is_one_of_ours() -> None:
    errors = [value for name in breastrig.__all__ if inspect.isclass(value := getattr(breastrig, name))]
    errors = [each for each in errors if issubclass(each, Exception)]
    assert len(errors) == 10
    assert all(issubclass(each, BreastRigError) for each in errors)
    with pytest.raises(breastrig.BadInput, match=r"There is no scan file nothing\.ply"):
        breastrig.fit("nothing.ply")
    with pytest.raises(breastrig.BadSettings, match="preset"):
        breastrig.fit(SCAN, preset="fast")
    with pytest.raises(breastrig.BadDrawing, match="flower"):
        breastrig.fit(SCAN, drawing="flower")
    with pytest.raises(breastrig.BadLandmarks, match="three finite numbers"):
        breastrig.fit(SCAN, {"xiphoid": "here"})
    with pytest.raises(breastrig.BadLandmarks, match="three finite numbers"):
        breastrig.fit(SCAN, {"xiphoid": np.zeros((1, 3))})
    with pytest.raises(breastrig.BadModel, match=r"none\.glb"):
        breastrig.fit(SCAN, model="none.glb")

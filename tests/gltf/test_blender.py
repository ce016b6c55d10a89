"""A rig that Blender wrote by its ordinary glTF export is the rig that it opened.

blender/forearm.glb is model_assets/forearm.py's, opened and exported by Blender 5.0.1 (blender/export.py).
"""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from helpers.forearm import write_forearm

from breastrig.cli.main import main
from breastrig.gltf.read_rig import read_rig

KEPT = Path(__file__).parent / "blender"


@pytest.mark.parametrize("fresh", [False, True])
def test_its_export_is_the_rig_that_it_opened(fresh: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ours, _, _ = write_forearm(tmp_path / "ours")
    shutil.copytree(tmp_path / "ours", tmp_path / "its")
    its = tmp_path / "its" / "forearm.glb"
    if fresh:
        blender = shutil.which("blender")
        if blender is None:
            pytest.skip("there is no Blender here")
        script = [blender, "-b", "--python", str(KEPT / "export.py"), "--", str(ours), str(its)]
        subprocess.run(script, check=True, capture_output=True, timeout=300)
    else:
        shutil.copy(KEPT / "forearm.glb", its)
    before, after = read_rig(ours), read_rig(its)
    assert (after.bone_names, after.shape_names) == (before.bone_names, before.shape_names)
    assert np.array_equal(after.faces, before.faces)
    assert np.abs(after.template - before.template).max() < 1e-6
    assert np.abs(after.blendshapes - before.blendshapes).max() < 1e-6
    assert np.abs(after.skin_weights - before.skin_weights).max() < 2e-4  # Blender rounds them
    for ours_bone, its_bone in zip(before.bones, after.bones, strict=True):
        np.testing.assert_allclose(its_bone.origin, ours_bone.origin, atol=1e-6)
        np.testing.assert_allclose(its_bone.rotation, ours_bone.rotation, atol=1e-6)
    assert main(["model", "check", "--model", str(its)]) == 0
    assert "BAD" not in capsys.readouterr().out
